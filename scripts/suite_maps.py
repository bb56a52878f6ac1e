"""What the comparisons of suites.py share: inputs, built maps, the routes that they have, the count of rows."""

import collections
import heapq
import json
import math
import os
import re
import subprocess
import tempfile
import xml.etree.ElementTree as xml

# Degrees of a metre at the equator, near which the cases lie.
DEGREE = 1 / 111_319.5
ORIGIN = (8.0, 50.5)  # longitude, latitude
DRIVEN = {"road"}

# Why a row of a suite is not what a map should have: what the tags hold, and the reason. All words of a key have to be there.
JUDGED = [
    (["=private"], "private ground is built as private roads, which other engines close unless told"),
    (["=permit"], "as private"), (["=customers"], "as private"), (["=delivery"], "as private"),
    (["=destination"], "as private"), (["=residents"], "as private"),
    (["highway=runway"], "a runway is no road, whatever its access tags"),
    (["highway=garbagetag"], "an unknown highway is no road"),
    (["highway=winter_road"], "a road on ice has no lanes"), (["highway=ice_road"], "a road on ice has no lanes"),
    (["highway=footway"], "a way for people is built where a setting asks; a note says so"),
    (["highway=pedestrian"], "a way for people is built where a setting asks; a note says so"),
    (["highway=cycleway"], "a way for bicycles is built where a setting asks; a note says so"),
    (["highway=steps"], "no road"),
    (["=official"], "OpenStreetMap's official is a signed permission (as GraphHopper reads it)"),
    (["maxheight"], "what is too low for a car depends on the car"), (["maxwidth"], "depends on the car"),
    (["maxlength"], "depends on the car"), (["maxweight"], "depends on the car"), (["width="], "depends on the car"),
    (["tracktype"], "a poor surface is no ban"), (["surface="], "a poor surface is no ban"),
    (["smoothness"], "a poor surface is no ban"),
    (["route=ferry"], "a ferry is no road"), (["route=shuttle_train"], "a train is no road"),
    (["man_made=pier"], "a pier is no road"), (["railway="], "rails are no road"), (["bridge=movable"], "no highway"),
    ([":conditional"], "a permission at some hours is none: a map has no clock"),
    (["node/barrier=kerb"], "a kerb between carriageways is driven over (as OpenStreetMap's page of kerbs says of lowered ones)"),
    (["node/barrier=some_tag"], "an unknown barrier does not close a street that has no other sign of it"),
    (["barrier=chain"], "a chain is closed, as OSRM has it; GraphHopper opens it"),
    (["highway=construction"], "no road yet"), (["construction"], "no road yet"),
    (["impassable"], "nobody gets through"),
    (["oneway=reversible"], "left out until a setting gives it a direction, as OSRM does"),
    (["highway=busway"], "a busway is for buses"),
    (["hov"], "a map does not know how many people are on board"),
    (["node/bus=no"], "a map has lanes for buses, and none that bars buses alone"),
    (["bus=no"], "a map has lanes for buses, and none that bars buses alone"),
    (["bus:forward=no"], "a map has lanes for buses, and none that bars buses alone"),
    (["bus:backward=no"], "a map has lanes for buses, and none that bars buses alone"),
    (["oneway:bus="], "a map has lanes for buses, and none that bars buses alone"),
    (["highway=road"], "a road of unknown class is a road, as GraphHopper has it"),
    (["highway=track"], "a track is a road unless its access tags close it, as GraphHopper has it"),
    (["highway=motorway"], "a motorway is one-way without a tag, as OSRM and OpenStreetMap's page have it"),
    (["lanes:both_ways=2"], "two lanes for both directions are what the tags say"),
    (["cycleway:left=track", "oneway:bicycle=no"], "a track on the far side is ridden against the traffic (docs/lanes.md)"),
    (["cycleway:left=opposite_track"], "a track against the traffic is ridden against it (docs/lanes.md)"),
]


def text_of(repo, path):
    """The text of a file of a repository, from its work tree or its git directory."""
    plain = os.path.join(repo, path)
    if os.path.exists(plain):
        return open(plain, encoding="utf-8").read()
    return subprocess.run(["git", "-C", repo, "show", f"HEAD:{path}"], capture_output=True, text=True, check=True).stdout


