#!/bin/sh
# CommonRoad Scenario Designer 0.8.5: of a double line, dashed on the left and solid on the right, the wrong lane gets the solid half, or
# nobody does; which of the two, the order of the relations in the Lanelet2 file decides.
#
# One would guess: of `dashed_solid` the lane to the left of the line sees the dashed half and may cross, the lane to the right sees the
#   solid half and may not; a file means the same, whatever the order of its relations.
# What happens: each lane takes the first word for itself and gives the second to its neighbour, on whichever side it lies. With the left
#   lane first in the file, the left lane has a solid line and the right one a dashed line. With the right lane first both are dashed: the
#   left lane's half is stored under an attribute that does not exist (`left_marking_left_vertices`). No warning in either case.
# Source: crdesigner/map_conversion/lanelet2/lanelet2cr.py (_way_rel_to_lanelet), release 0.8.5; lanelet2_core/doc/LinestringTagging.md.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 to 3.12 on Linux; installs 1.2 GB for a while.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile commonroad-scenario-designer==0.8.5 commonroad-io==2024.3
cat >"$place/run.py" <<'END'
import sys
from crdesigner.map_conversion.map_conversion_interface import lanelet_to_commonroad

LEFT, RIGHT = (21, 11, 12), (22, 12, 13)  # a lane, its left and its right line; line 12 is drawn along both


def markings(*lanes):
    """What the left and the right lane see of the line between them."""
    relations = "".join(f"""
  <relation id="{lane}"><member type="way" ref="{left}" role="left"/><member type="way" ref="{right}" role="right"/>
    <tag k="type" v="lanelet"/><tag k="subtype" v="road"/><tag k="location" v="urban"/><tag k="one_way" v="yes"/></relation>"""
                        for lane, left, right in lanes)
    with open(sys.argv[1], "w") as file:
        file.write(f"""<?xml version="1.0"?>
<osm version="0.6" generator="by hand">
  <node id="1" lat="49.0000315" lon="8.0"/><node id="2" lat="49.0000315" lon="8.001"/>
  <node id="3" lat="49.0" lon="8.0"/><node id="4" lat="49.0" lon="8.001"/>
  <node id="5" lat="48.9999685" lon="8.0"/><node id="6" lat="48.9999685" lon="8.001"/>
  <way id="11"><nd ref="1"/><nd ref="2"/><tag k="type" v="line_thin"/><tag k="subtype" v="solid"/></way>
  <way id="12"><nd ref="3"/><nd ref="4"/><tag k="type" v="line_thin"/><tag k="subtype" v="dashed_solid"/></way>
  <way id="13"><nd ref="5"/><nd ref="6"/><tag k="type" v="line_thin"/><tag k="subtype" v="solid"/></way>{relations}
</osm>""")
    made = lanelet_to_commonroad(sys.argv[1]).lanelet_network.lanelets
    left = next(lane for lane in made if lane.adj_right is not None)
    right = next(lane for lane in made if lane.adj_left is not None)
    return left.line_marking_right_vertices.value, right.line_marking_left_vertices.value


seen = markings(LEFT, RIGHT), markings(RIGHT, LEFT)
for order, (left, right) in zip(("left lane first ", "right lane first"), seen):
    print("%s: the left lane sees %s, the right lane %s" % (order, left, right))
raise SystemExit(0 if seen == (("solid", "dashed"), ("dashed", "dashed")) else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/map.osm" 2>"$place/log" || { code=$?; tail -3 "$place/log" >&2; exit $code; }
# Seen:
#   left lane first : the left lane sees solid, the right lane dashed
#   right lane first: the left lane sees dashed, the right lane dashed
