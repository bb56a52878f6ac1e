"""Builds the cases of other engines' public test suites and counts on how many rows the maps agree with them.

usage: suites.py LANEWRIGHT [--osrm DIR] [--graphhopper DIR] [--osm2lanes DIR] [--list]

Each DIR is a copy of the suite's repository, with or without a work tree: Project-OSRM/osrm-backend (features/car),
graphhopper/graphhopper (access of cars and buses), a-b-street/osm2lanes (data/tests.yml). A row is a way with tags: may cars drive
along it, and against it? Of OSRM's turn restrictions a row is a route that is to exist or not; of osm2lanes the lanes from left to
right. Where we differ on purpose, JUDGED says why: such a row counts as judged, any other as differing.
Exit code 1 if fewer than 98 % of the rows agree or are judged.
"""

import argparse
import collections
import math
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

LEAST = 0.98
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
                "sides": (bounds["left"], bounds["right"]),
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
        import heapq

        heap = [(0.0, i, [i]) for i in starts]
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
                heapq.heappush(heap, (cost + self.lanes[at]["length"], j, path + [j]))
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
        import json

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
        self.reasons, self.listed = collections.Counter(), []

    def add(self, suite, what, agrees, told, judged=None):
        reason = None if agrees else judged or next((why for words, why in JUDGED if all(w in what for w in words)), None)
        verdict = "agree" if agrees else "judged" if reason else "differ"
        self.rows[suite][verdict] += 1
        if reason:
            self.reasons[(suite, reason)] += 1
        if not agrees:
            self.listed.append(f"{verdict} {suite}: {what}: {told}" + (f" ({reason})" if reason else ""))


def table(lines):
    """The rows of a table of Gherkin as dictionaries, with its lines."""
    rows = []
    for line in lines:
        line = line.strip()
        if not line.startswith("|"):
            break
        rows.append([c.strip().replace("\0", "|") for c in line.replace("\\|", "\0").strip("|").split("|")])
    return [dict(zip(rows[0], row)) for row in rows[1:]] if rows else []


def scenarios(text):
    for part in re.split(r"\n\s*Scenario(?: Outline)?:", text)[1:]:
        yield [line for line in part.split("\n") if not line.strip().startswith("#")]


def osrm(program, repo, count):
    ignored = {"#", "forw", "backw", "bothw", "forw_rate", "backw_rate", "time", "rate"}
    for name in ["access", "oneway", "barrier", "hov", "service", "advisory", "maxspeed", "surface", "way", "physical_limitation"]:
        for lines in scenarios(text_of(repo, f"features/car/{name}.feature")):
            if any("given the profile" in line.lower() and "car" not in line for line in lines):
                continue
            for at, line in enumerate(lines):
                if "routability should be" not in line:
                    continue
                for row in table(lines[at + 1:]):
                    tags = {k: v for k, v in row.items() if v and k not in ignored and not k.startswith("node/")}
                    node = {k[5:]: v for k, v in row.items() if v and k.startswith("node/")}
                    tags.setdefault("highway", "primary")
                    is_open = lambda column: bool(row.get(column, row.get("bothw", "")))
                    if not {"forw", "backw", "bothw"} & set(row):
                        continue
                    told, ours = (is_open("forw"), is_open("backw")), directions(program, tags, node)
                    asked = [i for i, c in enumerate(("forw", "backw")) if c in row or "bothw" in row]
                    words = [f"{k}={v}" for k, v in tags.items()] + [f"node/{k}={v}" for k, v in node.items()]
                    agrees = all(told[i] == ours[i] for i in asked)
                    count.add("OSRM " + name, " ".join(words), agrees, f"they {told}, we {ours}")


def osrm_routes(program, repo, count):
    for name in ["restrictions", "oneway", "via", "multi_via_restrictions", "access"]:
        for lines in scenarios(text_of(repo, f"features/car/{name}.feature")):
            route_scenario(program, name, lines, count)