def osm(nodes, ways, relations):
    """An OpenStreetMap file: nodes by name with (x, y, tags) in metres, ways as (node names, tags), relations as (members, tags)."""
    ids = {name: i + 1 for i, name in enumerate(nodes)}
    root = xml.Element("osm", version="0.6")
    squeeze = math.cos(math.radians(ORIGIN[1]))

    def tag(element, tags):
        for key, value in tags.items():
            xml.SubElement(element, "tag", k=key, v=value)

    for name, (x, y, tags) in nodes.items():
        lon, lat = ORIGIN[0] + x * DEGREE / squeeze, ORIGIN[1] + y * DEGREE
        tag(xml.SubElement(root, "node", id=str(ids[name]), lat=f"{lat:.8f}", lon=f"{lon:.8f}"), tags)
    for i, (members, tags) in enumerate(ways):
        way = xml.SubElement(root, "way", id=str(1000 + i))
        for name in members:
            xml.SubElement(way, "nd", ref=str(ids[name]))
        tag(way, tags)
    for i, (members, tags) in enumerate(relations):
        relation = xml.SubElement(root, "relation", id=str(5000 + i))
        for kind, ref, role in members:
            ref = ids[ref] if kind == "node" else 1000 + ref
            xml.SubElement(relation, "member", type=kind, ref=str(ref), role=role)
        tag(relation, tags)
    return xml.tostring(root, encoding="unicode")


class Map:
    """The lanelets of a built map: their ends, and which of them follow each other."""

    def __init__(self, path, buses=False):
        root = xml.parse(path).getroot()
        squeeze = math.cos(math.radians(ORIGIN[1]))
        places = {
            n.get("id"): ((float(n.get("lon")) - ORIGIN[0]) / DEGREE * squeeze, (float(n.get("lat")) - ORIGIN[1]) / DEGREE)
            for n in root.iter("node")
        }
        ways = {w.get("id"): [nd.get("ref") for nd in w.iter("nd")] for w in root.iter("way")}
        self.lanes = []
        for relation in root.iter("relation"):
            tags = {t.get("k"): t.get("v") for t in relation.iter("tag")}
            kinds = DRIVEN | ({"bus_lane"} if buses else set())
            if tags.get("type") != "lanelet" or tags.get("subtype") not in kinds:
                continue
            bounds = {m.get("role"): ways[m.get("ref")] for m in relation.iter("member") if m.get("type") == "way"}
            left, right = list(bounds["left"]), list(bounds["right"])
            left, right = self.aligned(left, right, places)
            middle = lambda i: tuple((a + b) / 2 for a, b in zip(places[left[i]], places[right[i]]))
            line = [places[n] for n in left]
            length = sum(math.dist(a, b) for a, b in zip(line, line[1:]))
            self.lanes.append({
                "id": relation.get("id"), "tags": tags, "start": (left[0], right[0]), "end": (left[-1], right[-1]),
                "from": middle(0), "to": middle(-1), "length": length, "way": tags.get("road_id", "").split(":")[0],
                "sides": (bounds["left"], bounds["right"]), "line": line,
            })
        starts = collections.defaultdict(list)
        for i, lane in enumerate(self.lanes):
            starts[lane["start"]].append(i)
        self.next = [starts[lane["end"]] for lane in self.lanes]
        sides = collections.defaultdict(list)
        for i, lane in enumerate(self.lanes):
            sides[tuple(sorted(lane["sides"][1]))].append(i)
        # Beside each other in the same direction: the same bound, from either side.
        self.beside = [[] for _ in self.lanes]
        for i, lane in enumerate(self.lanes):
            for j in sides[tuple(sorted(lane["sides"][0]))]:
                if i != j and self.lanes[j]["way"] == lane["way"] and self.along(lane, self.lanes[j]):
                    self.beside[i].append(j)
                    self.beside[j].append(i)

    @staticmethod
    def along(a, b):
        d = [(l["to"][0] - l["from"][0], l["to"][1] - l["from"][1]) for l in (a, b)]
        return d[0][0] * d[1][0] + d[0][1] * d[1][1] > 0

    @staticmethod
    def aligned(left, right, places):
        """Both bounds in the direction of travel: the right one lies to the right of the left one."""
        mean = lambda ids: tuple(sum(places[i][k] for i in ids) / len(ids) for k in (0, 1))
        a, b = places[left[0]], places[left[-1]]
        l, r = mean(left), mean(right)
        if (b[0] - a[0]) * (r[1] - l[1]) - (b[1] - a[1]) * (r[0] - l[0]) > 0:
            left = left[::-1]
        a, b, c, d = places[left[0]], places[left[-1]], places[right[0]], places[right[-1]]
        if math.dist(a, c) + math.dist(b, d) > math.dist(a, d) + math.dist(b, c):
            right = right[::-1]
        return left, right

    def route(self, starts, ends):
        """The ways of the shortest route, or None."""
        heap = [(self.lanes[i]["length"], i, [i]) for i in starts]
        seen = set()
        while heap:
            cost, at, path = heapq.heappop(heap)
            if at in seen:
                continue
            seen.add(at)
            if at in ends:
                ways = [self.lanes[i]["way"] for i in path if self.lanes[i]["way"]]
                return [way for i, way in enumerate(ways) if i == 0 or ways[i - 1] != way]
            for j in self.next[at]:
                heapq.heappush(heap, (cost + self.lanes[j]["length"], j, path + [j]))
            for j in self.beside[at]:
                heapq.heappush(heap, (cost + 1.0, j, path + [j]))
        return None


