#!/bin/sh
# MetaDrive 0.4.3, from OpenStreetMap by way of SUMO's netconvert 1.28.0: railways and cycle paths are lanes for cars; a street in which a tram
# runs has no lane at all.
#
# One would guess: a network of SUMO says for each lane who may use it (`allow`, `disallow`); lanes open to cars become lanes, all of them and
#   no others.
# What happens: who may use a lane is asked only to tell pavements from the rest. What is not for those on foot alone is "driving", be it
#   `allow="rail"` or `allow="bicycle"`. But where the type of the edge has a `|` in it, the parts of the type are taken for the kinds of the
#   lanes, counted from the right; netconvert writes such a type where it has joined two types, as `highway.secondary|railway.tram` for a
#   street with rails. Then the first lane is of kind "highway.secondary", which is no known kind, and is left out without a word. Its yellow
#   centre line stays. A third lane would have no kind to take, which is an IndexError.
# Source: metadrive-simulator 0.4.3, metadrive/utils/sumo/map_utils.py (LaneNode, extract_map_features), which SumoMapManager
#   (metadrive/manager/sumo_map_manager.py) calls; eclipse-sumo 1.28.0, sumolib 1.28.0.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.11 or newer on Linux. Of its dependencies MetaDrive gets those that maps need, and
#   its two outer packages are entered without their __init__.py, which would load the graphics.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
get() {
  "$place/env/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: "$@"
}
get sumolib==1.28.0 eclipse-sumo==1.28.0 numpy==2.4.6 scipy==1.17.1 shapely==2.2.0
get --no-deps metadrive-simulator==0.4.3
cat >"$place/run.py" <<'END'
import importlib.metadata
import subprocess
import sys
import types
from importlib.metadata import version

import sumolib

root = importlib.metadata.distribution("metadrive-simulator").locate_file("metadrive")
for name, folder in (("metadrive", root), ("metadrive.utils", root / "utils")):
    sys.modules[name] = types.ModuleType(name)
    sys.modules[name].__path__ = [str(folder)]
from metadrive.utils.sumo.map_utils import RoadLaneJunctionGraph, extract_map_features  # noqa: E402

osm, net = sys.argv[1] + "/town.osm", sys.argv[1] + "/town.net.xml"
WAYS = {  # one way each, 300 m from west to east, 100 m apart, all open in both directions but the railway
    "1": {"highway": "secondary"},
    "2": {"highway": "secondary", "railway": "tram"},
    "3": {"railway": "rail"},
    "4": {"highway": "cycleway"},
}
with open(osm, "w") as file:
    print('<?xml version="1.0"?><osm version="0.6" generator="by hand">', file=file)
    for way in WAYS:
        for end, lon in (("1", 9.0), ("2", 9.004)):
            print(f'<node id="{way}{end}" version="1" lat="{48 + int(way) / 1000}" lon="{lon}"/>', file=file)
    for way, tags in WAYS.items():
        tags = "".join(f'<tag k="{key}" v="{value}"/>' for key, value in tags.items())
        print(f'<way id="{way}" version="1"><nd ref="{way}1"/><nd ref="{way}2"/>{tags}</way>', file=file)
    print("</osm>", file=file)
netconvert = sys.argv[1] + "/env/bin/netconvert"
subprocess.run([netconvert, "--osm-files", osm, "--output-file", net, "--osm.sidewalks"], check=True, stdout=subprocess.DEVNULL)

cars, types = {}, {}
for edge in sumolib.net.readNet(net).getEdges():
    types[edge.getID()] = edge.getType()
    for lane in edge.getLanes():
        cars[lane.getID()] = lane.allows("passenger")
features = extract_map_features(RoadLaneJunctionGraph(net))
lanes = {name: features["lane_" + name]["type"] if "lane_" + name in features else None for name in cars}
lines = sorted(round(sum(p[1] for p in f["polyline"]) / len(f["polyline"]) / 100) for f in features.values() if "YELLOW" in f["type"])
print("metadrive", version("metadrive-simulator"), "- netconvert", version("eclipse-sumo"))
for name in sorted(cars):
    print(f"lane {name} of {types[name[:-2]]}: for cars in SUMO {cars[name]}, in MetaDrive {lanes[name]}")
print("yellow centre lines:", len(lines))
good = lanes == {
    "1_0": "LANE_SURFACE_STREET", "-1_0": "LANE_SURFACE_STREET",
    "2_0": None, "-2_0": None,
    "3_0": "LANE_SURFACE_STREET",
    "4_0": "LANE_SURFACE_STREET", "-4_0": "LANE_SURFACE_STREET",
}
good &= cars == {"1_0": True, "-1_0": True, "2_0": True, "-2_0": True, "3_0": False, "4_0": False, "-4_0": False}
good &= types["2"] == "highway.secondary|railway.tram" and len(lines) == 3  # of ways 1, 2 and 4
raise SystemExit(0 if good else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
