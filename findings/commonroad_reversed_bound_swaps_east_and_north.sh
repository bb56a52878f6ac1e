#!/bin/sh
# CommonRoad-io 2026.1: a bound that is drawn against the lane and marked so is not only turned around, it exchanges east and north.
#
# One would guess: two lanes of opposite directions share the line between them; for the oncoming lane `left_bound_reverse=True` gives the
#   same points in the other order. That is all that the help says: whether the left boundary must be reversed.
# What happens: the array of points is flipped along both axes, so that x and y change places, and with heights x and z. Of an oncoming lane
#   around (1050, 205) the left bound comes to lie around (204, 1050), 1.2 km away. With one reversed bound the lane is a strip of 8 hectares
#   from the one place to the other, with two it is a lane of the right width at the wrong place. No warning; a position on the real lane
#   is found on no lanelet. A way out: hand over the array `bound.vertices[::-1]` in place of the bound.
# Source: commonroad/scenario/lanelet.py (_boundary_to_vertices, Lanelet.__init__), release 2026.1.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: commonroad-io==2026.1
cat >"$place/run.py" <<'END'
import numpy
from commonroad.common.common_lanelet import LineMarking
from commonroad.scenario.lanelet import Bound, Lanelet, LaneletNetwork


def line(y, *height):
    """A line to the east, 100 m long."""
    return numpy.array([[x, y, *height] for x in (1000.0, 1050.0, 1100.0)])


middle = Bound(12, line(203.5), LineMarking.DASHED)
east = Lanelet(middle, line(201.75), line(200.0), 1)
own = Lanelet(middle, line(205.25)[::-1], line(207.0)[::-1], 2, left_bound_reverse=True)
both = Lanelet(middle, line(205.25)[::-1], Bound(11, line(207.0)), 3, left_bound_reverse=True, right_bound_reverse=True)
high = Lanelet(Bound(12, line(203.5, 50.0)), line(205.25, 50.0)[::-1], line(207.0, 50.0)[::-1], 4, left_bound_reverse=True)

plain = Lanelet(middle.vertices[::-1], line(205.25)[::-1], line(207.0)[::-1], 5)

wanted = middle.vertices[::-1]
away = numpy.linalg.norm(own.left_vertices - wanted, axis=1).mean()
print("the line is drawn from", middle.vertices[0], "to", middle.vertices[-1])
print("left bound of the lane to the east:", east.left_vertices[0], "to", east.left_vertices[-1])
print("left bound of the oncoming lane:   ", own.left_vertices[0], "to", own.left_vertices[-1], "- on average %.0f m away" % away)
print("the same with heights:             ", high.left_vertices[0], "to", high.left_vertices[-1])

found = {}
for name, lane in ("its left bound reversed", own), ("both bounds reversed", both), ("points reversed by hand", plain):
    network = LaneletNetwork.create_from_lanelet_list([east, lane], cleanup_ids=False)
    on_lane, mirrored = network.find_lanelet_by_position([numpy.array([1050.0, 205.25]), numpy.array([205.25, 1050.0])])
    found[name] = on_lane, mirrored, round(lane.polygon.shapely_object.area, -2)
    print("oncoming lane, %-23s: at its middle is %s, at the mirrored place %s; it covers %.0f m2" % (name, *found[name]))

so = numpy.array_equal(own.left_vertices, wanted[:, ::-1]) and away > 1100
so &= numpy.array_equal(high.left_vertices[0], [50.0, 203.5, 1100.0])
so &= numpy.array_equal(east.left_vertices, middle.vertices)
so &= found["its left bound reversed"][0] == [] and found["its left bound reversed"][2] > 80_000
so &= found["both bounds reversed"][:2] == ([], [3]) and found["points reversed by hand"][:2] == ([5], [])
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   the line is drawn from [1000.   203.5] to [1100.   203.5]
#   left bound of the lane to the east: [1000.   203.5] to [1100.   203.5]
#   left bound of the oncoming lane:    [ 203.5 1100. ] to [ 203.5 1000. ] - on average 1197 m away
#   the same with heights:              [  50.   203.5 1100. ] to [  50.   203.5 1000. ]
#   oncoming lane, its left bound reversed: at its middle is [], at the mirrored place [2]; it covers 84500 m2
#   oncoming lane, both bounds reversed   : at its middle is [], at the mirrored place [3]; it covers 400 m2
#   oncoming lane, points reversed by hand: at its middle is [5], at the mirrored place []; it covers 400 m2