class Program:
    def __init__(self, path):
        self.path, self.dir = path, tempfile.TemporaryDirectory()

    def build(self, text, side="right", buses=False):
        """The map of an OpenStreetMap file; None if it has no road. Any other failure ends the count."""
        source, out = (os.path.join(self.dir.name, name) for name in ("in.osm", "out"))
        open(source, "w", encoding="utf-8").write(text)
        run = subprocess.run(
            [self.path, "build", source, "-o", out + "/", "--driving-side", side, "--guesses"],
            capture_output=True,
            text=True,
        )
        self.told = run.stdout + run.stderr
        if run.returncode:
            if "no drivable road" in run.stderr:
                return None
            raise SystemExit(f"build failed:\n{run.stderr}\n{text}")
        return Map(os.path.join(out, "lanelet2_map.osm"), buses)

    def lanes(self, text, side):
        """The lanes of the only road, from left to right."""
        source, out = (os.path.join(self.dir.name, name) for name in ("in.osm", "out.geojson"))
        open(source, "w", encoding="utf-8").write(text)
        run = subprocess.run(
            [self.path, "geometry", source, "-o", out, "--driving-side", side], capture_output=True, text=True
        )
        if run.returncode:
            return []
        features = [f["properties"] for f in json.load(open(out))["features"] if f["properties"]["type"] == "lane"]
        road = features[0]["road"] if features else None
        lanes = sorted((f for f in features if f["road"] == road), key=lambda f: f["index"])
        return [(lane.get("kind", "drive"), lane.get("travel")) for lane in lanes]


def directions(program, tags, node_tags=None, buses=False, side="right"):
    """Whether vehicles drive along a way of three nodes, and against it."""
    nodes = {"a": (0, 0, {}), "b": (150, 0, node_tags or {}), "c": (300, 0, {})}
    built = program.build(osm(nodes, [(["a", "b", "c"], tags)], []), side, buses)
    if built is None:
        return False, False
    ends = lambda x, key: {i for i, lane in enumerate(built.lanes) if abs(lane[key][0] - x) < 20}
    return (
        built.route(ends(0, "from"), ends(300, "to")) is not None,
        built.route(ends(300, "from"), ends(0, "to")) is not None,
    )


class Count:
    def __init__(self):
        self.rows = collections.defaultdict(collections.Counter)
        self.reasons, self.listed, self.told = collections.Counter(), [], set()

    def add(self, suite, what, agrees, told, judged=None):
        reason = None if agrees else judged or next((why for words, why in JUDGED if all(w in what for w in words)), None)
        verdict = "agree" if agrees else "judged" if reason else "differ"
        self.rows[suite][verdict] += 1
        if reason:
            self.reasons[(suite, reason)] += 1
        if not agrees:
            self.listed.append(f"{verdict} {suite}: {what}: {told}" + (f" ({reason})" if reason else ""))


class Town:
    """The built map of named nodes, and the routes over its ways."""

    def __init__(self, program, nodes, ways, relations, names, buses=False):
        self.nodes, self.names, self.built = nodes, names, program.build(osm(nodes, ways, relations), buses=buses)

    def near(self, node, key):
        """The lanelets that begin, or end, at a node."""
        # A digit is a place beside a road.
        far = {i: distance(self.nodes[node], lane) for i, lane in enumerate(self.built.lanes) if lane["way"]}
        nearest = min(far.values(), default=0.0)
        passing = {i for i, metres in far.items() if metres < max(40.0, nearest + 10.0)}
        ending = {i for i in passing if math.dist(self.built.lanes[i][key], self.nodes[node][:2]) < 45}
        return ending or passing

    def starts_within(self, node):
        """Whether a route from a node starts on its way along lanes, and not where they begin."""
        return all(math.dist(self.built.lanes[i]["from"], self.nodes[node][:2]) >= 45 for i in self.near(node, "from"))

    def route(self, start, end):
        """The names of the ways of a route, each once in a row; None if there is none."""
        if self.built is None:
            return None
        ways = self.built.route(self.near(start, "from"), self.near(end, "to"))
        return ways and once([self.names[int(way) - 1000] for way in ways])


def once(words):
    """The words without those that repeat the word before."""
    return [w for i, w in enumerate(words) if i == 0 or words[i - 1] != w]


def distance(place, lane):
    """Metres from a place to the left bound of a lane."""
    return min(to_segment(place, a, b) for a, b in zip(lane["line"], lane["line"][1:]))


def to_segment(place, start, end):
    (ax, ay), (bx, by), (px, py) = start, end, place[:2]
    length = (bx - ax) ** 2 + (by - ay) ** 2
    t = max(0.0, min(1.0, ((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / length)) if length else 0.0
    return math.hypot(ax + t * (bx - ax) - px, ay + t * (by - ay) - py)


def is_within(ours, told):
    rest = iter(told)
    return all(way in rest for way in ours)
