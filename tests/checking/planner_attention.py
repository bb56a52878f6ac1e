#!/usr/bin/env python3
"""Whom Autoware's intersection module watches, derived with the routing graph of the real Lanelet2 library: JSON list of map files on
stdin, JSON list on stdout.

Of each map: {lanelet: {"watched": [...], "ignored": [...], "before": [...], "more": [...]}} for the lanelets with turn_direction that vehicles may
pass; null for a map that does not load. Written from the description of `generateObjectiveLanelets` (autoware_universe, 2cac9af7),
with attention_area_length 200 m and without vehicles in the wrong direction.
"""
import os
import sys
import tempfile

from real_library import answer_all, origin

import lanelet2.geometry
import lanelet2.io
import lanelet2.projection
import lanelet2.routing
import lanelet2.traffic_rules
import xml.etree.ElementTree as xml

LENGTH = 200.0


def as_loaded(path, folder):
    """A copy of the map whose latitudes and longitudes say where `local_x` and `local_y` put the points, as Autoware loads it."""
    tree = xml.parse(path)
    local = {}
    for node in tree.iter("node"):
        tags = {tag.get("k"): tag.get("v") for tag in node.iter("tag")}
        if "local_x" in tags and "local_y" in tags:
            local[node] = (float(tags["local_x"]), float(tags["local_y"]))
    if not local or len(local) < sum(1 for _ in tree.iter("node")):
        return path, origin(path)
    low = [min(place[i] for place in local.values()) for i in (0, 1)]
    for node, (x, y) in local.items():
        node.set("lon", repr((x - low[0]) / 111319.4907932736))
        node.set("lat", repr((y - low[1]) / 110574.2758215946))
    copy = os.path.join(folder, "map.osm")
    tree.write(copy)
    return copy, lanelet2.io.Origin(0, 0)


def relations(path):
    """The members of the elements: the library does not give those of lanelets in Python."""
    tree = xml.parse(path)
    elements, of_lanelet = {}, {}
    for relation in tree.iter("relation"):
        tags = {tag.get("k"): tag.get("v") for tag in relation.iter("tag")}
        members = [(m.get("role"), m.get("type"), int(m.get("ref"))) for m in relation.iter("member")]
        if tags.get("type") == "regulatory_element":
            elements[int(relation.get("id"))] = (tags.get("subtype"), members)
        elif tags.get("type") == "lanelet":
            of_lanelet[int(relation.get("id"))] = [ref for role, _, ref in members if role == "regulatory_element"]
    return elements, of_lanelet


def length(lanelet, known={}):
    """Metres: the mean of both bounds, because the library's middle takes short cuts in hairpins. Each map has a process of its own, so
    that the ids are those of one map."""
    if lanelet.id not in known:
        bounds = (lanelet.leftBound, lanelet.rightBound)
        known[lanelet.id] = sum(lanelet2.geometry.length(lanelet2.geometry.to2D(bound)) for bound in bounds) / 2
    return known[lanelet.id]


def preceding(graph, start, own, most):
    """Every lanelet that is met on the way upstream within a length."""
    best = {}
    work = [(one, most) for one in graph.previous(start) if one.id not in own]
    while work:
        one, rest = work.pop()
        if best.get(one.id, -1.0) >= rest:
            continue
        best[one.id] = rest
        rest -= length(one)
        if rest > 0.0:
            work.extend((other, rest) for other in graph.previous(one) if other.id not in own)
    return set(best) - {start.id}


def attention(path):
    folder = tempfile.mkdtemp()
    try:
        path, zero = as_loaded(path, folder)
        lanelet_map, _ = lanelet2.io.loadRobust(path, lanelet2.projection.LocalCartesianProjector(zero))
    except Exception as error:
        print(path, error, file=sys.stderr)
        return None
    elements, of_lanelet = relations(path)
    rules = lanelet2.traffic_rules.create(
        lanelet2.traffic_rules.Locations.Germany, lanelet2.traffic_rules.Participants.Vehicle
    )
    graph = lanelet2.routing.RoutingGraph(lanelet_map, rules)
    by_id = {lanelet.id: lanelet for lanelet in lanelet_map.laneletLayer}
    answer = {}
    for lanelet in lanelet_map.laneletLayer:
        turn = lanelet.attributes["turn_direction"] if "turn_direction" in lanelet.attributes else ""
        if turn not in ("left", "straight", "right") or not rules.canPass(lanelet):
            continue
        mine = [elements[ref] for ref in of_lanelet.get(lanelet.id, []) if ref in elements]
        lights = [members for subtype, members in mine if subtype == "traffic_light"]
        has_light = bool(lights) and any(role == "ref_line" for role, _, _ in lights[0])
        yields = set()
        for subtype, members in mine:
            if subtype != "right_of_way" or ("right_of_way", "relation", lanelet.id) not in members:
                continue
            for role, _, ref in members:
                if role == "yield" and ref in by_id:
                    yields.add(ref)
                    yields.update(one.id for one in graph.previous(by_id[ref]))
        own = set()
        for before in graph.previous(lanelet):
            own.add(before.id)
            own.update(one.id for one in graph.following(before))
        conflicting = [one for one in graph.conflicting(lanelet) if one.id not in own]
        straight_with_light = turn == "straight" and has_light
        watched = [one for one in conflicting if not straight_with_light and one.id not in yields]
        ids = {one.id for one in watched}
        before = lambda most: sorted(set().union(*(preceding(graph, one, own, most) for one in watched)) - ids)
        answer[lanelet.id] = {
            "watched": sorted(ids),
            "ignored": sorted({one.id for one in conflicting} - ids),
            # The middle of a lane is a matter of taste: with a little less and a little more than the length.
            "before": before(LENGTH - 2.0),
            "more": before(LENGTH + 2.0),
        }
    return answer


answer_all(attention)
