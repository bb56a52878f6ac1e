#!/bin/sh
# osm2gmns 1.0.1: a street with `oneway=-1` becomes a one-way link in the wrong direction, and a middle lane of three is lost.
#
# One would guess: `oneway=-1` means one way against the order of the nodes. A reader knows that and turns the link around, or does not know it
#   and leaves the street open both ways. And a street of three lanes has three lanes in the sum of its two directions.
# What happens: the reader knows the value, so the street is one way; its mark "reversed" is set and never asked for, so the link runs along
#   the nodes. `dir_flag` is 1 as everywhere, nothing is logged. Traffic goes the wrong way, and the right way has no link at all: the way
#   from A to B, for which the street is there, is 1038 m in place of 149 m. `lanes:backward`, which counts the lanes of such a street, is not read.
#   `lanes=3` without `lanes:forward` is 1 and 1; 5 are 2 and 2.
# Source: osm2gmns 1.0.1, src/osmnetwork.cpp (OsmWay::configAttributes sets is_reversed_; osmnetwork.h: "ToDo: use when generating segments"),
#   src/networks.cpp (Link: floor of lanes / 2). OpenStreetMap wiki, Key:oneway.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.11 or newer on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: osm2gmns==1.0.1 osmium==4.3.2 networkx==3.6.1
cat >"$place/run.py" <<'END'
import csv
import os
import sys
from importlib.metadata import version

import networkx
import osm2gmns

os.chdir(sys.argv[1])
# A block: the street 1-2 on its south side, and a detour 1-4-3-2 around it that is open both ways.
NODES = [(1, 48.000, 9.000), (2, 48.000, 9.002), (3, 48.004, 9.002), (4, 48.004, 9.000)]


def links(**tags):
    tags = "".join(f'<tag k="{key.replace("__", ":")}" v="{value}"/>' for key, value in {"highway": "tertiary", **tags}.items())
    with open("block.osm", "w") as file:
        file.write('<?xml version="1.0"?><osm version="0.6" generator="by hand">'
                   + "".join(f'<node id="{n}" version="1" lat="{lat}" lon="{lon}"/>' for n, lat, lon in NODES)
                   + f'<way id="11" version="1"><nd ref="1"/><nd ref="2"/>{tags}</way>'
                   '<way id="12" version="1"><nd ref="1"/><nd ref="4"/><nd ref="3"/><nd ref="2"/><tag k="highway" v="tertiary"/></way></osm>')
    network = osm2gmns.getNetFromFile("block.osm")
    osm2gmns.outputNetToCSV(network, ".")
    with open("node.csv") as file:
        osm = {row["node_id"]: int(row["osm_node_id"]) for row in csv.DictReader(file)}
    with open("link.csv") as file:
        rows = list(csv.DictReader(file))
    graph = networkx.DiGraph()
    for row in rows:
        graph.add_edge(osm[row["from_node_id"]], osm[row["to_node_id"]])
        edge = graph[osm[row["from_node_id"]]][osm[row["to_node_id"]]]
        edge["metres"] = min(edge.get("metres", 1e9), float(row["length"]))
    street = sorted((osm[row["from_node_id"]], osm[row["to_node_id"]], row["lanes"], row["dir_flag"]) for row in rows if row["osm_way_id"] == "11")
    far = [round(networkx.shortest_path_length(graph, a, b, "metres")) for a, b in ((1, 2), (2, 1))]
    return street, far


good = True
shown = []
for name, tags, expected in [
    ("oneway=yes", {"oneway": "yes", "lanes": 2}, ([(1, 2, "2", "1")], [149, 1038])),
    ("oneway=-1", {"oneway": "-1", "lanes": 2}, ([(1, 2, "2", "1")], [149, 1038])),
    ("oneway=-1, lanes:backward=2", {"oneway": "-1", "lanes__backward": 2}, ([(1, 2, "", "1")], [149, 1038])),
    ("two ways, lanes=3", {"lanes": 3}, ([(1, 2, "1", "1"), (2, 1, "1", "1")], [149, 149])),
    ("two ways, lanes=5", {"lanes": 5}, ([(1, 2, "2", "1"), (2, 1, "2", "1")], [149, 149])),
]:
    seen = links(**tags)
    shown.append(f"{name}: (from, to, lanes, dir_flag) {seen[0]}; metres from 1 to 2 and back {seen[1]}")
    good &= seen == expected
print("osm2gmns", version("osm2gmns"))
print(*shown, sep="\n")
raise SystemExit(0 if good else 1)
END
"$place/env/bin/python" "$place/run.py" "$place" 2>/dev/null
