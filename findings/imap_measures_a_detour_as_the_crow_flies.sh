#!/bin/sh
# imap-box-up 0.0.6, from OpenDRIVE to Apollo: a lane 628 m long that goes around a block is 400 m long; behind a lane section, a lane that
# is 3.5 m wide is said to be 0 m wide.
#
# One would guess: the `length` of an Apollo lane is that of its central curve, and the samples of its width say what lies between the bounds
#   that the same file gives it.
# What happens: if a road ends in the direction in which it began, within 0.01 rad, it is taken for a straight, and the length is that of
#   the beeline from the first to the last point. An S-bend of two quarter circles loses a tenth, a bay around a block of four
#   loses 36 %. The segment of the central curve and both bounds get the same length. The width samples take the place along the
#   road for the place along the lane section: 100 m into the road, a lane that narrows by 3.5 m over 100 m begins with 0 m, and ends
#   with -3.5 m. The bounds are drawn right. A road of one section has the right widths. There is no warning.
# Source: imap/lib/common.py (calc_length), imap/lib/convertor.py (add_lane_sample) beside imap/lib/opendrive/lanes.py (generate_boundary), release
#   0.0.6; Apollo, modules/map/proto/map_lane.proto ("length", "LaneSampleAssociation"); ASAM OpenDRIVE 1.8, lane width.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.11 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --no-deps --only-binary :all: \
  imap-box-up==0.0.6 record-msg==0.1.1 protobuf==3.19.4 numpy==1.26.4 scipy==1.13.0 pyproj==3.7.2 certifi==2025.10.5 concave-hull==0.0.7 \
  matplotlib==3.11.2 packaging==25.0 cycler==0.12.1 kiwisolver==1.5.1 pyparsing==3.3.3 python-dateutil==2.9.0 six==1.17.0 contourpy==1.3.3 \
  fonttools==4.68.0 pillow==13.0.0
cat >"$place/run.py" <<'END'
import math
import pathlib
import subprocess
import sys

from modules.map.proto import map_pb2

place = pathlib.Path(sys.argv[1])
QUARTER = math.pi * 50  # a quarter of a circle of 100 m radius, in metres
SIDE = '<roadMark sOffset="0" type="solid" color="white" width="0.12"/>'
WIDE = '<width sOffset="0" a="3.5" b="0" c="0" d="0"/>'
NARROWING = '<width sOffset="0" a="3.5" b="-0.035" c="0" d="0"/>'


def section(s, width):
    """A lane section with one lane, whose reference line is its middle."""
    return f"""<laneSection s="{s}"><center><lane id="0" type="none" level="false">{SIDE}</lane></center>
      <right><lane id="-1" type="driving" level="false">{width}{SIDE}</lane></right></laneSection>"""


def convert(pieces, sections=section(0, WIDE)):
    """The lanes of a road that is made of straights and curves; its reference line is the middle of the first lane."""
    s, plan = 0.0, ""
    x, y, heading = 0.0, 0.0, 0.0
    for length, curvature in pieces:
        shape = '<arc curvature="%s"/>' % curvature if curvature else "<line/>"
        plan += '<geometry s="%.9f" x="%.9f" y="%.9f" hdg="%.9f" length="%.9f">%s</geometry>' % (s, x, y, heading, length, shape)
        turn = length * curvature
        chord = 2 * math.sin(turn / 2) / curvature if curvature else length
        x += chord * math.cos(heading + turn / 2)
        y += chord * math.sin(heading + turn / 2)
        heading += turn
        s += length
    (place / "road.xodr").write_text(f"""<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="6" name="bends" version="1" date="2026-01-01T00:00:00" north="0" south="0" east="0" west="0">
    <geoReference><![CDATA[+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs]]></geoReference>
  </header>
  <road name="bends" length="{s:.9f}" id="1" junction="-1" rule="RHT"><link/><planView>{plan}</planView>
    <lanes><laneOffset s="0" a="1.75" b="0" c="0" d="0"/>{sections}</lanes>
  </road>
</OpenDRIVE>
""")
    subprocess.run([sys.executable, "-c", "from imap.main import main; main()", "-f", "-i", place / "road.xodr", "-o", place / "map.txt"],
                   check=True, capture_output=True, env={"MPLBACKEND": "agg", "MPLCONFIGDIR": str(place)})
    city = map_pb2.Map()
    city.ParseFromString((place / "map.bin").read_bytes())
    return list(city.lane)


def points(curve):
    return [(point.x, point.y) for point in curve.segment[0].line_segment.point]


left, right = (QUARTER, 0.01), (QUARTER, -0.01)
so = True
for name, pieces, expected in (
    ("straight", [(400, 0)], (400, 400)),
    ("one quarter circle", [left], (157, 157)),
    ("S-bend of two quarter circles", [left, right], (314, 283)),
    ("bay of four, around a block", [left, right, right, left], (628, 400)),
):
    lane = convert(pieces)[0]
    line = points(lane.central_curve)
    seen = round(sum(math.dist(a, b) for a, b in zip(line, line[1:]))), round(lane.length)
    so &= seen == expected
    print("%-30s central curve %d m, length %d m" % (name + ":", *seen))

for lane in convert([(200, 0)], section(0, WIDE) + section(100, NARROWING)):
    bounds = list(zip(points(lane.left_boundary.curve), points(lane.right_boundary.curve)))
    drawn = [round(math.dist(*bounds[place]), 1) for place in (1, -1)]
    said = [round(lane.left_sample[place].width + lane.right_sample[place].width, 1) for place in (1, -1)]
    so &= (drawn, said) == {"road_1_lane_0_-1": ([3.5, 3.5], [3.5, 3.5]), "road_1_lane_1_-1": ([3.5, 0.0], [0.0, -3.5])}[lane.id.id]
    print("%s: bounds %.1f m apart, then %.1f m; width samples %.1f m, then %.1f m" % (lane.id.id, *drawn, *said))
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   straight:                      central curve 400 m, length 400 m
#   one quarter circle:            central curve 157 m, length 157 m
#   S-bend of two quarter circles: central curve 314 m, length 283 m
#   bay of four, around a block:   central curve 628 m, length 400 m
#   road_1_lane_0_-1: bounds 3.5 m apart, then 3.5 m; width samples 3.5 m, then 3.5 m
#   road_1_lane_1_-1: bounds 3.5 m apart, then 0.0 m; width samples -0.0 m, then -3.5 m
