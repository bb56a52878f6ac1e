#!/usr/bin/env python3
"""Who may drive or walk from where to where, by the real Lanelet2 library: JSON list of map files on stdin, JSON list on stdout.

Of each map: {participant: [[relation, from, to], ...]}, sorted; a lanelet against its direction has its id with a minus after it.
Relations: pass (both the same), following, left, right, adjacent_left, adjacent_right. null for a map that does not load.
"""
import json
import os
import sys

# The library prints warnings of its own.
ANSWER = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)

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


def origin(path):
    for _, node in xml.iterparse(path):
        if node.tag == "node":
            lat, lon = float(node.get("lat") or 0), float(node.get("lon") or 0)
            if abs(lat) <= 90 and abs(lon) <= 180:
                return lanelet2.io.Origin(lat, lon)
    return lanelet2.io.Origin(0, 0)


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


def apart(path):
    """The same in a process of its own: the library ends the process on some broken maps."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        with os.fdopen(write, "w") as out:
            json.dump(pairs(path), out)
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as answer:
        text = answer.read()
    _, status = os.waitpid(child, 0)
    return json.loads(text) if status == 0 and text else None


json.dump([apart(path) for path in json.load(sys.stdin)], ANSWER)
ANSWER.flush()
