#!/bin/sh
# SUMO's netconvert 1.28.0, told that traffic drives on the left, gives OSM's `change:lanes` to the wrong lanes.
#
# One would guess: per-lane tags of OpenStreetMap are listed from left to right wherever one drives, and `--lefthand` counts lanes from the
#   left; so all per-lane tags land on the lanes for which they were drawn, as `width:lanes` and `turn:lanes` do.
# What happens: widths come out in the right order, permissions to change lanes do not. They are dealt out from the right, as in
#   right-hand traffic: of `no|not_left|yes` the left lane gets `yes`, the right lane `no`. The solid line lies between the wrong lanes,
#   and vehicles in the simulation keep to it. Exit 0, no word of it. Without `--lefthand` the same file is right.
# Source: key `change` of the OSM wiki; netconvert's NIImporter_OpenStreetMap.cpp, applyChangeProhibition (issue 13549 was the same for
#   `turn:lanes`); wheels of PyPI.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check eclipse-sumo==1.28.0 libsumo==1.28.0
# One road to the east. The left lane is closed off by a solid line, between the middle and the right one all may change.
cat >"$place/road.osm" <<'END'
<?xml version="1.0"?>
<osm version="0.6" generator="by hand">
  <node id="1" version="1" lat="51.0" lon="-1.00"/><node id="2" version="1" lat="51.0" lon="-0.98"/>
  <way id="3" version="1">
    <nd ref="1"/><nd ref="2"/>
    <tag k="highway" v="motorway"/><tag k="oneway" v="yes"/><tag k="lanes" v="3"/>
    <tag k="width:lanes" v="3|4|5"/><tag k="change:lanes" v="no|not_left|yes"/>
  </way>
</osm>
END
cat >"$place/run.py" <<'END'
import os, subprocess, sys, xml.etree.ElementTree as ET
import libsumo, sumo

source, net = sys.argv[1:]
program = os.path.join(os.path.dirname(sumo.__file__), "bin", "")
names = "left", "middle", "right"
wishes = [(0, 1), (1, 0), (1, 2), (2, 1)]


def changes(start, to):
    """Whether a vehicle that is told to change the lane, and to heed nothing but the map, does so."""
    libsumo.start([program + "sumo", "-n", net, "--no-step-log", "--no-warnings"])
    libsumo.route.add("road", ["3"])
    libsumo.vehicle.add("car", "road", departLane=start, departSpeed="10")
    libsumo.simulationStep()
    libsumo.vehicle.setLaneChangeMode("car", 0)
    libsumo.vehicle.changeLane("car", int(to), 100)
    for _ in range(10):
        libsumo.simulationStep()
    done = libsumo.vehicle.getLaneIndex("car") == int(to)
    libsumo.close()
    return done


def seen(*options):
    subprocess.run([program + "netconvert", "--osm-files", source, "-o", net, *options], check=True, stdout=subprocess.DEVNULL)
    lanes = next(e for e in ET.parse(net).getroot().iter("edge") if e.get("id") == "3").findall("lane")
    # the road leads to the east: left is where y is largest
    lanes.sort(key=lambda lane: -float(lane.get("shape").split()[0].split(",")[1]))
    index = [lane.get("index") for lane in lanes]
    opened = [f"{names[a]} to {names[b]}" for a, b in wishes if changes(index[a], index[b])]
    print(*options or ["right-hand"], "\n  widths from the left:", [lane.get("width") for lane in lanes], "\n  changes:", opened)
    return [lane.get("width") for lane in lanes], opened


widths = ["3.00", "4.00", "5.00"]
right = seen() == (widths, ["middle to right", "right to middle"])
left = seen("--lefthand") == (widths, ["left to middle", "middle to right"])
raise SystemExit(0 if right and left else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/road.osm" "$place/road.net.xml"
# Seen:
#   right-hand
#     widths from the left: ['3.00', '4.00', '5.00']
#     changes: ['middle to right', 'right to middle']
#   --lefthand
#     widths from the left: ['3.00', '4.00', '5.00']
#     changes: ['left to middle', 'middle to right']
