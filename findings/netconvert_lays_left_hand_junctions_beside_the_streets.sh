#!/bin/sh
# SUMO's netconvert 1.28.0, told that traffic drives on the left, writes an OpenDRIVE map whose lanes across junctions stand under `<left>` with
# negative ids. CARLA 0.9.16 drives straight on; for pyxodr 0.1.3 the lanes across the junction lie 3.2 m and 9.6 m beside the street.
#
# One would guess: `--lefthand` mirrors the map and `--opendrive-output` writes it as in right-hand traffic: each direction is a road of its own,
#   its lanes to the right of the line under `<right>`, with ids from -1 on. So it is with the streets. Where a lane ends, the linked one begins.
# What happens: streets are right. For the roads across a junction the reference line is the left border and the ids are negative, as in
#   streets, but they are put under `<left>`, and before the centre lane. By the standard, ids left of the line are positive.
#   Who goes by the id has the lanes where they should be. Who goes by the element mirrors them at the line: of a
#   crossing of streets with two lanes, lane -1 is one width beside its place, lane -2 three. All crossings of a map are
#   hit; neither program says a word. There is no `rule="LHT"`. Without `--lefthand` both readers find the same places.
# Source: SUMO, src/netwrite/NWWriter_OpenDrive.cpp (writeInternalEdge: the side is chosen by `lefthand`); ASAM OpenDRIVE 1.8, lanes (lane
#   numbering: positive on the left, negative on the right of the centre lane); pyxodr, road_objects/lane_section.py; wheels of PyPI.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 to 3.12 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile eclipse-sumo==1.28.0 carla==0.9.16 pyxodr==0.1.3
cat >"$place/run.py" <<'END'
import importlib.metadata
import math
import os
import subprocess
import sys
import xml.etree.ElementTree as ET

import carla
import pyxodr.road_objects.network
import sumo

os.chdir(sys.argv[1])
# Two streets with two lanes each way cross; from each arm one may drive on to the other three.
arms = {"west": (-200, 0), "east": (200, 0), "north": (0, 200), "south": (0, -200)}
with open("nodes.xml", "w") as file:
    file.write('<nodes><node id="middle" x="0" y="0"/>' + "".join(f'<node id="{a}" x="{x}" y="{y}"/>' for a, (x, y) in arms.items()) + "</nodes>")
with open("edges.xml", "w") as file:
    file.write("<edges>" + "".join(f'<edge id="from_{a}" from="{a}" to="middle" numLanes="2"/>'
                                   f'<edge id="to_{a}" from="middle" to="{a}" numLanes="2"/>' for a in arms) + "</edges>")


def gaps(place_of, across):
    """The distances from the end of a lane to the lane across the junction that it leads to, in a sorted list without repetition."""
    found = set()
    for road in across:
        before = road.find("link/predecessor").get("elementId")
        for lane in road.iter("lane"):
            if lane.get("id") != "0":
                end = place_of(before, lane.find("link/predecessor").get("id"))[1]
                found.add(round(math.dist(end, place_of(road.get("id"), lane.get("id"))[0]), 1))
    return sorted(found)


print(*(f"{name} {importlib.metadata.version(name)}" for name in ("eclipse-sumo", "carla", "pyxodr")))
so = True
for side in "right", "left":
    subprocess.run([os.path.join(os.path.dirname(sumo.__file__), "bin", "netconvert"), "-n", "nodes.xml", "-e", "edges.xml", "--no-turnarounds",
                    f"--lefthand={side == 'left'}", "--opendrive-output", "map.xodr"], check=True, stdout=subprocess.DEVNULL)
    roads = list(ET.parse("map.xodr").getroot().iter("road"))
    across = [road for road in roads if road.get("junction") != "-1"]
    signs = {kind: sorted({(element.tag, "negative" if int(lane.get("id")) < 0 else "positive")
                           for road in group for element in road.iter() if element.tag in ("left", "right") for lane in element})
             for kind, group in (("streets", [road for road in roads if road not in across]), ("junction", across))}
    carla_map = carla.Map("map", open("map.xodr").read())
    lanes = {(str(road.id), str(lane.id)): lane for road in pyxodr.road_objects.network.RoadNetwork("map.xodr").get_roads()
             for section in road.lane_sections for lane in section.lanes}
    length = {road.get("id"): float(road.get("length")) for road in roads}

    def in_carla(road, lane):
        ends = [carla_map.get_waypoint_xodr(int(road), int(lane), s).transform.location for s in (0.001, length[road] - 0.001)]
        return [(point.x, -point.y) for point in ends]

    def in_pyxodr(road, lane):
        line = lanes[road, lane].centre_line
        return [tuple(line[0][:2]), tuple(line[-1][:2])]

    seen = gaps(in_carla, across), gaps(in_pyxodr, across)
    print(f"traffic on the {side}: {signs}\n  from a street's lane to its lane across the junction, in metres: CARLA {seen[0]}, pyxodr {seen[1]}")
    so &= signs == {"streets": [("right", "negative")], "junction": [(side, "negative")]}
    so &= seen == ([0.0], [0.0] if side == "right" else [3.2, 9.6])
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place" 2>"$place/log" || { cat "$place/log" >&2; exit 1; }
# Seen:
#   eclipse-sumo 1.28.0 carla 0.9.16 pyxodr 0.1.3
#   traffic on the right: {'streets': [('right', 'negative')], 'junction': [('right', 'negative')]}
#     from a street's lane to its lane across the junction, in metres: CARLA [0.0], pyxodr [0.0]
#   traffic on the left: {'streets': [('right', 'negative')], 'junction': [('left', 'negative')]}
#     from a street's lane to its lane across the junction, in metres: CARLA [0.0], pyxodr [3.2, 9.6]
