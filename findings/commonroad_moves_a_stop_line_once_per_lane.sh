#!/bin/sh
# CommonRoad-io 2026.1: to move a map by 1 km moves its lanes by 1 km, a stop line across three lanes by 3 km, and a parking area not at all.
#
# One would guess: `LaneletNetwork.translate_rotate` moves the complete network, as its help says: lanes, bounds, stop lines and areas keep
#   their places to each other, as when a map is brought from UTM to a local origin.
# What happens: each lanelet moves its stop line. A stop line that `add_stop_line` was given for several lanelets is one object, and is moved
#   as often as there are lanelets; rotations add up as well, so that a quarter turn of two lanes is a half turn of their line. Bounds of
#   the network, by which areas are defined, are left where they were. `Scenario.translate_rotate` does the same. No warning.
#   A way out: a stop line of its own for each lanelet.
# Source: commonroad/scenario/lanelet.py (add_stop_line, LaneletNetwork.translate_rotate, Lanelet.translate_rotate), release 2026.1.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: commonroad-io==2026.1
cat >"$place/run.py" <<'END'
import math

import numpy
from commonroad.common.common_lanelet import LineMarking, StopLine
from commonroad.scenario.area import Area, AreaBorder, AreaType
from commonroad.scenario.lanelet import Bound, Lanelet, LaneletNetwork
from commonroad.scenario.scenario import Scenario


def network(lanes):
    """Lanes to the east, 3.5 m wide and 100 m long, a stop line across all at their end, a parking area beside the first one."""
    made = LaneletNetwork()
    bounds = [Bound(10 + i, numpy.array([[0.0, 3.5 * i], [100.0, 3.5 * i]])) for i in range(lanes + 1)]
    for bound in bounds:
        made.add_boundary(bound)
    for i in range(lanes):
        right, left = bounds[i : i + 2]
        made.add_lanelet(Lanelet(left, (left.vertices + right.vertices) / 2, right, i + 1))
    line = StopLine(numpy.array([100.0, 0.0]), numpy.array([100.0, 3.5 * lanes]), LineMarking.SOLID, stop_line_id=50)
    made.add_stop_line(line, set(range(1, lanes + 1)))
    made.add_area(Area(60, [AreaBorder(61, 10)], {AreaType.PARKING}), {1})
    return made


def ends(made):
    """Where the first lane, the stop line and the bound of the area end."""
    border = made.find_boundary_by_id(made.areas[0].border[0].boundary)
    return made.lanelets[0].right_vertices[-1], made.lanelets[0].stop_line.start, border.vertices[-1]


so = True
for lanes in 1, 2, 3:
    made = network(lanes)
    before = ends(made)
    made.translate_rotate(numpy.array([1000.0, 0.0]), 0.0)
    moved = [float(after[0] - start[0]) for after, start in zip(ends(made), before)]
    print("%d lanes, moved by 1000 m: the lanes by %.0f m, the stop line by %.0f m, the area's bound by %.0f m" % (lanes, *moved))
    so &= moved == [1000.0, 1000.0 * lanes, 0.0]

scenario = Scenario(0.1)
scenario.add_objects(network(2))
scenario.translate_rotate(numpy.array([0.0, 0.0]), math.pi / 2)
lane, line, border = (numpy.round(end, 6) + 0.0 for end in ends(scenario.lanelet_network))
print("2 lanes of a scenario, turned by 90 degrees: the lanes end at", lane, "the stop line is at", line, "the area's bound at", border)
so &= list(lane) == [0, 100] and list(line) == [-100, 0] and list(border) == [100, 0]
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   1 lanes, moved by 1000 m: the lanes by 1000 m, the stop line by 1000 m, the area's bound by 0 m
#   2 lanes, moved by 1000 m: the lanes by 1000 m, the stop line by 2000 m, the area's bound by 0 m
#   3 lanes, moved by 1000 m: the lanes by 1000 m, the stop line by 3000 m, the area's bound by 0 m
#   2 lanes of a scenario, turned by 90 degrees: the lanes end at [  0. 100.] the stop line is at [-100.    0.] the area's bound at [100.   0.]
