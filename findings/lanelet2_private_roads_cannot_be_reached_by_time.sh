#!/bin/sh
# Lanelet2 1.2.3: a road with `location=private` is part of routes by distance, and cut off for routes by time.
#
# One would guess: which lanes are connected is a matter of the map; the cost decides among ways only. `private` is one of the values that
#   the library itself knows for `location`; without a limit of its own such a road has that of towns, or none.
# What happens: traffic rules know limits for `urban` and `nonurban` alone; any other value (and `exit` lanes outside of towns) is 0 km/h.
#   `RoutingCostTravelTime` means to take 0 as "as fast as you like", but multiplies the greatest number by a speed of 0; the time becomes
#   infinite, and edges of infinite cost are left out of the graph. Routes by the second of the two default costs do not enter the road;
#   if time is the only cost, `following` does not show it either. No error, no warning. A `speed_limit` on the lanelet mends it.
# Source: lanelet2_routing, RoutingCost.cpp (speedLimit), Graph.h (addEdge); lanelet2_traffic_rules, GenericTrafficRules.cpp; release 1.2.3.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check lanelet2==1.2.3
cat >"$place/run.py" <<'END'
import itertools
from lanelet2 import traffic_rules
from lanelet2.core import Lanelet, LineString3d, Point3d, createMapFromLanelets
from lanelet2.routing import RoutingCostTravelTime, RoutingGraph

rules = traffic_rules.create(traffic_rules.Locations.Germany, traffic_rules.Participants.Vehicle)


def seen(**tags):
    """Three lanes one behind the other, the middle one with `tags`: may one pass it, its limit, is it on the way by distance and by time?"""
    ids = itertools.count(1)
    left, right = ([Point3d(next(ids), x, y, 0) for x in (0, 20, 40, 60)] for y in (2, -2))
    lanes = []
    for i in range(3):
        lane = Lanelet(next(ids), *(LineString3d(next(ids), side[i : i + 2]) for side in (left, right)))
        for key, value in {"subtype": "road", "location": "urban", **(tags if i == 1 else {})}.items():
            lane.attributes[key] = value
        lanes.append(lane)
    start, middle, end = lanes
    world = createMapFromLanelets(lanes)
    graph = RoutingGraph(world, rules)
    ways = [graph.shortestPath(start, end, cost) is not None for cost in (0, 1)]
    timed = RoutingGraph(world, rules, [RoutingCostTravelTime(5)])
    return rules.canPass(middle), round(rules.speedLimit(middle).speedLimit), *ways, len(timed.following(start))


cases = {
    "location=urban": (seen(), (True, 50, True, True, 1)),
    "location=private": (seen(location="private"), (True, 0, True, False, 0)),
    "location=private, speed_limit=10": (seen(location="private", speed_limit="10"), (True, 10, True, True, 1)),
    "subtype=exit, location=nonurban": (seen(subtype="exit", location="nonurban"), (True, 0, True, False, 0)),
}
for tags, (found, _) in cases.items():
    print("%-33s passable %s, %2d km/h; way by distance %s, by time %s; lanes that follow, by time alone: %d" % (tags, *found))
raise SystemExit(0 if all(found == expected for found, expected in cases.values()) else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   location=urban                    passable True, 50 km/h; way by distance True, by time True; lanes that follow, by time alone: 1
#   location=private                  passable True,  0 km/h; way by distance True, by time False; lanes that follow, by time alone: 0
#   location=private, speed_limit=10  passable True, 10 km/h; way by distance True, by time True; lanes that follow, by time alone: 1
#   subtype=exit, location=nonurban   passable True,  0 km/h; way by distance True, by time False; lanes that follow, by time alone: 0
