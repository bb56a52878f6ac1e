#!/bin/sh
# SUMO's netconvert 1.28.0: with `maxspeed=50` and `maxspeed:forward=30` in this order both directions are 50 km/h; in the other order both are 30.
#
# One would guess: the tags of a way are a set, so their order in the file means nothing; the limit of one direction replaces the general one
#   in this direction. netconvert knows both `:forward` and `:backward`.
# What happens: for the forward direction the first of `maxspeed`, `maxspeed:forward`, `maxspeed:type` and `zone:maxspeed` counts, and later
#   ones are skipped. `maxspeed:backward` is kept apart and always counts; without it both directions get the forward figure. So with tags in
#   alphabetical order a forward limit beside `maxspeed` is lost, and a backward limit is right. Alone, `maxspeed:forward=30` slows down
#   the other direction, too. Exit 0, no warning.
# Source: netconvert's NIImporter_OpenStreetMap.cpp (EdgesHandler::myStartElement, myMaxSpeed == MAXSPEED_UNGIVEN), release 1.28.0;
#   the wiki of OpenStreetMap on directional tags.
# Exits 0 while it is so, 1 if that changes. Needs CPython on Linux; the wheel is not tied to a version of it.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile eclipse-sumo==1.28.0
cat >"$place/run.py" <<'END'
import os
import pathlib
import subprocess
import sys
import xml.etree.ElementTree as ET

import sumo

place = pathlib.Path(sys.argv[1])
osm, net = place / "street.osm", place / "street.net.xml"
program = os.path.join(os.path.dirname(sumo.__file__), "bin", "netconvert")


def limits(*tags):
    """The limits along and against a street with these tags, in km/h, and what netconvert says to it."""
    osm.write_text("""<?xml version="1.0"?>
<osm version="0.6" generator="by hand">
  <node id="1" version="1" lat="49.000" lon="8.000"/>
  <node id="2" version="1" lat="49.000" lon="8.003"/>
  <way id="10" version="1">
    <nd ref="1"/><nd ref="2"/>
    <tag k="highway" v="secondary"/>%s
  </way>
</osm>
""" % "".join('<tag k="%s" v="%s"/>' % tag for tag in tags))
    done = subprocess.run([program, "--osm-files", osm, "-o", net], capture_output=True, text=True)
    speeds = {edge.get("id"): round(float(edge.find("lane").get("speed")) * 3.6) for edge in ET.parse(net).getroot().iter("edge")
              if not edge.get("id").startswith(":")}
    return speeds["10"], speeds["-10"], done.returncode, done.stderr


general, forward, backward = ("maxspeed", "50"), ("maxspeed:forward", "30"), ("maxspeed:backward", "30")
so = True
for tags, meant, expected in (
    ((general, forward), (30, 50), (50, 50)),
    ((forward, general), (30, 50), (30, 30)),
    ((general, backward), (50, 30), (50, 30)),
    ((backward, general), (50, 30), (50, 30)),
    ((forward, backward, general), (30, 30), (30, 30)),
    ((backward, general, forward), (30, 30), (50, 30)),
    ((forward,), (30, None), (30, 30)),
):
    along, against, code, said = limits(*tags)
    print("%-72s along %d, against %d km/h; meant: %s, %s" % (
        " ".join("%s=%s" % tag for tag in tags), along, against, meant[0], meant[1] or "the default of the class"))
    so &= (along, against, code, said) == (*expected, 0, "")
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   maxspeed=50 maxspeed:forward=30                                          along 50, against 50 km/h; meant: 30, 50
#   maxspeed:forward=30 maxspeed=50                                          along 30, against 30 km/h; meant: 30, 50
#   maxspeed=50 maxspeed:backward=30                                         along 50, against 30 km/h; meant: 50, 30
#   maxspeed:backward=30 maxspeed=50                                         along 50, against 30 km/h; meant: 50, 30
#   maxspeed:forward=30 maxspeed:backward=30 maxspeed=50                     along 30, against 30 km/h; meant: 30, 30
#   maxspeed:backward=30 maxspeed=50 maxspeed:forward=30                     along 50, against 30 km/h; meant: 30, 30
#   maxspeed:forward=30                                                      along 30, against 30 km/h; meant: 30, the default of the class
