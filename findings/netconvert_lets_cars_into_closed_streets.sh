#!/bin/sh
# SUMO's netconvert 1.28.0: cars drive on where OSM says `motor_vehicle=no` or `vehicle=no`, and not where it says they alone may.
#
# One would guess: the tags of access of OpenStreetMap are read, from the general to the particular: `access`, `vehicle`, `motor_vehicle`,
#   `motorcar`, `hgv`; netconvert does read `access=no`.
# What happens: all others are skipped without a word. Streets closed to motor traffic, to all vehicles, to cars or to lorries carry
#   everybody. `access=no` keeps out cars, lorries and pedestrians, but neither buses nor bicycles; `motor_vehicle=yes` beside it does not
#   let cars in again, so that a road for motor traffic only is closed to it. No option that reads more of OSM (lane access, bicycle
#   access, all attributes) changes this for cars.
# Source: OSM wiki, key access; netconvert's NIImporter_OpenStreetMap.cpp and issue 15307; wheel of PyPI.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check eclipse-sumo==1.28.0
cat >"$place/run.py" <<'END'
import os, subprocess, sys, xml.etree.ElementTree as ET
import sumo

source, net = sys.argv[1:]
program = os.path.join(os.path.dirname(sumo.__file__), "bin", "netconvert")
options = [[], ["--osm.lane-access", "--osm.bike-access", "--osm.all-attributes"]]
kinds = "passenger", "truck", "bus", "bicycle", "pedestrian"
cars, all_of_them = ["passenger", "truck", "bus"], list(kinds)
cases = {  # tags of the street, and who may use it: by OSM, by netconvert
    (): (all_of_them, all_of_them),
    ("motor_vehicle=no",): (["bicycle", "pedestrian"], all_of_them),
    ("vehicle=no",): (["pedestrian"], all_of_them),
    ("motorcar=no",): (["truck", "bus", "bicycle", "pedestrian"], all_of_them),
    ("hgv=no",): (["passenger", "bus", "bicycle", "pedestrian"], all_of_them),
    ("access=no",): ([], ["bus", "bicycle"]),
    ("access=no", "motor_vehicle=yes"): (cars, ["bus", "bicycle"]),
}


def allowed(tags, extra):
    written = "".join('<tag k="%s" v="%s"/>' % tuple(tag.split("=")) for tag in tags)
    with open(source, "w") as file:
        file.write(f"""<?xml version="1.0"?>
<osm version="0.6" generator="by hand">
  <node id="1" version="1" lat="49.0" lon="8.0"/><node id="2" version="1" lat="49.0" lon="8.003"/>
  <way id="3" version="1"><nd ref="1"/><nd ref="2"/><tag k="highway" v="residential"/><tag k="oneway" v="yes"/>{written}</way>
</osm>""")
    done = subprocess.run([program, "--osm-files", source, "-o", net, *extra], capture_output=True, text=True)
    lane = next(e for e in ET.parse(net).getroot().iter("edge") if e.get("id") == "3").find("lane")
    allow, disallow = lane.get("allow"), (lane.get("disallow") or "").split()
    return [kind for kind in kinds if (kind in allow.split() if allow else kind not in disallow)], done.stderr


so = True
for tags, (meant, expected) in cases.items():
    found, said = allowed(tags, options[0])
    more, _ = allowed(tags, options[1])
    so &= found == expected and said == "" and ("passenger" in more) == ("passenger" in expected)
    print("%-29s OSM: %-44s netconvert: %s" % (" ".join(tags) or "-", " ".join(meant) or "-", " ".join(found)))
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/street.osm" "$place/street.net.xml"
# Seen:
#   -                             OSM: passenger truck bus bicycle pedestrian       netconvert: passenger truck bus bicycle pedestrian
#   motor_vehicle=no              OSM: bicycle pedestrian                           netconvert: passenger truck bus bicycle pedestrian
#   vehicle=no                    OSM: pedestrian                                   netconvert: passenger truck bus bicycle pedestrian
#   motorcar=no                   OSM: truck bus bicycle pedestrian                 netconvert: passenger truck bus bicycle pedestrian
#   hgv=no                        OSM: passenger bus bicycle pedestrian             netconvert: passenger truck bus bicycle pedestrian
#   access=no                     OSM: -                                            netconvert: bus bicycle
#   access=no motor_vehicle=yes   OSM: passenger truck bus                          netconvert: bus bicycle