def route_scenario(program, name, lines, count):
    title = lines[0].strip()
    if any("conditional" in line for line in lines[:8]) or "onditional" in title:
        return
    if not any('"""' in line for line in lines):
        return
    quotes = [i for i, line in enumerate(lines) if '"""' in line]
    drawn = [line for line in lines[quotes[0] + 1:quotes[1]] if line.strip()]
    grid = 60.0
    nodes = {}
    for y, line in enumerate(lines[quotes[0] + 1:quotes[1]]):
        for x, c in enumerate(line):
            if c.isalnum():
                nodes[c] = (x * grid, -y * grid, {})
    ways, relations, names = [], [], []
    at_of = {}
    for at, line in enumerate(lines):
        word = line.strip()
        if word.endswith("the ways"):
            for row in table(lines[at + 1:]):
                tags = {k: v for k, v in row.items() if v and k not in ("nodes", "#")}
                tags.setdefault("highway", "primary")
                at_of[row["nodes"]] = len(ways)
                ways.append((list(row["nodes"]), tags))
                names.append(tags.get("name", row["nodes"]))
        if word.endswith("the nodes"):
            for row in table(lines[at + 1:]):
                tags = {k: v for k, v in row.items() if v and k not in ("node", "#")}
                nodes[row["node"]] = nodes[row["node"]][:2] + (tags,)
        if word.endswith("the relations"):
            for row in table(lines[at + 1:]):
                members, tags = [], {}
                for key, value in row.items():
                    kind, _, role = key.partition(":")
                    if kind in ("way", "node") and role and value:
                        for ref in value.split(","):
                            ref = ref.strip()
                            if kind == "way":
                                ref = at_of.get(ref, at_of.get(ref[::-1]))
                            if ref is not None:
                                members.append((kind, ref, role))
                    elif value and not role.startswith("from"):
                        tags[key] = value
                relations.append((members, tags))
    if not ways or any(n not in nodes for w, _ in ways for n in w):
        return
    built = program.build(osm(nodes, ways, relations))
    for at, line in enumerate(lines):
        if "I route I should get" not in line:
            continue
        for row in table(lines[at + 1:]):
            if "from" not in row or "route" not in row or row["from"] not in nodes or row["to"] not in nodes:
                continue
            told = [w for w in row["route"].split(",") if w]
            # The last name is that of the arrival.
            twice = len(told[:-1]) != len(set(told[:-1]))
            told = [w for i, w in enumerate(told) if i == 0 or told[i - 1] != w]
            def near(node, key):
                # A digit is a place beside a road.
                far = {i: distance(nodes[node], lane) for i, lane in enumerate(built.lanes) if lane["way"]}
                nearest = min(far.values(), default=0.0)
                passing = {i for i, metres in far.items() if metres < max(40.0, nearest + 10.0)}
                ending = {i for i in passing if math.dist(built.lanes[i][key], nodes[node][:2]) < 45}
                return ending or passing

            ours = built.route(near(row["from"], "from"), near(row["to"], "to")) if built else None
            ours = ours and [names[int(way) - 1000] for way in ours]
            ours = ours and [w for i, w in enumerate(ours) if i == 0 or ours[i - 1] != w]
            # Roads that lie inside an intersection have no lanes of their own.
            agrees = (ours is None) == (not told) and (ours is None or is_within(ours, told))
            judged = None
            if told and ours is None and twice:
                judged = "the route turns back where a street has no room for it"
            if not told and ours and "cannot be built" in program.told:
                judged = "others make the same turns and may: lanelets cannot forbid it to some; a note says so"
            if "Invalid " in title and told and ours is None:
                judged = "a restriction with more members than its kind may have binds them all, the safe reading; OSRM drops it"
            if "Handle any" in title:
                judged = "a restriction with an unknown value is a note, and no ban"
            count.add("OSRM " + name + " (routes)", f"{title}: {row['from']} to {row['to']}", agrees, f"they {told}, we {ours}", judged)


