#!/bin/sh
# humex-converter-waymo 0.2.0: a lane of the Waymo Open Dataset, 200 m long, whose left line is solid, then broken, then a kerb, has a left bound
# of 50 m; a lane of 40 m beside a kerb of 200 m has a bound of 200 m; and bounds lie at 0 m, under a road 30 m up.
#
# One would guess: a bound of the converted lane consists of the boundary segments of that side, each from `lane_start_index` to
#   `lane_end_index` of the lane's points, with the heights that all points of the dataset have.
# What happens: each segment puts its line in the place of the one before, and only the last one is left; it is taken in full, however little of it
#   runs along the lane. The indices are not looked at (a note says that they are not needed). The height of the lane's middle is
#   kept, those of the bounds are set to 0. The same holds for both sides. A lane with one line on each side, as long as the lane,
#   is right in the plane. There is no warning.
# Source: humex_converter_waymo/map_converter.py (_get_lane_boundary_points, convert_to_proto), release 0.2.0; waymo-open-dataset,
#   protos/map.proto, BoundarySegment and LaneCenter ("There may be different boundary types along this lane"). The file is written with the
#   protocol of waymo-open-dataset-tf-2-12-0 1.6.7, of whose dependencies none is needed for that.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.11 or 3.12 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --only-binary :all: humex-converter-waymo==0.2.0 humex==0.2.3 \
  protobuf==4.25.9 numpy==2.4.6 scipy==1.17.1 shapely==2.2.0 networkx==3.6.1
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --only-binary :all: --no-deps waymo-open-dataset-tf-2-12-0==1.6.7
cat >"$place/run.py" <<'END'
import math
import pathlib
import struct
import sys

from humex_converter_waymo.map_converter import WaymoMapConverter
from waymo_open_dataset.protos import map_pb2, scenario_pb2

path = pathlib.Path(sys.argv[1]) / "scenario.tfrecord"
HEIGHT, HALF = 30, 1.75  # of the road and of half a lane, in metres
Line, Edge = map_pb2.RoadLine, map_pb2.RoadEdge
SOLID, BROKEN, KERB = Line.TYPE_SOLID_SINGLE_WHITE, Line.TYPE_BROKEN_SINGLE_WHITE, None


def checksum(data):
    """The masked CRC-32C of a TFRecord file."""
    rest = 0xFFFFFFFF
    for byte in data:
        rest ^= byte
        for _ in range(8):
            rest = rest >> 1 ^ (0x82F63B78 if rest & 1 else 0)
    rest ^= 0xFFFFFFFF
    return struct.pack("<I", ((rest >> 15 | rest << 17) + 0xA282EAD8) & 0xFFFFFFFF)


def points(target, y, first, last):
    """A line to the east with a point each metre."""
    for x in range(first, last + 1):
        target.add(x=x, y=y, z=HEIGHT)


def convert(lane, left, right):
    """The bounds of a lane from one place to another; each side is given by its lines: from where to where, and of what kind."""
    scenario = scenario_pb2.Scenario(scenario_id="road")
    feature = scenario.map_features.add(id=1)
    feature.lane.type = map_pb2.LaneCenter.TYPE_SURFACE_STREET
    points(feature.lane.polyline, 0, *lane)
    number = 1
    for lines, segments, y in ((left, feature.lane.left_boundaries, HALF), (right, feature.lane.right_boundaries, -HALF)):
        for first, last, kind in lines:
            number += 1
            start, end = max(first, lane[0]) - lane[0], min(last, lane[1]) - lane[0]
            segments.add(lane_start_index=start, lane_end_index=end, boundary_feature_id=number, boundary_type=kind or Line.TYPE_UNKNOWN)
            other = scenario.map_features.add(id=number)
            if kind is KERB:
                other.road_edge.type = Edge.TYPE_ROAD_EDGE_BOUNDARY
                points(other.road_edge.polyline, y, first, last)
            else:
                other.road_line.type = kind
                points(other.road_line.polyline, y, first, last)
    data = scenario.SerializeToString()
    size = struct.pack("<Q", len(data))
    path.write_bytes(size + checksum(size) + data + checksum(data))
    found = WaymoMapConverter(str(path)).convert_to_proto("road").map_data.lanes[1]
    assert {point.z for point in found.center_line[0].points} == {HEIGHT}
    return found.left_boundary[0].points, found.right_boundary[0].points


so = True
for name, lane, left, right, expected in (
    ("a line each, as long as the lane", (0, 200), [(0, 200, SOLID)], [(0, 200, KERB)], [(0, 200), (0, 200)]),
    ("solid, then broken, then a kerb", (0, 200), [(0, 80, SOLID), (80, 150, BROKEN), (150, 200, KERB)], [(0, 200, KERB)], [(150, 200), (0, 200)]),
    ("lane of 40 m beside a kerb of 200 m", (60, 100), [(60, 100, BROKEN)], [(0, 200, KERB)], [(60, 100), (0, 200)]),
):
    bounds = convert(lane, left, right)
    seen = [(round(bound[0].x), round(bound[-1].x)) for bound in bounds]
    heights = {point.z for bound in bounds for point in bound}
    so &= seen == expected and heights == {0.0}
    print("%s: lane from %d m to %d m, at %d m; left bound from %d m to %d m, right bound from %d m to %d m, at %s m" % (
        name, *lane, HEIGHT, *seen[0], *seen[1], ", ".join("%g" % z for z in sorted(heights))))
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   a line each, as long as the lane: lane from 0 m to 200 m, at 30 m; left bound from 0 m to 200 m, right bound from 0 m to 200 m, at 0 m
#   solid, then broken, then a kerb: lane from 0 m to 200 m, at 30 m; left bound from 150 m to 200 m, right bound from 0 m to 200 m, at 0 m
#   lane of 40 m beside a kerb of 200 m: lane from 60 m to 100 m, at 30 m; left bound from 60 m to 100 m, right bound from 0 m to 200 m, at 0 m
