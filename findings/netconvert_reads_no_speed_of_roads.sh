#!/bin/sh
# SUMO's netconvert 1.28.0 drops the speed limits that OpenDRIVE files give per road: every street is 50 km/h.
#
# One would guess: `<type><speed max="25" unit="mph"/></type>` of a road holds for all its lanes that have no `<speed>` of their own, as
#   the standard says; CARLA's towns have their limits there and nowhere else, so that a simulation with both tools drives alike.
# What happens: the element is read within lanes alone. A 20 mph street, a road at 100 km/h and a motorway without limit all come out with
#   the 13.89 m/s of lane type `driving`. Exit 0, no warning. The same 20 mph at the lane are read, with their unit.
# Source: ASAM OpenDRIVE 1.8, road type and its speed; netconvert's NIImporter_OpenDrive.cpp (OPENDRIVE_TAG_SPEED); Town01.xodr and
#   Town04.xodr of carla-simulator/opendrive-test-files; wheel of PyPI.
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
roads = {  # what the road says, what its lane says
    "1": ('<type s="0" type="town"><speed max="20" unit="mph"/></type>', ""),
    "2": ('<type s="0" type="rural"><speed max="100" unit="km/h"/></type>', ""),
    "3": ('<type s="0" type="motorway"><speed max="no limit"/></type>', ""),
    "4": ('<type s="0" type="town"/>', '<speed sOffset="0" max="20" unit="mph"/>'),
}
with open(source, "w") as file:
    file.write('<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="4" name="speeds"/>')
    for name, (road, lane) in roads.items():
        file.write(f"""
<road id="{name}" length="100" junction="-1">{road}
  <planView><geometry s="0" x="0" y="{int(name) * 20}" hdg="0" length="100"><line/></geometry></planView>
  <lanes><laneSection s="0">
    <center><lane id="0" type="none" level="false"/></center>
    <right><lane id="-1" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/>{lane}</lane></right>
  </laneSection></lanes>
</road>""")
    file.write("</OpenDRIVE>")
program = os.path.join(os.path.dirname(sumo.__file__), "bin", "netconvert")
done = subprocess.run([program, "--opendrive-files", source, "-o", net], capture_output=True, text=True)
edges = {e.get("id"): e.find("lane").get("speed") for e in ET.parse(net).getroot().iter("edge") if not e.get("function")}
for name, said in roads.items():
    print("%-62s -> %s m/s" % (" ".join(said).strip(), edges["-" + name]))
print("exit %d, said: %r" % (done.returncode, done.stderr))
raise SystemExit(0 if edges == {"-1": "13.89", "-2": "13.89", "-3": "13.89", "-4": "8.94"} and (done.returncode, done.stderr) == (0, "") else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/speeds.xodr" "$place/speeds.net.xml"
# Seen:
#   <type s="0" type="town"><speed max="20" unit="mph"/></type>    -> 13.89 m/s
#   <type s="0" type="rural"><speed max="100" unit="km/h"/></type> -> 13.89 m/s
#   <type s="0" type="motorway"><speed max="no limit"/></type>     -> 13.89 m/s
#   <type s="0" type="town"/> <speed sOffset="0" max="20" unit="mph"/> -> 8.94 m/s
#   exit 0, said: ''
