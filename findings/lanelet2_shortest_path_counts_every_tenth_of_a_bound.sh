#!/bin/sh
# Lanelet2 1.2.3: the "shortest" path is twice as long as another one, because a winding road is one lanelet; cut into ten, it is passed by.
#
# One would guess: `RoutingCostDistance` weighs the length of centre lines in the plane, which `Route.length2d` and `geometry.length2d`
#   give; to cut a lanelet changes no route.
# What happens: the cost is `approximatedLength2d`: the left bound, of which only every tenth part of its points counts. Up to 19 points
#   that is the left bound as it is; of 40 points every fourth is taken, and ten hairpins of four points each become a straight line: 790 m
#   of road cost 194 m. `RoutingCostTravelTime`, the least length of a lane change and `reachableSet` reckon with the same figure.
# Source: lanelet2_routing, RoutingCost.h and RoutingCost.cpp; lanelet2_core, geometry/impl/Lanelet.h; release 1.2.3.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check lanelet2==1.2.3
cat >"$place/run.py" <<'END'
import itertools
from lanelet2 import geometry, routing, traffic_rules
from lanelet2.core import Lanelet, LineString3d, Point3d, createMapFromLanelets

ids = itertools.count(1)
rules = traffic_rules.create(traffic_rules.Locations.Germany, traffic_rules.Participants.Vehicle)


def points(*places):
    return [Point3d(next(ids), x, y, 0) for x, y in places]


def lane(left, right):
    made = Lanelet(next(ids), LineString3d(next(ids), left), LineString3d(next(ids), right))
    made.attributes["subtype"], made.attributes["location"] = "road", "urban"
    return made


# A lane 4 m wide winds up and down ten times, 30 m each way, to the east; a way around the whole leads to the same place.
turns = range(10)
left = [place for k in turns for place in ((20 * k - 2, 2 if k else 0), (20 * k - 2, 32), (20 * k + 12, 32), (20 * k + 12, 2 if k < 9 else 0))]
right = [place for k in turns for place in ((20 * k + 2, -2 if k else 0), (20 * k + 2, 28), (20 * k + 8, 28), (20 * k + 8, -2 if k < 9 else 0))]
left, right = points(*left), points(*right)
start = lane(points((-2, -20)) + left[:1], points((2, -20)) + right[:1])
end = lane(left[-1:] + points((192, -20)), right[-1:] + points((188, -20)))
around = lane(left[:1] + points((-22, 62), (212, 62)) + left[-1:], right[:1] + points((-16, 58), (206, 58)) + right[-1:])
whole = [lane(left, right)]
pieces = [lane(left[i : i + 5], right[i : i + 5]) for i in range(0, 39, 4)]


def length(lanes):
    return round(sum(map(geometry.length2d, lanes)))


def route(winding):
    graph = routing.RoutingGraph(createMapFromLanelets([start, end, around, *winding]), rules, [routing.RoutingCostDistance(0)])
    return "around" if around in list(graph.shortestPath(start, end, 0, False)) else "winding"


seen = length([around]), length(whole), length(pieces), route(whole), route(pieces)
print("way around: %d m; winding road: %d m, cut: %d m\nshortest with it in one: %s\nshortest with it cut: %s" % seen)
print("it costs: in one %.0f, cut %.0f" % tuple(sum(map(geometry.approximatedLength2d, lanes)) for lanes in (whole, pieces)))
raise SystemExit(0 if seen[0] < 400 < 700 < seen[1] == seen[2] and seen[3:] == ("winding", "around") else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   way around: 354 m; winding road: 790 m, cut: 790 m
#   shortest with it in one: winding
#   shortest with it cut: around
#   it costs: in one 194, cut 798
