#!/bin/sh
# OpenDRIVE lanes that are given by <border> in place of <width>: netconvert 1.28.0 makes them 3.65 m wide, CARLA 0.9.16 makes them 0 m.
#
# One would guess: `<border>` is one of the standard's two ways to say where a lane ends (surveys use it, since it is what they measure),
#   so readers know both, or refuse the file.
# What happens: a lane of 2.5 m between borders. netconvert takes its own default width and says nothing (exit 0). CARLA warns on its
#   output, goes on, and puts the lane's waypoints on the reference line with a width of 0.
# Source: ASAM OpenDRIVE 1.8, lane border; both programs as wheels of PyPI.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 to 3.12 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check eclipse-sumo==1.28.0 carla==0.9.16
cat >"$place/border.xodr" <<'END'
<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="4" name="border"/>
  <road id="1" name="border" length="100" junction="-1">
    <planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
    <lanes><laneSection s="0">
      <center><lane id="0" type="none" level="false"/></center>
      <right><lane id="-1" type="driving" level="false"><border sOffset="0" a="-2.5" b="0" c="0" d="0"/></lane></right>
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
lane = next(e.find("lane") for e in ET.parse(net).getroot().iter("edge") if not e.get("function"))
width = carla.Map("border", open(source).read()).get_waypoint_xodr(1, -1, 50.0).lane_width
print("drawn 2.50 m; netconvert: exit %d, %s m, speaks of borders: %s; CARLA: %.2f m"
      % (done.returncode, lane.get("width"), "border" in done.stderr, width))
raise SystemExit(0 if (done.returncode, lane.get("width"), width) == (0, "3.65", 0.0) else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/border.xodr" "$place/border.net.xml" 2>/dev/null
# Seen (CARLA's warning goes to standard error):
#   drawn 2.50 m; netconvert: exit 0, 3.65 m, speaks of borders: False; CARLA: 0.00 m
