"""Compares the movements a map permits with those that SUMO's netconvert finds in the same extract.

usage: movements.py LANEWRIGHT EXTRACT.osm ... [--list]

A movement is a pair: road and direction in, road and direction out. Both programs may join nodes to one intersection; what
netconvert keeps apart inside one of ours is walked through. Turning back on one road is left out (--no-turnarounds), and
so is what only one of the two draws at all; both are counted. Needs the wheels of eclipse-sumo, lanelet2 and shapely.
Prints a table; --list adds every pair on which they differ. Exit code 1 if fewer than 97 % of all pairs agree.
"""

import argparse
import collections
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

import lanelet2
import shapely

LEAST = 0.97
# How far from a road's line, in metres, an edge of its way may lie and still be it (placement moves lines).
FAR = 15.0


class Plane:
    """Metres around the first place it sees; good for one town."""

    def __init__(self, lon, lat):
        self.lon, self.lat, self.wide = lon, lat, math.cos(math.radians(lat))

    def __call__(self, lon, lat):
        return (lon - self.lon) * 111_320.0 * self.wide, (lat - self.lat) * 110_574.0


class Streets:
    """Our roads and intersections, from `lanewright geometry`."""

    def __init__(self, path):
        features = json.loads(pathlib.Path(path).read_text())["features"]
        of = lambda kind: [f["properties"] for f in features if f["properties"]["type"] == kind]
        roads = of("road")
        self.plane = Plane(*roads[0]["centerline"][0])
        self.lines, self.by_way = {}, collections.defaultdict(list)
        for road in roads:
            self.lines[road["id"]] = shapely.LineString([self.plane(*p[:2]) for p in road["centerline"]])
            for way in road["osm_ids"]:
                self.by_way[str(way)].append(road["id"])
        self.inner = collections.defaultdict(list)
        for inside in (inside for node in of("intersection") for inside in node.get("inner") or []):
            for way in inside["osm_ids"]:
                self.inner[str(way)].append(shapely.LineString([self.plane(*p[:2]) for p in inside["centerline"]]))

    def turn(self, enter, leave):
        """The angle in degrees from one road's direction where it ends to another's where it begins, counter-clockwise."""

        def heading(place, at_end):
            road, forward = place
            line = self.lines[road] if forward else self.lines[road].reverse()
            reach = min(10.0, line.length)
            ends = (line.length - reach, line.length) if at_end else (0.0, reach)
            (a, b), (c, d) = (line.interpolate(s).coords[0] for s in ends)
            return math.atan2(d - b, c - a)

        return (math.degrees(heading(leave, False) - heading(enter, True)) + 180.0) % 360.0 - 180.0

    def along(self, road, step):
        """The cosine between a step, two places, and the road's line there."""
        line = self.lines[road]
        at = line.project(shapely.Point(step[0]))
        near = [line.interpolate(s).coords[0] for s in (max(at - 0.5, 0.0), min(at + 0.5, line.length))]
        (ax, ay), (bx, by) = ((b[0] - a[0], b[1] - a[1]) for a, b in (step, near))
        return (ax * bx + ay * by) / max(math.hypot(ax, ay) * math.hypot(bx, by), 1e-9)


def closure(starts, onward, place):
    """Pairs of places, from each start over all steps without a place to the next that have one."""
    pairs = set()
    for start in starts:
        seen, queue = set(), list(onward[start])
        while queue:
            step = queue.pop()
            if step in seen:
                continue
            seen.add(step)
            if step in place:
                if place[step] != place[start]:
                    pairs.add((place[start], place[step]))
            else:
                queue.extend(onward[step])
    return pairs


def ours(lanewright, extract, work):
    """Streets, the places our map has lanelets for, and its movements."""
    streets, made = work / "streets.geojson", work / "map"
    for command in (["geometry", extract, "-o", streets], ["build", extract, "-o", made]):
        subprocess.run([lanewright, *command], check=True, capture_output=True)
    streets = Streets(streets)
    origin = lanelet2.io.Origin(streets.plane.lat, streets.plane.lon)
    projector = lanelet2.projection.UtmProjector(origin)
    whole, _ = lanelet2.io.loadRobust(str(made / "lanelet2_map.osm"), projector)
    rules = lanelet2.traffic_rules.create(lanelet2.traffic_rules.Locations.Germany, lanelet2.traffic_rules.Participants.Vehicle)
    graph = lanelet2.routing.RoutingGraph(whole, rules)
    place, onward = {}, collections.defaultdict(list)

    def flat(point):
        place = projector.reverse(lanelet2.core.BasicPoint3d(point.x, point.y, 0.0))
        return streets.plane(place.lon, place.lat)

    for lanelet in whole.laneletLayer:
        if not rules.canPass(lanelet):
            continue
        onward[lanelet.id] = [after.id for after in graph.following(lanelet)]
        if "road_id" in lanelet.attributes:
            road = lanelet.attributes["road_id"]
            line = shapely.LineString([flat(p) for p in lanelet.centerline])
            middle = [line.interpolate(line.length / 2 + d).coords[0] for d in (0.0, min(0.5, line.length / 4))]
            place[lanelet.id] = (road, streets.along(road, middle) > 0.0)
    return streets, set(place.values()), closure(list(place), onward, place)


