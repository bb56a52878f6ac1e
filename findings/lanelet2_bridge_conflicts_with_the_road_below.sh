#!/bin/sh
# Lanelet2 1.2.3: to the routing graph a bridge 10 m up conflicts with the road below, and does so when asked to leave conflicts out.
#
# One would guess: maps are in 3D, so that lanes 10 m above each other do not conflict; `routingRelation` excludes conflicts unless
#   `includeConflicting=True` is given, as its help says.
# What happens: without the configuration entry `participant_height` the graph compares lanes in the plane, and Python's `RoutingGraph`
#   takes no configuration. `conflicting` names each lane over and under another one, though `geometry.overlaps3d` of the same two is false.
#   `routingRelation` gives `Conflicting` with and without the argument: its filter, "all relations or not conflicting", lets all pass.
# Source: lanelet2_routing, RoutingGraphBuilder.cpp (participantHeight), Graph.h (withoutConflicting); lanelet2_python, routing.cpp; 1.2.3.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check lanelet2==1.2.3
cat >"$place/run.py" <<'END'
import itertools
from lanelet2 import geometry, traffic_rules
from lanelet2.core import Lanelet, LineString3d, Point3d, createMapFromLanelets
from lanelet2.routing import RelationType, RoutingGraph

ids = itertools.count(1)


def lane(*bounds):
    made = Lanelet(next(ids), *(LineString3d(next(ids), [Point3d(next(ids), *place) for place in bound]) for bound in bounds))
    made.attributes["subtype"], made.attributes["location"] = "road", "urban"
    return made


bridge = lane([(0, 2, 10), (50, 2, 10)], [(0, -2, 10), (50, -2, 10)])
below = lane([(23, -20, 0), (23, 20, 0)], [(27, -20, 0), (27, 20, 0)])
rules = traffic_rules.create(traffic_rules.Locations.Germany, traffic_rules.Participants.Vehicle)
graph = RoutingGraph(createMapFromLanelets([bridge, below]), rules)
seen = [
    [geometry.overlaps3d(bridge, below, height) for height in (2.0, 5.0)],
    len(graph.conflicting(bridge)),
    graph.routingRelation(bridge, below),
    graph.routingRelation(bridge, below, includeConflicting=True),
]
print("they overlap within 2 m or 5 m of height:", seen[0])
print("lanes that conflict with the bridge:", seen[1])
print("relation without conflicts: %s, with conflicts: %s" % (seen[2], seen[3]))
raise SystemExit(0 if seen == [[False, False], 1, RelationType.Conflicting, RelationType.Conflicting] else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   they overlap within 2 m or 5 m of height: [False, False]
#   lanes that conflict with the bridge: 1
#   relation without conflicts: Conflicting, with conflicts: Conflicting
