#!/bin/sh
# SUMO's netconvert 1.28.0 makes a crossing of a bridge and the street below, if a node of the one lies exactly above a node of the other.
#
# One would guess: roads of OpenStreetMap meet where they share a node, that is its id; two nodes at one place, on two levels, are two, as for
#   Lanelet2, OSMnx and routers. Stacked roads, ramps of car parks, and data that was snapped to a grid have such nodes.
# What happens: nodes of equal latitude and longitude become one, whatever their ids, `ele`, and the `layer` and `bridge` of their ways.
#   From the motorway on the bridge one turns left into the residential street, and back. Exit 0, no warning; options for heights
#   (`--osm.elevation`, `--osm.layer-elevation`) change nothing. A ten millionth of a degree, 1 cm, between the nodes keeps them apart.
# Source: netconvert's NIImporter_OpenStreetMap.cpp (NodesHandler, myUniqueNodes); wheel of PyPI.
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


def turns(below, *options):
    """The connections between the motorway on the bridge and the street; `below` is the latitude of the street's node under it."""
    with open(source, "w") as file:
        file.write(f"""<?xml version="1.0"?>
<osm version="0.6" generator="by hand">
  <node id="1" version="1" lat="49.000" lon="8.000"><tag k="ele" v="108"/></node>
  <node id="2" version="1" lat="49.000" lon="8.003"><tag k="ele" v="108"/></node>
  <node id="3" version="1" lat="49.000" lon="8.006"><tag k="ele" v="108"/></node>
  <node id="4" version="1" lat="49.003" lon="8.003"><tag k="ele" v="100"/></node>
  <node id="5" version="1" lat="{below}" lon="8.003"><tag k="ele" v="100"/></node>
  <node id="6" version="1" lat="48.997" lon="8.003"><tag k="ele" v="100"/></node>
  <way id="10" version="1">
    <nd ref="1"/><nd ref="2"/><nd ref="3"/>
    <tag k="highway" v="motorway"/><tag k="oneway" v="yes"/><tag k="bridge" v="yes"/><tag k="layer" v="1"/>
  </way>
  <way id="11" version="1"><nd ref="4"/><nd ref="5"/><nd ref="6"/><tag k="highway" v="residential"/></way>
</osm>
""")
    done = subprocess.run([program, "--osm-files", source, "-o", net, *options], capture_output=True, text=True)
    ways = [(c.get("from"), c.get("to")) for c in ET.parse(net).getroot().iter("connection") if not c.get("from").startswith(":")]
    return sorted(way for way in ways if ("10#" in way[0]) != ("10#" in way[1])), (done.returncode, done.stderr)


same = turns("49.000")
print("one above the other:", same)
heights = [turns("49.000", *options) for options in (["--osm.elevation"], ["--osm.layer-elevation", "5"])]
print("with heights the same:", [seen == same for seen in heights])
apart = turns("49.0000001")
print("1 cm apart:", apart)
raise SystemExit(0 if len(same[0]) == 4 and heights == [same, same] and same[1] == (0, "") and apart == ([], (0, "")) else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/levels.osm" "$place/levels.net.xml"
# Seen:
#   one above the other: ([('-11#1', '10#1'), ('10#0', '-11#0'), ('10#0', '11#1'), ('11#0', '10#1')], (0, ''))
#   with heights the same: [True, True]
#   1 cm apart: ([], (0, ''))
