#!/bin/sh
# An OpenDRIVE 1.8 lane of `direction="reversed"`, a contraflow lane: netconvert 1.28.0 and CARLA 0.9.16 lead their cars along it the wrong way.
#
# One would guess: what the attribute says counts, since the standard says that it overrules the sign of the id and the road's `rule`; or a program that
#   does not know version 1.8 refuses the file, or says so. maliput-malidrive 0.21.0 does read it.
# What happens: the attribute is skipped, and the version in the header is not looked at. In a street of three lanes, of which the middle one is
#   reversed for the traffic to the west, both programs drive it to the east, as its id -1 would have it without the attribute. A
#   lane of `direction="both"` is a lane of one way. Two cars meet head on, one by the map and one by the program. No word, exit 0.
#   The way to write a contraflow lane that is read is the older one: with the centre lane moved by `<laneOffset>`, as id 1.
# Source: ASAM OpenDRIVE 1.8, 11.2 lane groups (@direction, introduced with 1.8.0: "the standard direction can be overwritten"); CARLA as the
#   wheel shows it; netconvert's NIImporter_OpenDrive.cpp; wheels of PyPI.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 to 3.12 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile eclipse-sumo==1.28.0 carla==0.9.16
cat >"$place/run.py" <<'END'
import importlib.metadata
import os
import subprocess
import sys
import xml.etree.ElementTree as ET

import carla
import sumo

os.chdir(sys.argv[1])


def road(middle, offset=0, left=(1,), right=(-1, -2)):
    """100 m to the east, three lanes; the attributes of lane -1."""
    def lanes(numbers):
        return "".join(f'<lane id="{number}" type="driving" level="false"{middle if number == -1 else ""}><link/>'
                       '<width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>' for number in numbers)
    with open("road.xodr", "w") as file:
        file.write('<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="8" name="" version="1" date="" north="0" south="0" east="0" west="0" '
                   'vendor=""/><road name="" length="100" id="1" junction="-1" rule="RHT"><link/><planView><geometry s="0" x="0" y="0" hdg="0" '
                   'length="100"><line/></geometry></planView><elevationProfile/><lateralProfile/><lanes>'
                   f'<laneOffset s="0" a="{offset}" b="0" c="0" d="0"/><laneSection s="0"><left>{lanes(left)}</left>'
                   f'<center><lane id="0" type="none" level="false"/></center><right>{lanes(right)}</right></laneSection></lanes></road></OpenDRIVE>')


def directions():
    """Where the lanes lead to, from the left to the right as seen to the east."""
    subprocess.run([os.path.join(os.path.dirname(sumo.__file__), "bin", "netconvert"), "--opendrive", "road.xodr", "-o", "road.net.xml",
                    "--offset.disable-normalization"], check=True, stdout=subprocess.DEVNULL)
    net = {}
    for item in ET.parse("road.net.xml").getroot().iter("lane"):
        if not item.get("id").startswith(":"):
            (x0, y), (x1, _) = (map(float, point.split(",")) for point in item.get("shape").split())
            net[y] = "east" if x0 < x1 else "west"
    map_, found = carla.Map("road", open("road.xodr").read()), {}
    for number in 2, 1, -1, -2:
        if waypoint := map_.get_waypoint_xodr(1, number, 50):
            found[-waypoint.transform.location.y] = "west" if abs(waypoint.transform.rotation.yaw) > 90 else "east"
    return [[names[y] for y in sorted(names, reverse=True)] for names in (net, found)]


print(*(f"{name} {importlib.metadata.version(name)}" for name in ("eclipse-sumo", "carla")))
so = True
as_id = ["west", "east", "east"]
for name, arguments, wanted in [
        ("lane -1 without the attribute", [""], as_id), ("standard", [' direction="standard"'], as_id), ("reversed", [' direction="reversed"'], as_id),
        ("both", [' direction="both"'], as_id), ("as lane 1, behind a lane offset", ["", -3.5, (2, 1), (-1,)], ["west", "west", "east"])]:
    road(*arguments)
    seen = directions()
    print(f"{name}: netconvert {seen[0]}, CARLA {seen[1]}")
    so &= seen == [wanted, wanted]
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place" 2>"$place/log" || { cat "$place/log" >&2; exit 1; }
# Seen:
#   eclipse-sumo 1.28.0 carla 0.9.16
#   lane -1 without the attribute: netconvert ['west', 'east', 'east'], CARLA ['west', 'east', 'east']
#   standard: netconvert ['west', 'east', 'east'], CARLA ['west', 'east', 'east']
#   reversed: netconvert ['west', 'east', 'east'], CARLA ['west', 'east', 'east']
#   both: netconvert ['west', 'east', 'east'], CARLA ['west', 'east', 'east']
#   as lane 1, behind a lane offset: netconvert ['west', 'west', 'east'], CARLA ['west', 'west', 'east']
