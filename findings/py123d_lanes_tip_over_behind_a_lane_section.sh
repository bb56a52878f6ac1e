#!/bin/sh
# py123d 0.7.0 (123D): where a new lane section begins on a hill, lanes tip over: with a slope of 5 %, 100 m up the road, the left edge of a
# lane 3.5 m wide lies 5 m above the right edge; further out, whole lanes lie 5 m below the road.
#
# One would guess: a point of a lane has the height that `<elevation>` gives for its place along the road, however the road is divided
#   into lane sections; sections say where lanes begin and end, and nothing about heights.
# What happens: the place along the road is counted from the start of the lane section for every edge but the innermost. In the plane the
#   start is added again, for heights it is not: the second section gets the heights of the road's beginning. The centre line is
#   half as wrong as the edge, and the next road begins with a step. Roads of one section, and level ones, are right, and so
#   are all places as seen from above. No warning; the map says of itself that it has heights (`map_has_z=True`).
# Source: py123d/parser/opendrive/utils/lane_helper.py (outer_polyline_3d, lane_section_to_lane_helpers) and xodr_parser/reference.py
#   (interpolate_3d_batch adds `s_offset` for the plan alone), release 0.7.0; ASAM OpenDRIVE 1.8, road elevation and lane sections.
# Exits 0 while it is so, 1 if that changes, 2 if it cannot be installed. Needs CPython 3.10 to 3.13 on Linux. Of its dependencies
# py123d gets those that maps need.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
{ python3 -m venv "$place/env" && "$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --no-deps --only-binary :all: \
  py123d==0.7.0 numpy==2.2.6 scipy==1.15.3 shapely==2.1.2 pyquaternion==0.9.9 trimesh==5.2.0 \
  typing-extensions==4.15.0 networkx==3.4.2; } ||
  { echo "py123d 0.7.0 cannot be installed here: it needs CPython 3.10 to 3.13 on Linux and PyPI" >&2; exit 2; }
cat >"$place/run.py" <<'END'
import importlib.metadata
import math
import pathlib
import sys

from py123d.parser.opendrive.opendrive_map_parser import OpenDriveMapParser

# A ring road of four pieces, since the parser leaves out lanes that lead nowhere: 200 m up to 10 m, a half circle, 200 m down, a half circle.
radius, rise = 50, 10
half = math.pi * radius
pieces = [  # x, y, heading, length, curvature, height, slope
    (0, 0, 0, 200, 0, 0, rise / 200), (200, 0, 0, half, 1 / radius, rise, 0),
    (200, 100, math.pi, 200, 0, rise, -rise / 200), (0, 100, math.pi, half, 1 / radius, 0, 0)]


def section(s):
    """Two lanes of 3.5 m for each direction, from s on."""
    def lane(number):
        return (f'<lane id="{number}" type="driving" level="false"><link><predecessor id="{number}"/><successor id="{number}"/></link>'
                '<width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>')
    return (f'<laneSection s="{s}"><left>{lane(2)}{lane(1)}</left><center><lane id="0" type="none" level="false"/></center>'
            f'<right>{lane(-1)}{lane(-2)}</right></laneSection>')


def ring(path, starts):
    """Write the ring; the first piece has lane sections that start at these places."""
    roads = ""
    for number, (x, y, heading, length, curvature, height, slope) in enumerate(pieces):
        shape = f'<arc curvature="{curvature}"/>' if curvature else "<line/>"
        roads += (
            f'<road name="" length="{length}" id="{number}" junction="-1"><link>'
            f'<predecessor elementType="road" elementId="{(number - 1) % 4}" contactPoint="end"/>'
            f'<successor elementType="road" elementId="{(number + 1) % 4}" contactPoint="start"/></link>'
            f'<planView><geometry s="0" x="{x}" y="{y}" hdg="{heading}" length="{length}">{shape}</geometry></planView>'
            f'<elevationProfile><elevation s="0" a="{height}" b="{slope}" c="0" d="0"/></elevationProfile><lateralProfile/>'
            '<lanes><laneOffset s="0" a="0" b="0" c="0" d="0"/>'
            + "".join(map(section, [0] if number else starts)) + "</lanes></road>")
    path.write_text('<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="7" name="" version="1" date="" north="0" south="0" east="0" '
                    f'west="0" vendor=""/>{roads}</OpenDRIVE>')


print("py123d", importlib.metadata.version("py123d"))
so = True
for starts in [0], [0, 100]:
    path = pathlib.Path(sys.argv[1]) / "ring.xodr"
    ring(path, starts)
    parser = OpenDriveMapParser(path)
    assert parser.get_map_metadata().map_has_z
    lanes = {item.object_id: item for item in parser.iter_map_objects() if type(item).__name__ == "Lane"}
    last = len(starts) - 1
    print(f"lane sections of the hill: {len(starts)}")
    for number in -1, -2:
        lane = lanes[f"0_{last}_right_{number}"]
        lines = {"left": lane.left_boundary, "centre": lane.centerline, "right": lane.right_boundary}
        x, road = lines["left"].array[-1][0], pieces[0][6] * lines["left"].array[-1][0]
        heights = {name: round(float(line.array[-1][2]), 2) for name, line in lines.items()}
        plan = [round(float(line.array[-1][1]), 2) for line in lines.values()]
        print(f"  lane {number} at its end, x = {x:.0f} m, road {road:.1f} m high:", heights, "y:", plan)
        wrong = {-1: {"left": 10, "centre": 7.5, "right": 5}, -2: {"left": 5, "centre": 5, "right": 5}}[number]
        so &= heights == (wrong if last else dict.fromkeys(lines, 10)) and plan == [(number + 1) * 3.5, (number + 0.5) * 3.5, number * 3.5]
    onward = lanes[lanes[f"0_{last}_right_-2"].successor_ids[0]]
    step = float(onward.centerline.array[0][2] - lanes[f"0_{last}_right_-2"].centerline.array[-1][2])
    so &= round(step, 2) == (5 if last else 0)
    print(f"  from lane -2 to its successor: {step:.1f} m up")
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   py123d 0.7.0
#   lane sections of the hill: 1
#     lane -1 at its end, x = 200 m, road 10.0 m high: {'left': 10.0, 'centre': 10.0, 'right': 10.0} y: [0.0, -1.75, -3.5]
#     lane -2 at its end, x = 200 m, road 10.0 m high: {'left': 10.0, 'centre': 10.0, 'right': 10.0} y: [-3.5, -5.25, -7.0]
#     from lane -2 to its successor: 0.0 m up
#   lane sections of the hill: 2
#     lane -1 at its end, x = 200 m, road 10.0 m high: {'left': 10.0, 'centre': 7.5, 'right': 5.0} y: [0.0, -1.75, -3.5]
#     lane -2 at its end, x = 200 m, road 10.0 m high: {'left': 5.0, 'centre': 5.0, 'right': 5.0} y: [-3.5, -5.25, -7.0]
#     from lane -2 to its successor: 5.0 m up
