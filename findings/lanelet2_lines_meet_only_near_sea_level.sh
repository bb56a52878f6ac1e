#!/bin/sh
# Lanelet2 1.2.3: two lines that cross at one height intersect in 3D if that is 10 m above the sea, and do not if it is 500 m.
#
# One would guess: `geometry.intersects3d(line, other, heightTolerance)` finds the crossing in the plane and compares the heights of both
#   lines there; to lift the whole map changes nothing.
# What happens: the crossing is taken as a point at height 0 and projected onto both lines in space, to the nearest point. On a line that
#   climbs by 2 % the foot of that perpendicular lies 2 % of the altitude away, along the line: 10 m at 500 m above the sea. The distance
#   of both feet is held against the tolerance. So roads that meet do so on flat land or near the sea only, and in `LocalCartesianProjector`
#   with an origin at their own height.
# Source: lanelet2_core, geometry/impl/LineString.h, intersects3d, release 1.2.3.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check lanelet2==1.2.3
cat >"$place/run.py" <<'END'
from lanelet2.core import LineString3d, Point3d
from lanelet2.geometry import intersects3d


def line(*places):
    return LineString3d(1, [Point3d(i + 2, *place) for i, place in enumerate(places)])


def meet(height, slope, above=0):
    """Whether a line to the east that climbs by `slope` meets a level one to the north, `above` metres over it, within 3 m of height."""
    climbing = line((-1000, 0, height - 1000 * slope), (1000, 0, height + 1000 * slope))
    level = line((0, -1000, height + above), (0, 1000, height + above))
    return intersects3d(climbing, level, 3.0)


heights = 0, 100, 500, 1000
seen = {slope: [meet(height, slope) for height in heights] for slope in (0, 0.005, 0.02, 0.1)}
print("they meet, at heights of", heights)
for slope, met in seen.items():
    print("  climbing by %4.1f %%: %s" % (slope * 100, met))
print("a bridge 6 m above, at 0 m:", meet(0, 0.02, 6))
expected = {0: [True] * 4, 0.005: [True, True, True, False], 0.02: [True, True, False, False], 0.1: [True, False, False, False]}
raise SystemExit(0 if seen == expected and not meet(0, 0.02, 6) else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   they meet, at heights of (0, 100, 500, 1000)
#     climbing by  0.0 %: [True, True, True, True]
#     climbing by  0.5 %: [True, True, True, False]
#     climbing by  2.0 %: [True, True, False, False]
#     climbing by 10.0 %: [True, False, False, False]
#   a bridge 6 m above, at 0 m: False
