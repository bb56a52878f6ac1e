#!/bin/sh
# nuScenes devkit 1.2.0: the end of a lane 51 m long lies 59.5 m along it.
#
# One would guess: `project_pose_to_lane` returns, as it says, the closest pose of the lane and the distance along the lane at that pose,
#   within the resolution (0.5 m); it is at most `length_of_lane`.
# What happens: the distance is the number of the nearest sample times the resolution that was asked for. But each arc of a lane is sampled
#   in equal steps that are shorter than asked for, and where two arcs meet the point is there twice. A lane of many short arcs, as
#   the maps have them, comes out up to a half too long; the pose is right. Beyond the last arc, the devkit's own
#   `get_curvature_at_distance_along_lane` has no answer to such a distance; before it, it looks at the wrong place.
# Source: nuscenes/map_expansion/arcline_path_utils.py (discretize, project_pose_to_lane), release 1.2.0.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check numpy
# The module needs none of the many packages that the devkit asks for, so that it is loaded alone.
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-deps nuscenes-devkit==1.2.0
cat >"$place/run.py" <<'END'
import importlib.metadata, importlib.util, math

file = importlib.metadata.distribution("nuscenes-devkit").locate_file("nuscenes/map_expansion/arcline_path_utils.py")
spec = importlib.util.spec_from_file_location("arcline_path_utils", file)
arcs = importlib.util.module_from_spec(spec)
spec.loader.exec_module(arcs)


def lane(count, length, bend=0):
    """A lane to the east of `count` straight pieces, the last of which is a left turn if `bend` is its radius."""
    pieces = []
    for i in range(count):
        turn = bend and i == count - 1
        pieces.append({
            "start_pose": (i * length, 0.0, 0.0),
            "end_pose": ((i + 1) * length, 0.0, 0.0),
            "shape": "LSL" if turn else "LSR",
            "radius": bend or 999.0,
            "segment_length": [length, 0.0, 0.0] if turn else [0.0, length, 0.0],
        })
    return pieces


seen = {}
for count, length in (1, 40.0), (4, 10.1), (10, 5.1), (20, 2.1):
    whole = lane(count, length)
    pose, distance = arcs.project_pose_to_lane((count * length, 0.0, 0.0), whole)
    seen[count] = round(arcs.length_of_lane(whole), 2), round(pose[0], 2), float(distance)
    print("%2d pieces of %4.1f m, %.1f m in all: the end is at x = %.1f, said to be at %.1f m" % (count, length, *seen[count]))
# the last 5.1 m of 51 m are a turn of radius 10 m; it begins at 45.9 m
turning = lane(10, 5.1, bend=10.0)
pose, distance = arcs.project_pose_to_lane((43.0, 0.0, 0.0), turning)
curvature = arcs.get_curvature_at_distance_along_lane(float(distance), turning)
print("at x = %.1f, 2.9 m before the turn: said to be at %.1f m, curvature %.1f" % (pose[0], distance, curvature))
expected = {1: (40.0, 40.0, 40.0), 4: (40.4, 40.4, 43.5), 10: (51.0, 51.0, 59.5), 20: (42.0, 42.0, 59.5)}
raise SystemExit(0 if seen == expected and abs(pose[0] - 43) < 0.3 and distance > 49 and math.isclose(curvature, 0.1) else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#    1 pieces of 40.0 m, 40.0 m in all: the end is at x = 40.0, said to be at 40.0 m
#    4 pieces of 10.1 m, 40.4 m in all: the end is at x = 40.4, said to be at 43.5 m
#   10 pieces of  5.1 m, 51.0 m in all: the end is at x = 51.0, said to be at 59.5 m
#   20 pieces of  2.1 m, 42.0 m in all: the end is at x = 42.0, said to be at 59.5 m
#   at x = 43.1, 2.9 m before the turn: said to be at 50.5 m, curvature 0.1
