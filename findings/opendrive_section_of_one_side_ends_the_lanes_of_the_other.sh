#!/bin/sh
# An OpenDRIVE lane section of one side (`singleSide="true"`, here a second lane begins on the right): netconvert 1.28.0, CARLA 0.9.16 and
# pyxodr 0.1.3 end the oncoming lane there, though nothing has changed on its side.
#
# One would guess: a section of one side says nothing about the other; the lanes there go on as their own last section has them. The attribute is in
#   the standard since before ASAM took it over, and saves writing ten lanes anew where one of the other side begins.
# What happens: the attribute is not read. Each section is taken to be complete, and what is not in it is not on the road: from 50 m on there is
#   no lane on the left. netconvert makes an edge for the oncoming traffic of the first half alone, so that nobody can get on it from
#   the far end; CARLA has no waypoint in the second half. No program says a word. The same road with the oncoming lane written in both
#   sections is whole for all three.
# Source: ASAM OpenDRIVE 1.8, 11.3 lane sections (figure "defined separately for both sides of the road", @singleSide: valid for one side
#   only); the programs as wheels of PyPI.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 to 3.12 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile eclipse-sumo==1.28.0 carla==0.9.16 pyxodr==0.1.3
cat >"$place/run.py" <<'END'
import importlib.metadata
import os
import subprocess
import sys
import xml.etree.ElementTree as ET

import carla
import pyxodr.road_objects.network
import sumo

os.chdir(sys.argv[1])


def lane(number, links=""):
    return f'<lane id="{number}" type="driving" level="false"><link>{links}</link><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'


def road(single):
    """100 m to the east; from 50 m on, two lanes on the right, one on the left as before."""
    centre = '<center><lane id="0" type="none" level="false"/></center>'
    first = f'<left>{lane(1, "" if single else "<successor id=" + chr(34) + "1" + chr(34) + "/>")}</left>'
    first += centre + "<right>" + lane(-1, '<successor id="-1"/>') + "</right>"
    second = "" if single else "<left>" + lane(1, '<predecessor id="1"/>') + "</left>"
    second += centre + "<right>" + lane(-1, '<predecessor id="-1"/>') + lane(-2) + "</right>"
    with open("road.xodr", "w") as file:
        file.write('<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="8" name="" version="1" date="" north="0" south="0" east="0" west="0" '
                   'vendor=""/><road name="" length="100" id="1" junction="-1"><link/><planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/>'
                   f'</geometry></planView><elevationProfile/><lateralProfile/><lanes><laneSection s="0">{first}</laneSection><laneSection s="50"'
                   + (' singleSide="true"' if single else "") + f">{second}</laneSection></lanes></road></OpenDRIVE>")


def lanes_at(x):
    """The middles of the lanes at this place, from left to right, for each program."""
    found = {"netconvert": set(), "CARLA": set(), "pyxodr": set()}
    for item in ET.parse("road.net.xml").getroot().iter("lane"):
        if not item.get("id").startswith(":"):
            (x0, y), (x1, _) = (map(float, point.split(",")) for point in item.get("shape").split())
            if min(x0, x1) <= x <= max(x0, x1):
                found["netconvert"].add(y)
    map_ = carla.Map("road", open("road.xodr").read())
    for number in 2, 1, -1, -2:
        if waypoint := map_.get_waypoint_xodr(1, number, x):
            found["CARLA"].add(round(-waypoint.transform.location.y, 2))
    for item in pyxodr.road_objects.network.RoadNetwork("road.xodr").get_roads()[0].lane_sections:
        for one in item.lanes:
            if min(one.centre_line[:, 0]) <= x <= max(one.centre_line[:, 0]):
                found["pyxodr"].add(round(float(one.centre_line[0][1]), 2))
    return {name: sorted(places, reverse=True) for name, places in found.items()}


print(*(f"{name} {importlib.metadata.version(name)}" for name in ("eclipse-sumo", "carla", "pyxodr")))
so = True
for single in False, True:
    road(single)
    subprocess.run([os.path.join(os.path.dirname(sumo.__file__), "bin", "netconvert"), "--opendrive", "road.xodr", "-o", "road.net.xml",
                    "--offset.disable-normalization"], check=True, stdout=subprocess.DEVNULL)
    print("second section for the right side only:" if single else "second section for both sides:")
    for x in 25, 75:
        seen = lanes_at(x)
        print(f"  lanes at {x} m, y:", seen)
        so &= set(map(tuple, seen.values())) == {(1.75, -1.75) if x == 25 else (-1.75, -5.25) if single else (1.75, -1.75, -5.25)}
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place" 2>"$place/log" || { cat "$place/log" >&2; exit 1; }
# Seen:
#   eclipse-sumo 1.28.0 carla 0.9.16 pyxodr 0.1.3
#   second section for both sides:
#     lanes at 25 m, y: {'netconvert': [1.75, -1.75], 'CARLA': [1.75, -1.75], 'pyxodr': [1.75, -1.75]}
#     lanes at 75 m, y: {'netconvert': [1.75, -1.75, -5.25], 'CARLA': [1.75, -1.75, -5.25], 'pyxodr': [1.75, -1.75, -5.25]}
#   second section for the right side only:
#     lanes at 25 m, y: {'netconvert': [1.75, -1.75], 'CARLA': [1.75, -1.75], 'pyxodr': [1.75, -1.75]}
#     lanes at 75 m, y: {'netconvert': [-1.75, -5.25], 'CARLA': [-1.75, -5.25], 'pyxodr': [-1.75, -5.25]}
