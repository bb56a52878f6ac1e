#!/bin/sh
# osm-map-merger 2025.1: of two Lanelet2 maps 1.1 km apart, both numbered from -1, one lands on the other, or a lanelet 1.1 km wide spans both;
# so it is with any two maps that the tool itself has numbered before.
#
# One would guess: the tool is, as its summary says, for maps that were modeled separately and have negative ids, and hands out new ids from one
#   on; each object of each file gets an id of its own, for it is the ids of separate drafts that clash.
# What happens: the table from old ids to new ones is kept from file to file, so that -1 of the first map and -1 of the second get
#   the same new id. Both are written; readers keep one of them. Lanelet2 takes the later node, so that the lanelet of one map is
#   drawn with the points of the other, and which of them is wrong depends on the order of the input files. Exit 0, no warning.
#   And a way that was deleted in JOSM takes along the node of the same number, though OSM numbers nodes and ways apart from each other.
#   A way out: shift the ids of one file before. To run the tool on each file first does not help, as both then begin at 1.
# Source: osm_map_merger/__main__.py (apply_redistribute: one IdCounter for all files), id_generator.py (IdCounter), util.py
#   (get_action_delete_ids); readme and summary of release 2025.1.
# Exits 0 while it is so, 1 if that changes, 2 if it cannot be installed. Needs CPython 3.10 to 3.13 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
{ python3 -m venv "$place/env" && "$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --only-binary :all: \
  osm-map-merger==2025.1 osmium==4.3.2 lanelet2==1.2.3 lxml==6.1.3 beautifulsoup4==4.15.0 click==8.5.1; } ||
  { echo "osm-map-merger 2025.1 or lanelet2 1.2.3 cannot be installed here: they need CPython 3.10 to 3.13 on Linux and PyPI" >&2; exit 2; }
cat >"$place/run.py" <<'END'
import importlib.metadata
import itertools
import pathlib
import subprocess
import sys

import lanelet2
import osmium
from lanelet2.projection import UtmProjector

place = pathlib.Path(sys.argv[1])


def draft(name, latitude, lanes, first=-1):
    """Lanelets of 110 m side by side; all that is new has a negative id, counted down from `first`."""
    ids, text = itertools.count(first, -1), []
    nodes, ways = [], []
    for line in range(lanes + 1):
        nodes.append([next(ids), next(ids)])
        for node, longitude in zip(nodes[-1], (8, 8.0015)):
            text.append(f'<node id="{node}" action="modify" visible="true" lat="{latitude - line * 0.00003:.7f}" lon="{longitude}"/>')
    for pair in nodes:
        ways.append(next(ids))
        text.append(f'<way id="{ways[-1]}" action="modify" visible="true"><nd ref="{pair[0]}"/><nd ref="{pair[1]}"/>'
                    '<tag k="type" v="line_thin"/><tag k="subtype" v="dashed"/></way>')
    for number, (left, right) in enumerate(zip(ways, ways[1:]), 1):
        text.append(f'<relation id="{next(ids)}" action="modify" visible="true"><member type="way" ref="{left}" role="left"/>'
                    f'<member type="way" ref="{right}" role="right"/><tag k="type" v="lanelet"/><tag k="subtype" v="road"/>'
                    f'<tag k="location" v="urban"/><tag k="name" v="{name} {number}"/></relation>')
    write(name, "".join(text))


def write(name, text):
    (place / f"{name}.osm").write_text(f'<?xml version="1.0"?><osm version="0.6" generator="JOSM">{text}</osm>')


def merge(out, *names):
    inputs = [part for name in names for part in ("--input", place / f"{name}.osm")]
    done = subprocess.run([sys.executable, "-m", "osm_map_merger", "--force", *inputs, "--output", place / f"{out}.osm"],
                          check=True, capture_output=True, text=True)
    assert done.stdout == done.stderr == ""


def lanelets(name):
    """How many metres to the north of the origin the left and the right bound of each lanelet lie, in hundreds."""
    loaded = lanelet2.io.load(str(place / f"{name}.osm"), UtmProjector(lanelet2.io.Origin(49, 8)))
    return {lane.attributes["name"]: tuple(round(bound[0].y / 100) * 100 for bound in (lane.leftBound, lane.rightBound))
            for lane in sorted(loaded.laneletLayer, key=lambda lane: lane.attributes["name"])}


print(*(f"{name} {importlib.metadata.version(name)}" for name in ("osm-map-merger", "osmium", "lanelet2")))
draft("south", 49.00, 1)
draft("north", 49.01, 2)
draft("other", 49.01, 2, first=-1001)
merge("tidy south", "south")
merge("tidy other", "other")
south, north, other = ({f"{name} {number}": (far, far) for number in range(1, count + 1)}
                       for name, count, far in (("south", 1, 0), ("north", 2, 1100), ("other", 2, 1100)))
so = lanelets("tidy south") == south and lanelets("tidy other") == other
for names, expected in [(("south", "other"), {**other, **south}), (("south", "north"), {**north, "south 1": (1100, 1100)}),
                        (("north", "south"), {"north 1": (0, 0), "north 2": (0, 1100), **south}),
                        (("tidy south", "tidy other"), {**other, "south 1": (1100, 1100)})]:
    merge("merged", *names)
    found = lanelets("merged")
    ids = [item.id for item in osmium.FileProcessor(place / "merged.osm") if item.is_node()]
    print(" + ".join(names) + ":", found, f"{len(ids)} nodes with {len(set(ids))} ids")
    so &= found == expected and len(ids) == 10 and len(set(ids)) == (10 if "other" in names else 6)

# Way 2 was deleted, node 2 was not: the middle of the bend that way 4 goes around.
write("bend", "".join(f'<node id="{node}" version="1" lat="{lat}" lon="{lon}"/>' for node, lat, lon in [(1, 49, 8), (2, 49.001, 8), (3, 49.001, 8.001)])
      + '<way id="2" version="1" action="delete"><nd ref="1"/><nd ref="3"/></way>'
      '<way id="4" version="1"><nd ref="1"/><nd ref="2"/><nd ref="3"/><tag k="type" v="line_thin"/></way>')
merge("merged", "bend")
left = [len(item.nodes) for item in osmium.FileProcessor(place / "merged.osm") if item.is_way()]
print("way 2 deleted, node 2 not: points of way 4, once three:", left)
so &= left == [2]
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   osm-map-merger 2025.1 osmium 4.3.2 lanelet2 1.2.3
#   south + other: {'other 1': (1100, 1100), 'other 2': (1100, 1100), 'south 1': (0, 0)} 10 nodes with 10 ids
#   south + north: {'north 1': (1100, 1100), 'north 2': (1100, 1100), 'south 1': (1100, 1100)} 10 nodes with 6 ids
#   north + south: {'north 1': (0, 0), 'north 2': (0, 1100), 'south 1': (0, 0)} 10 nodes with 6 ids
#   tidy south + tidy other: {'other 1': (1100, 1100), 'other 2': (1100, 1100), 'south 1': (1100, 1100)} 10 nodes with 6 ids
#   way 2 deleted, node 2 not: points of way 4, once three: [2]
