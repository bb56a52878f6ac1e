#!/usr/bin/env python3
"""Who may drive or walk from where to where, by the real Lanelet2 library: JSON list of map files on stdin, JSON list on stdout.

Of each map: {participant: [[relation, from, to], ...]}, sorted; a lanelet against its direction has its id with a minus after it.
Relations: pass (both the same), following, left, right, adjacent_left, adjacent_right. null for a map that does not load.
"""
import sys

from real_library import answer_all, origin

import lanelet2.io
import lanelet2.projection
import lanelet2.routing
import lanelet2.traffic_rules
import xml.etree.ElementTree as xml

# The wheel knows no other participants by name; those of vehicles are told apart by tags alone.
Participants = lanelet2.traffic_rules.Participants
PARTICIPANTS = {
    "vehicle": Participants.Vehicle,
    "vehicle:bus": Participants.VehicleBus,
    "vehicle:truck": Participants.VehicleTruck,
    "vehicle:car": Participants.VehicleCar,
    "vehicle:taxi": Participants.VehicleTaxi,
    "vehicle:emergency": Participants.VehicleEmergency,
    "pedestrian": Participants.Pedestrian,
    "bicycle": Participants.Bicycle,
}


def pairs(path):
    try:
        lanelet_map, _ = lanelet2.io.loadRobust(path, lanelet2.projection.LocalCartesianProjector(origin(path)))
    except Exception as error:
        print(path, error, file=sys.stderr)
        return None
    lanelets = [one for each in lanelet_map.laneletLayer for one in (each, each.invert())]
    name = lambda one: f"{one.id}{'-' if one.inverted() else ''}"
    answer = {}
    for participant, value in PARTICIPANTS.items():
        rules = lanelet2.traffic_rules.create(lanelet2.traffic_rules.Locations.Germany, value)
        graph = lanelet2.routing.RoutingGraph(lanelet_map, rules)
        found = []
        for one in lanelets:
            if not rules.canPass(one):
                continue
            found.append(["pass", name(one), name(one)])
            for relation, others in (
                ("following", graph.following(one)),
                ("left", [graph.left(one)]),
                ("right", [graph.right(one)]),
                ("adjacent_left", [graph.adjacentLeft(one)]),
                ("adjacent_right", [graph.adjacentRight(one)]),
            ):
                found.extend([relation, name(one), name(other)] for other in others if other is not None)
        answer[participant] = sorted(found)
    return answer


answer_all(pairs)
