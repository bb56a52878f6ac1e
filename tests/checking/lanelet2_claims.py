#!/usr/bin/env python3
"""What the real Lanelet2 library does with small maps: one JSON object on stdout, of each claim whether it holds.

The claims are those of documents of rules/; lanelet2_claims.rs says which sentence each one stands for.
"""
import json
import math
import os
import sys
import tempfile

# The library prints warnings of its own.
ANSWER = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)

import lanelet2.io
import lanelet2.projection
import lanelet2.routing
import lanelet2.traffic_rules as rules

Participants = rules.Participants


def load(*elements):
    with tempfile.NamedTemporaryFile("w", suffix=".osm", delete=False) as file:
        file.write("<osm version='0.6' generator='test'>" + "".join(elements) + "</osm>")
    projector = lanelet2.projection.LocalCartesianProjector(lanelet2.io.Origin(49.0, 8.0))
    try:
        return lanelet2.io.loadRobust(file.name, projector)
    finally:
        os.unlink(file.name)


def tags(said):
    return "".join(f"<tag k='{key}' v='{value}'/>" for key, value in said.items())


def node(id, lat, lon, ele="1"):
    height = "" if ele is None else tags({"ele": ele})
    return f"<node id='{id}' lat='{lat}' lon='{lon}'>{height}</node>"


def way(id, nodes, said={}):
    return f"<way id='{id}'>" + "".join(f"<nd ref='{one}'/>" for one in nodes) + tags(said) + "</way>"


def relation(id, members, said):
    members = "".join(f"<member type='{kind}' ref='{ref}' role='{role}'/>" for kind, ref, role in members)
    return f"<relation id='{id}'>{members}{tags(said)}</relation>"


def lanelet(id, left, right, said={}, elements=()):
    members = [("way", left, "left"), ("way", right, "right")]
    members += [("relation", one, "regulatory_element") for one in elements]
    return relation(id, members, {"type": "lanelet", "subtype": "road", "location": "urban", **said})


NODES = [node(1, 49.0001, 8.0), node(2, 49.0001, 8.001), node(3, 49.00005, 8.0), node(4, 49.00005, 8.001)]
NODES += [node(5, 49.0, 8.0), node(6, 49.0, 8.001)]
ROWS = [way(11, [1, 2]), way(12, [3, 4])]


def graph(lanelet_map, participant=Participants.Vehicle):
    return lanelet2.routing.RoutingGraph(lanelet_map, rules.create(rules.Locations.Germany, participant))


def conflicts(*elements):
    lanelet_map, _ = load(*NODES, *elements)
    routes = graph(lanelet_map)
    return all(len(routes.conflicting(one)) == 1 for one in lanelet_map.laneletLayer)


def changes(said, inverted=False):
    """Whether a vehicle may change from the left lane to the right one, and from the right one to the left one."""
    middle = way(12, [4, 3] if inverted else [3, 4], said)
    lanelet_map, _ = load(*NODES, way(11, [1, 2]), middle, way(13, [5, 6]), lanelet(21, 11, 12), lanelet(22, 12, 13))
    routes, lanes = graph(lanelet_map), {one.id: one for one in lanelet_map.laneletLayer}
    return routes.right(lanes[21]) is not None, routes.left(lanes[22]) is not None


def one_way(value, participant=Participants.Vehicle):
    said = {} if value is None else {"one_way": value}
    lanelet_map, _ = load(*NODES, *ROWS, lanelet(21, 11, 12, said))
    return rules.create(rules.Locations.Germany, participant).isOneWay(next(iter(lanelet_map.laneletLayer)))


def place(lat, ele="1"):
    lanelet_map, _ = load(node(1, lat, "8.0", ele), node(2, 49.0001, 8.001), way(11, [1, 2]))
    point = next(point for point in lanelet_map.pointLayer if point.id == 1)
    return point.y, point.z


def near(a, b):
    return math.isclose(a, b, abs_tol=1e-6)


def second_line_loads():
    priority = {"type": "regulatory_element", "subtype": "right_of_way"}
    members = [("relation", 21, "right_of_way"), ("relation", 22, "yield"), ("way", 15, "ref_line"), ("way", 16, "ref_line")]
    lines = [way(15, [1, 3]), way(16, [2, 4]), way(13, [5, 6])]
    lanelet_map, errors = load(
        *NODES, *ROWS, *lines, lanelet(21, 11, 12, {}, [31]), lanelet(22, 12, 13), relation(31, members, priority)
    )
    element = next(iter(lanelet_map.regulatoryElementLayer))
    return not errors and element.stopLine.id == 15


def twice():
    """Whether the last of two values of a key counts, and of a height the first."""
    high = node(1, 49.0001, 8.0).replace("</node>", tags({"ele": "5"}) + "</node>")
    limits = lanelet(21, 11, 12, {"speed_limit": "40"}).replace("</relation>", tags({"speed_limit": "60"}) + "</relation>")
    lanelet_map, _ = load(high, *NODES[1:], *ROWS, limits)
    height = next(point.z for point in lanelet_map.pointLayer if point.id == 1)
    return next(iter(lanelet_map.laneletLayer)).attributes["speed_limit"] == "60" and round(height) == 1


DASHED, SIDES = {"type": "line_thin", "subtype": "dashed"}, ("lane_change:left", "lane_change:right")
PAINT = lambda subtype: {"type": "line_thin", "subtype": subtype}
TO_AND_FRO = [lanelet(21, 11, 12), lanelet(22, 12, 11)]
OF_THEIR_OWN = [way(13, [2, 1]), way(14, [4, 3]), lanelet(21, 11, 12), lanelet(22, 14, 13)]

CLAIMS = {
    "dashed": changes(DASHED) == (True, True),
    "one-sided paint": changes(PAINT("solid_dashed")) == (False, True)
    and changes(PAINT("dashed_solid")) == (True, False)
    and changes(PAINT("solid_dashed"), True) == (True, False),
    "other paint": changes(PAINT("solid")) == (False, False) and changes({"type": "virtual"}) == (False, False),
    "lane_change alone": changes({"lane_change": "no", SIDES[0]: "yes", **DASHED}) == (False, False)
    and changes({"lane_change": "yes", SIDES[0]: "no"}) == (True, True),
    "unnamed side": changes({SIDES[0]: "yes", **DASHED}) == (False, True)
    and changes({SIDES[1]: "yes", **DASHED}) == (True, False)
    and changes({SIDES[1]: "no", **DASHED}) == (False, False),
    "left=no alone": changes({SIDES[0]: "no", **DASHED}) == (True, True),
    "both sides": changes({SIDES[0]: "no", SIDES[1]: "yes", **DASHED}) == (True, False),
    "one_way=no": not any(one_way(value) for value in ("no", "false", "0")),
    "no one_way": one_way(None) and not one_way(None, Participants.Pedestrian),
    "shared ways conflict": conflicts(*ROWS, *TO_AND_FRO) and conflicts(*ROWS, *OF_THEIR_OWN),
    "leading digits": near(place("49,00003")[0], 0) and near(place("49.0", "1,5")[1], 1) and near(place("49.0", "1.5 m")[1], 1.5),
    "word": near(place("49.0", "high")[1], 0),
    "second ref_line": second_line_loads(),
    "key twice": twice(),
}

json.dump(CLAIMS, ANSWER)
ANSWER.flush()