def distance(place, lane):
    (ax, ay), (bx, by), (px, py) = lane["from"], lane["to"], place[:2]
    length = (bx - ax) ** 2 + (by - ay) ** 2
    t = max(0.0, min(1.0, ((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / length)) if length else 0.0
    return math.hypot(ax + t * (bx - ax) - px, ay + t * (by - ay) - py)


def is_within(ours, told):
    rest = iter(told)
    return all(way in rest for way in ours)


def graphhopper(program, repo, count):
    base = "core/src/test/java/com/graphhopper/routing/util/parsers/"
    for name, buses in [("CarTagParserTest", False), ("CarModeAccessParserTest", False), ("BusModeAccessParserTest", True)]:
        tags, node, states = {}, {}, None
        for line in text_of(repo, base + name + ".java").split("\n"):
            line = line.strip()
            if line.startswith("//"):
                continue
            if "new ReaderWay" in line or "way.clearTags()" in line or "@Test" in line:
                tags, node = {}, {}
            if "@Test" in line or "@Parameterized" in line:
                states = line
            if states and "Parameterized" in states:
                continue
            if "new ReaderNode" in line:
                node = {}
            if match := re.match(r'way\.setTag\("([^"]+)", "([^"]+)"\);', line):
                tags[match[1]] = match[2]
            if match := re.match(r'node\.setTag\("([^"]+)", "([^"]+)"\);', line):
                node[match[1]] = match[2]
            if match := re.match(r'way\.setTag\("node_tags", (.*)\);', line):
                inner = re.search(r"Map\.of\(([^)]*)\)", match[1])
                words = re.findall(r'"([^"]*)"', inner[1]) if inner else []
                node = dict(zip(words[::2], words[1::2]))
            told = None
            if match := re.search(r"assert(True|False)\((\w+)\.isBarrier\(node\)\)", line):
                told, want = (match[1] == "False",) * 2, (0, 1)
                row = {"highway": "secondary"}
            elif match := re.search(r"assert(True|False)\(parser\.getAccess\(way\)\.(canSkip|isWay|isFerry)\(\)\)", line):
                is_open = (match[1] == "True") == (match[2] != "canSkip")
                told, want, row = (is_open,) * 2, "any", tags
            elif match := re.search(r"assert(True|False)\((?:accessEnc|carAccessEnc|busAccessEnc)\.getBool\((true|false),", line):
                told, want, row = (match[1] == "True",) * 2, (int(match[2] == "true"),), tags
            if told is None or not row:
                continue
            kept = {k: v for k, v in row.items() if not k.startswith(("gh:", "node_tags", "way_dist", "duration"))}
            ours = directions(program, kept, node, buses)
            agrees = any(ours) == told[0] if want == "any" else all(ours[i] == told[i] for i in want)
            words = [f"{k}={v}" for k, v in kept.items()] + [f"node/{k}={v}" for k, v in node.items()]
            count.add("GraphHopper " + name, " ".join(words), agrees, f"they {told[0]} of {want}, we {ours}")


def osm2lanes(program, repo, count):
    import yaml

    kinds = {"motor_vehicle": "drive", "bus": "bus", "bicycle": "bicycle"}
    for case in yaml.safe_load(text_of(repo, "data/tests.yml")):
        tags = {str(k): str(v) for k, v in case["tags"].items()}
        told = []
        for lane in case["road"]["lanes"]:
            if lane["type"] == "travel" and lane.get("designated") in kinds:
                told.append((kinds[lane["designated"]], lane.get("direction")))
        nodes = {"a": (0, 0, {}), "b": (300, 0, {})}
        lanes = program.lanes(osm(nodes, [(["a", "b"], tags)], []), case["driving_side"])
        ours = [lane for lane in lanes if lane[0] in kinds.values()]
        what = " ".join(f"{k}={v}" for k, v in tags.items())
        same = lambda a, b: a[0] == b[0] and (b[1] is None or a[1] == b[1])
        agrees = len(ours) == len(told) and all(map(same, ours, told))
        count.add("osm2lanes", what, agrees, f"they {told}, we {ours}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("lanewright")
    for suite in ("osrm", "graphhopper", "osm2lanes"):
        parser.add_argument("--" + suite)
    parser.add_argument("--list", action="store_true", help="name every row that differs or is judged")
    said = parser.parse_args()
    program, count = Program(said.lanewright), Count()
    if said.osrm:
        osrm(program, said.osrm, count)
        osrm_routes(program, said.osrm, count)
    if said.graphhopper:
        graphhopper(program, said.graphhopper, count)
    if said.osm2lanes:
        osm2lanes(program, said.osm2lanes, count)
    total = collections.Counter()
    print("| suite | rows | agree | judged | differ |\n|---|---|---|---|---|")
    for suite, found in sorted(count.rows.items()):
        total += found
        print(f"| {suite} | {sum(found.values())} | {found['agree']} | {found['judged']} | {found['differ']} |")
    rows = sum(total.values())
    print(f"| all | {rows} | {total['agree']} | {total['judged']} | {total['differ']} |\n")
    print("| suite | judged | why |\n|---|---|---|")
    for (suite, reason), n in sorted(count.reasons.items()):
        print(f"| {suite} | {n} | {reason} |")
    if said.list:
        print("\n" + "\n".join(count.listed))
    return 0 if rows and (total["agree"] + total["judged"]) / rows >= LEAST else 1


if __name__ == "__main__":
    sys.exit(main())