def theirs(extract, streets, drawn, work):
    """The places netconvert has edges for that passenger cars may use, and its movements. `drawn` are the roads with
    lanelets; the others lie whole inside an intersection."""
    import sumo

    home = pathlib.Path(sumo.SUMO_HOME)
    net = work / "net.xml"
    options = "--no-turnarounds --no-internal-links --output.original-names --keep-edges.by-vclass passenger"
    types = home / "data/typemap/osmNetconvert.typ.xml"
    command = [home / "bin/netconvert", "-t", types, *options.split(), "--osm-files", extract, "-o", net]
    subprocess.run(command, check=True, capture_output=True, env={**os.environ, "SUMO_HOME": str(home)})
    source = xml.parse(extract).getroot()
    at = {n.get("id"): streets.plane(float(n.get("lon")), float(n.get("lat"))) for n in source.iter("node")}
    ways = {w.get("id"): [nd.get("ref") for nd in w.iter("nd") if nd.get("ref") in at] for w in source.iter("way")}
    root = xml.parse(net).getroot()
    place, inside, edges = {}, set(), root.findall("edge")
    for edge in edges:
        name, first, last = edge.get("id"), edge.get("from"), edge.get("to")
        way = name.lstrip("-").split("#")[0]
        nodes = ways.get(way, [])
        if first not in nodes or last not in nodes:
            continue
        line = shapely.LineString([at[n] for n in between(nodes, first, last, name.startswith("-"))])
        middle = [line.interpolate(line.length / 2 + d).coords[0] for d in (0.0, 0.25)]
        point = shapely.Point(middle[0])
        near = [(streets.lines[road].distance(point), road) for road in streets.by_way[way]]
        away = min((line.distance(point) for line in streets.inner[way]), default=FAR)
        if near and min(near)[0] < min(away, FAR) and min(near)[1] in drawn:
            road = min(near)[1]
            place[name] = (road, streets.along(road, middle) > 0.0)
        elif near or away < FAR:
            inside.add(name)
    onward = collections.defaultdict(list)
    for connection in root.findall("connection"):
        if connection.get("to") in place or connection.get("to") in inside:
            onward[connection.get("from")].append(connection.get("to"))
    return set(place.values()), closure(list(place), onward, place)


def between(nodes, first, last, back):
    """The part of a way from one of its nodes to another; a ring may pass its end."""
    if back:
        nodes = nodes[::-1]
    start = nodes.index(first)
    if last in nodes[start + 1:]:
        return nodes[start:nodes.index(last, start + 1) + 1]
    return nodes[start:] + nodes[1:nodes.index(last) + 1]


def name(place):
    return f"{place[0]} {'+' if place[1] else '-'}"


def compare(lanewright, extract):
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as work:
        work = pathlib.Path(work)
        streets, here, mine = ours(lanewright, extract, work)
        there, other = theirs(extract, streets, {road for road, _ in here}, work)
    both = here & there
    turns = sum(a[0] == b[0] for a, b in mine | other)
    keep = lambda pairs: {(a, b) for a, b in pairs if a in both and b in both and a[0] != b[0]}
    return streets, keep(mine), keep(other), (here - there, there - here), turns


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lanewright", type=pathlib.Path)
    parser.add_argument("extracts", type=pathlib.Path, nargs="+")
    parser.add_argument("--list", action="store_true")
    args = parser.parse_args()
    print("| extract | both | only ours | only netconvert | agree | one-sided roads | turning back |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    agreed = total = 0
    for extract in args.extracts:
        streets, mine, other, single, turns = compare(args.lanewright.resolve(), extract.resolve())
        union = len(mine | other)
        agreed, total = agreed + len(mine & other), total + union
        share = 100.0 * len(mine & other) / max(union, 1)
        only = len(mine - other), len(other - mine)
        print(f"| {extract.stem} | {len(mine & other)} | {only[0]} | {only[1]} | {share:.1f} % | {len(single[0])} + {len(single[1])} | {turns} |", flush=True)
        if args.list:
            for label, pairs in (("ours", mine - other), ("netconvert", other - mine)):
                for a, b in sorted(pairs):
                    print(f"    only {label}: {name(a)} -> {name(b)}, {streets.turn(a, b):.0f} degrees")
            for label, places in (("ours", single[0]), ("netconvert", single[1])):
                for place in sorted(places):
                    print(f"    road only {label}: {name(place)}")
    share = agreed / max(total, 1)
    print(f"\n{agreed} of {total} movements agree: {100 * share:.2f} %, at least {100 * LEAST:g} % wanted")
    sys.exit(0 if share >= LEAST else 1)


if __name__ == "__main__":
    main()
