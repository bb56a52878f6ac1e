#!/bin/sh
# omega-prime 0.3.7 puts the line at the outer border of an OpenDRIVE lane onto the inner border: a kerb stands between two lanes. For lanes to
# the right of the reference line, the left bound is the right one.
#
# One would guess: `lane.left_boundary` and `lane.right_boundary` lie to the left and right, seen along the lane's centre line or the way of
#   traffic; a `<roadMark>` of a lane is the line at its outer border, and a second one goes on from its `sOffset` along the same border.
# What happens: "right" is the inner border of every lane and "left" the outer one, so that both are exchanged on the right side of a road.
#   The first mark is given to the inner border, the second one to the outer border, each for the whole length. A lane with one mark has
#   an outer border of unknown type. A line that is broken up to 50 m and solid from there on comes out broken on one border of the
#   lane and solid on the other. The centre lane's mark is read by nobody; its neighbours disagree about it. Lanes of type `bus`
#   are left out, with an error in the log: a table of types has `bux`.
# Source: omega_prime/map_odr.py (LaneBoundaryXodr, LANE_TYPE_MAP), pyxodr_omega_prime/road_objects/lane.py (boundary_line is the far
#   boundary), as installed; ASAM OpenDRIVE 1.8, 11.8 road markings; ASAM OSI, osi_lane.proto (left and right of a lane).
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.11 to 3.13 on Linux; installs 1.1 GB for a while.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile omega-prime==0.3.7 pyxodr-omega-prime==0.1.5 \
  betterosi==0.9.0 polars==1.44.2 polars-st==0.11.0 pandera==0.35.0 numpy==2.4.6 shapely==2.2.0 pandas==3.1.1
cat >"$place/run.py" <<'END'
import logging
import pathlib
import sys

import omega_prime.map_odr

messages = []
logging.getLogger("omega_prime.map_odr").addFilter(lambda record: messages.append(record.getMessage()))


def lane(number, kind, *marks):
    """A lane of 3.5 m with marks (sOffset, type)."""
    return '<lane id="%d" type="%s" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/>%s</lane>' % (
        number, kind, "".join('<roadMark sOffset="%d" type="%s" color="standard" width="0.12"/>' % mark for mark in marks))


path = pathlib.Path(sys.argv[1]) / "road.xodr"
path.write_text(f"""<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="7" name="road" version="1" north="0" south="0" east="0" west="0"/>
  <road name="east" length="100" id="1" junction="-1" rule="RHT">
    <planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
    <lanes><laneSection s="0">
      <left>{lane(1, "driving", (0, "solid"))}</left>
      <center><lane id="0" type="none" level="false"><roadMark sOffset="0" type="broken" color="standard" width="0.12"/></lane></center>
      <right>{lane(-1, "driving", (0, "broken"), (50, "solid"))}{lane(-2, "driving", (0, "curb"))}{lane(-3, "bus", (0, "solid"))}</right>
    </laneSection></lanes>
  </road>
</OpenDRIVE>
""")
road = omega_prime.map_odr.MapOdr.from_file(str(path), parse_map=True, step_size=1.0)
seen = {}
for one in road.lanes.values():
    middle, ends = one.centerline.coords[0][1], one.centerline.coords
    sides = {"left": one.left_boundary, "right": one.right_boundary}
    seen[one.idx.lane_id] = {side: (line.polyline.coords[0][1], line.type.name.removeprefix("TYPE_")) for side, line in sides.items()}
    print("lane %2d, its middle at y = %5.2f, runs from x = %d to %d: left bound at %4.1f is %-11s right bound at %4.1f is %s" % (
        one.idx.lane_id, middle, ends[0][0], ends[-1][0], *seen[one.idx.lane_id]["left"][:1], seen[one.idx.lane_id]["left"][1] + ",",
        *seen[one.idx.lane_id]["right"]))
print("the file: y = 3.5 solid; y = 0 broken; y = -3.5 broken, solid from 50 m on; y = -7 kerb; y = -10.5 solid")
print("log:", messages)
so = seen == {
    1: {"left": (3.5, "UNKNOWN"), "right": (0.0, "SOLID_LINE")},
    -1: {"left": (-3.5, "SOLID_LINE"), "right": (0.0, "DASHED_LINE")},
    -2: {"left": (-7.0, "UNKNOWN"), "right": (-3.5, "CURB")},
} and len(messages) == 1 and "'bus'" in messages[0]
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place" 2>"$place/log" || { code=$?; tail -3 "$place/log" >&2; exit $code; }
# Seen:
#   lane  1, its middle at y =  1.75, runs from x = 0 to 100: left bound at  3.5 is UNKNOWN,    right bound at  0.0 is SOLID_LINE
#   lane -1, its middle at y = -1.75, runs from x = 0 to 100: left bound at -3.5 is SOLID_LINE, right bound at  0.0 is DASHED_LINE
#   lane -2, its middle at y = -5.25, runs from x = 0 to 100: left bound at -7.0 is UNKNOWN,    right bound at -3.5 is CURB
#   the file: y = 3.5 solid; y = 0 broken; y = -3.5 broken, solid from 50 m on; y = -7 kerb; y = -10.5 solid
#   log: ["Failed to create lane object for road 1 / lane_section 0 / lane -3: 'bus'"]
