#!/bin/sh
# SUMO's netconvert 1.28.0 moves a lane of OpenDRIVE 10 m aside, if a median of 10 m lies between it and the next lane.
#
# One would guess: lanes that SUMO has no use for (medians, verges, cycle lanes) are left out, and those that stay keep their place, which
#   is the sum of all widths from the reference line on. It is so for a median next to the reference line.
# What happens: behind a driving lane the widths of what is left out are not counted, and the lanes beyond close up: a frontage road
#   behind a verge touches the main road, a lane behind a cycle lane lies on it. Exit 0, no word.
#   A way out: `--opendrive.import-all-lanes`, which keeps the places, and makes lanes of the medians.
# Source: ASAM OpenDRIVE 1.8, lane width; netconvert's NIImporter_OpenDrive.cpp; wheel of PyPI.
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


def lane(number, kind, width):
    return f'<lane id="{number}" type="{kind}" level="false"><width sOffset="0" a="{width}" b="0" c="0" d="0"/></lane>'


def centres(left, right, *options):
    """Where the centres of the driving lanes are, across the road: as drawn, and as converted. Lanes are listed outwards."""
    drawn = []
    for side, lanes in (1, left), (-1, right):
        edge = 0
        for kind, width in lanes:
            edge += width
            if kind == "driving":
                drawn.append(side * (edge - width / 2))
    ups = "".join(reversed([lane(i + 1, *each) for i, each in enumerate(left)]))
    downs = "".join(lane(-i - 1, *each) for i, each in enumerate(right))
    with open(source, "w") as file:
        file.write(f"""<?xml version="1.0"?>
<OpenDRIVE><header revMajor="1" revMinor="4" name="median"/>
  <road id="1" length="100" junction="-1">
    <planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
    <lanes><laneSection s="0">
      {f"<left>{ups}</left>" if ups else ""}
      <center><lane id="0" type="none" level="false"/></center>
      <right>{downs}</right>
    </laneSection></lanes>
  </road>
</OpenDRIVE>""")
    done = subprocess.run([program, "--opendrive-files", source, "-o", net, *options], capture_output=True, text=True)
    location = ET.parse(net).getroot().find("location").get("netOffset").split(",")
    made = [float(each.get("shape").split()[0].split(",")[1]) - float(location[1])
            for edge in ET.parse(net).getroot().iter("edge") if not edge.get("function")
            for each in edge.findall("lane") if float(each.get("width")) == 3.5]
    return sorted(drawn), sorted(made), done.returncode, done.stderr


car, median, cycles = ("driving", 3.5), ("median", 10), ("biking", 2)
roads = {
    "median, then a lane": centres([], [median, car]),
    "lane, median, lane": centres([], [car, median, car]),
    "lane, cycle lane, lane": centres([], [car, cycles, car]),
    "lane, median, lane; all asked for": centres([], [car, median, car], "--opendrive.import-all-lanes"),
}
for name, (drawn, made, code, words) in roads.items():
    print(f"{name}: drawn at {drawn}, converted to {made}; exit {code}, {words.strip() or 'no word'}")
wanted = {
    "median, then a lane": ([-11.75], [-11.75], 0, ""),
    "lane, median, lane": ([-15.25, -1.75], [-5.25, -1.75], 0, ""),
    "lane, cycle lane, lane": ([-7.25, -1.75], [-5.25, -1.75], 0, ""),
    "lane, median, lane; all asked for": ([-15.25, -1.75], [-15.25, -1.75], 0, ""),
}
raise SystemExit(0 if roads == wanted else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/median.xodr" "$place/median.net.xml"
# Seen:
#   median, then a lane: drawn at [-11.75], converted to [-11.75]; exit 0, no word
#   lane, median, lane: drawn at [-15.25, -1.75], converted to [-5.25, -1.75]; exit 0, no word
#   lane, cycle lane, lane: drawn at [-7.25, -1.75], converted to [-5.25, -1.75]; exit 0, no word
#   lane, median, lane; all asked for: drawn at [-15.25, -1.75], converted to [-15.25, -1.75]; exit 0, no word
