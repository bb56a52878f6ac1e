#!/bin/sh
# SUMO's netconvert 1.28.0 reads OpenDRIVE roads with rule="LHT" as right-hand traffic: every lane runs the wrong way.
#
# One would guess: a standard attribute of the road (`rule`, since OpenDRIVE 1.4) turns the lanes around, or is refused with a warning.
# What happens: exit 0, no word. In left-hand traffic the lanes right of the reference line (negative ids) run against it; netconvert
#   lets lane -1 run along it, and its network is not marked `lefthand`. CARLA 0.9.16 reads the same file as it is meant.
# Source: ASAM OpenDRIVE 1.8, road attribute `rule`; netconvert's NIImporter_OpenDrive.cpp; both programs as wheels of PyPI.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 to 3.12 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check eclipse-sumo==1.28.0 carla==0.9.16
cat >"$place/left.xodr" <<'END'
<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="4" name="left"/>
  <road id="1" name="left" length="100" junction="-1" rule="LHT">
    <planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
    <lanes><laneSection s="0">
      <left><lane id="1" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></left>
      <center><lane id="0" type="none" level="false"/></center>
      <right><lane id="-1" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right>
    </laneSection></lanes>
  </road>
</OpenDRIVE>
END
cat >"$place/run.py" <<'END'
import os, subprocess, sys, xml.etree.ElementTree as ET
import carla, sumo

source, net = sys.argv[1:]
done = subprocess.run([os.path.join(os.path.dirname(sumo.__file__), "bin", "netconvert"), "--opendrive-files", source, "-o", net],
                      capture_output=True, text=True)
root = ET.parse(net).getroot()
x = {e.get("id"): [float(p.split(",")[0]) for p in e.find("lane").get("shape").split()] for e in root.iter("edge") if not e.get("function")}
along = {name: "along" if p[-1] > p[0] else "against" for name, p in x.items()}
first = carla.Map("left", open(source).read()).get_waypoint_xodr(1, -1, 50.0)
theirs = "along" if first.next(10)[0].transform.location.x > first.transform.location.x else "against"
print("netconvert: exit %d, lane -1 %s the reference line, lefthand=%s, warnings about it: %s"
      % (done.returncode, along["-1"], root.get("lefthand"), "LHT" in done.stderr or "rule" in done.stderr))
print("CARLA: lane -1 %s the reference line" % theirs)
raise SystemExit(0 if (done.returncode, along["-1"], root.get("lefthand"), theirs) == (0, "along", None, "against") else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/left.xodr" "$place/left.net.xml" 2>/dev/null
# Seen:
#   netconvert: exit 0, lane -1 along the reference line, lefthand=None, warnings about it: False
#   CARLA: lane -1 against the reference line
