#!/bin/sh
# OSMnx 2.1.1: a carriageway of a motorway without `oneway` is open both ways, and so is a round crossing of `junction=circular`; the shortest way
# home leads 1.5 km up the motorway against the traffic.
#
# One would guess: `highway=motorway` is one way by itself, as `junction=roundabout` is, which OSMnx does know; the wiki of OpenStreetMap says that one
#   need not write `oneway=yes` there. pyroutelib3 2.0.0, which is smaller by far, and routers take it for granted.
# What happens: `graph_from_…` asks for the tag `oneway` and for `junction=roundabout`, and for nothing else. All other ways get an edge for each
#   direction, with `oneway` False. So it is with the values of the tag that it knows: `yes`, `true`, `1`, `-1`, `reverse`, `T`, `F`. Each
#   carriageway of a motorway is a road of its own, so that where mappers left the tag out, both are two-way roads side by side:
#   lanes in both directions on each, and routes that enter by the exit. There is no warning.
# Source: osmnx/graph.py (_is_path_one_way), release 2.1.1; OSM wiki, Key:oneway (implied oneway restriction: roundabouts, motorways);
#   pyroutelib3/osm/profile.py (way_direction).
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.11 or newer.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile osmnx==2.1.1 pyroutelib3==2.0.0
cat >"$place/run.py" <<'END'
import importlib.metadata
import sys

import networkx
import osmnx
import pyroutelib3

# The carriageway to the east, 1.5 km, and a country road that makes a bend to the north between its ends.
nodes = {1: (48.0, 9.0), 2: (48.0, 9.01), 3: (48.0, 9.02), 4: (48.01, 9.0), 5: (48.01, 9.02)}
ring = {6: (48.0105, 9.0205), 7: (48.0105, 9.0210), 8: (48.0100, 9.0210)}
nodes.update(ring)


def graphs(oneway):
    """The edges of each library's graph for cars, and the shortest way from 3 to 1 in OSMnx."""
    def way(number, refs, **tags):
        return (f'<way id="{number}" version="1">' + "".join(f'<nd ref="{ref}"/>' for ref in refs)
                + "".join(f'<tag k="{key}" v="{value}"/>' for key, value in tags.items()) + "</way>")
    path = sys.argv[1] + "/map.osm"
    with open(path, "w") as file:
        file.write('<?xml version="1.0"?><osm version="0.6">' + "".join(
            f'<node id="{number}" version="1" lat="{lat}" lon="{lon}"/>' for number, (lat, lon) in nodes.items())
            + way(1, [1, 2, 3], highway="motorway", **oneway) + way(2, [1, 4, 5, 3], highway="primary")
            + way(3, [5, 8, 7, 6, 5], highway="primary", junction="circular", **oneway) + "</osm>")
    graph = osmnx.graph_from_xml(path, simplify=False, retain_all=True)
    home = networkx.shortest_path(graph, 3, 1, weight="length")
    length = networkx.shortest_path_length(graph, 3, 1, weight="length")
    with open(path, "rb") as file:
        other = pyroutelib3.osm.Graph.from_file(pyroutelib3.osm.CarProfile(), file)
    return set(graph.edges()), {(a, b) for a in other.nodes for b, _ in other.get_edges(a)}, home, round(length)


print(*(f"{name} {importlib.metadata.version(name)}" for name in ("osmnx", "pyroutelib3")))
results = []
for oneway in {}, {"oneway": "yes"}:
    for name, edges in zip(("OSMnx", "pyroutelib3"), (found := graphs(oneway))[:2]):
        results.append(((2, 1) in edges, (7, 8) in edges))
        print(f"{'with' if oneway else 'without'} oneway=yes, {name}: against the motorway {results[-1][0]}, against the ring {results[-1][1]}")
    results.append((found[2], found[3]))
    print(f"  OSMnx, shortest way home: {found[2]}, {found[3]} m")
both, none = (True, True), (False, False)
so = results == [both, none, ([3, 2, 1], 1488), none, none, ([3, 5, 4, 1], 3712)]
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   osmnx 2.1.1 pyroutelib3 2.0.0
#   without oneway=yes, OSMnx: against the motorway True, against the ring True
#   without oneway=yes, pyroutelib3: against the motorway False, against the ring False
#     OSMnx, shortest way home: [3, 2, 1], 1488 m
#   with oneway=yes, OSMnx: against the motorway False, against the ring False
#   with oneway=yes, pyroutelib3: against the motorway False, against the ring False
#     OSMnx, shortest way home: [3, 5, 4, 1], 3712 m
