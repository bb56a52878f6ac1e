#!/bin/sh
# Lanelet2 1.2.3: where a speed limit of 100 km/h is written on a road, bicycles ride at 100 km/h; without it they ride at 20.
#
# One would guess: a limit takes speed away and never gives it; a bicycle goes at the lower of its own 20 km/h and
#   what is allowed, and its quickest route prefers the short way.
# What happens: `speed_limit` takes the place of the participant's own speed, which counts only where the tag is missing. Routes for bicycles
#   by `RoutingCostTravelTime` go four times as far, along the road with a limit, rather than on the cycle lane. A lorry, in turn, has
#   no speed of its own at all: on a German motorway 130 km/h, as a car.
#   A way out: `speed_limit:bicycle` beside it.
# Source: lanelet2_traffic_rules, GenericTrafficRules.cpp (speedLimit) and GermanTrafficRules.cpp, release 1.2.3.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check lanelet2==1.2.3
cat >"$place/run.py" <<'END'
from lanelet2.core import Lanelet, LineString3d, Point3d, createMapFromLanelets, getId
from lanelet2.routing import RoutingCostTravelTime, RoutingGraph
from lanelet2.traffic_rules import Locations, Participants, create

bicycle = create(Locations.Germany, Participants.Bicycle)


def lane(left, right, **tags):
    made = Lanelet(getId(), *(LineString3d(getId(), side) for side in (left, right)))
    for key, value in {"type": "lanelet", "location": "nonurban", "one_way": "yes", **tags}.items():
        made.attributes[key.replace("__", ":")] = value
    return made


def points(*places):
    return [Point3d(getId(), x, y, 0) for x, y in places]


def route(**limit):
    """The bicycle's speed on a road, and its quickest way from start to end: by 100 m of cycle lane or by 400 m of road."""
    begin, end = points((0, 2), (0, 0)), points((100, 2), (100, 0))
    start = lane([*points((-50, 2)), begin[0]], [*points((-50, 0)), begin[1]], subtype="bicycle_lane")
    short = lane([begin[0], end[0]], [begin[1], end[1]], subtype="bicycle_lane")
    around = [points((0, 152), (100, 152)), points((2, 150), (98, 150))]
    long = lane([begin[0], *around[0], end[0]], [begin[1], *around[1], end[1]], subtype="road", **limit)
    goal = lane([end[0], *points((150, 2))], [end[1], *points((150, 0))], subtype="bicycle_lane")
    graph = RoutingGraph(createMapFromLanelets([start, short, long, goal]), bicycle, [RoutingCostTravelTime(1.0)])
    path = graph.getRoute(start, goal).shortestPath()
    names = {short.id: "cycle lane", long.id: "road"}
    return bicycle.speedLimit(long).speedLimit, [names[each.id] for each in path if each.id in names]


seen = {
    "no limit": route(),
    "100 km/h": route(speed_limit="100"),
    "100 km/h, bicycles 20": route(speed_limit="100", speed_limit__bicycle="20"),
}
for name, (speed, way) in seen.items():
    print(f"{name}: a bicycle rides at {speed:g} km/h and takes the {way[0]}")
motorway = lane(points((0, 3), (50, 3)), points((0, 0), (50, 0)), subtype="highway")
lorry = create(Locations.Germany, Participants.VehicleTruck).speedLimit(motorway).speedLimit
print(f"a lorry on a motorway: {lorry:g} km/h")
wanted = {"no limit": (20, ["cycle lane"]), "100 km/h": (100, ["road"]), "100 km/h, bicycles 20": (20, ["cycle lane"])}
raise SystemExit(0 if {k: (round(s), w) for k, (s, w) in seen.items()} == wanted and round(lorry) == 130 else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   no limit: a bicycle rides at 20 km/h and takes the cycle lane
#   100 km/h: a bicycle rides at 100 km/h and takes the road
#   100 km/h, bicycles 20: a bicycle rides at 20 km/h and takes the cycle lane
#   a lorry on a motorway: 130 km/h
