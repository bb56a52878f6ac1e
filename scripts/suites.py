"""Builds the cases of other engines' public test suites and counts on how many rows the maps agree with them.

usage: suites.py LANEWRIGHT [--osrm DIR] [--graphhopper DIR] [--osm2lanes DIR] [--valhalla DIR] [--netconvert EXTRACT ...] [--list]

Each DIR is a copy of the suite's repository, with or without a work tree: Project-OSRM/osrm-backend (features/car),
graphhopper/graphhopper (access of cars and buses), a-b-street/osm2lanes (data/tests.yml), valhalla/valhalla (lua/graph.lua, which the
package lupa runs, on tags of our own, and the routes of test/gurka). EXTRACTs are files of OpenStreetMap whose ways are also read by
netconvert (package eclipse-sumo, or the program on PATH). A row is a way with tags: may cars drive
along it, and against it? Of OSRM's turn restrictions a row is a route that is to exist or not; of osm2lanes the lanes from left to
right. Where we differ on purpose, JUDGED says why: such a row counts as judged, any other as differing.
Exit code 1 if fewer than 98 % of the rows agree or are judged.
"""

import argparse
import collections
import importlib.util
import os
import re
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import suite_netconvert
import suite_valhalla
from suite_maps import Count, Program, Town, directions, is_within, once, osm, text_of

LEAST = 0.98

# Why a route of OSRM is not in our map: the reason, words of the scenario's title, starts and ends.
JUDGED_ROUTES = {
    "an only_ restriction over ways holds from its first node on, as in GraphHopper": [
        ("Overlapping multiple via", {("c", "f"), ("c", "g")}),
        ("overlapping single via", {("a", "f")}),
    ],
    "who starts inside a chain is bound as all who drive there, who come over its first way": [
        ("Overlapping multiple via", {("i", "j"), ("i", "l")}),
    ],
    "no car turns as sharply as these ways meet, and its lane leads on elsewhere": [
        ("Many overlapping multiple via", {("4", "7")}),
    ],
    "a via way that goes on beyond its chain is followed as far as the chain goes; OSRM drops the restriction": [
        ("Ambiguous via ways", {("a", "f"), ("f", "a")}),
    ],
    "of a way that passes through the via the part counts to which the turn is as named; OSRM drops the restriction": [
        ("Ambiguous ways", {("d", "x")}),
        ("Ambiguous from/to ways", {("f", "a"), ("c", "f")}),
    ],
}


def reason_for_route(title, start, end):
    """Why a route of OSRM is not in our map; None if nobody has judged it."""
    rows = ((why, words, ends) for why, places in JUDGED_ROUTES.items() for words, ends in places)
    return next((why for why, words, ends in rows if words in title and (start, end) in ends), None)


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
    town = Town(program, nodes, ways, relations, names)
    for at, line in enumerate(lines):
        if "I route I should get" not in line:
            continue
        for row in table(lines[at + 1:]):
            if "from" not in row or "route" not in row or row["from"] not in nodes or row["to"] not in nodes:
                continue
            told = [w for w in row["route"].split(",") if w]
            # The last name is that of the arrival.
            twice = len(told[:-1]) != len(set(told[:-1]))
            told, ours = once(told), town.route(row["from"], row["to"])
            # Roads that lie inside an intersection have no lanes of their own.
            agrees = (ours is None) == (not told) and (ours is None or is_within(ours, told))
            if not agrees and told and ours:
                # A lane is named by the first way of its road, which a route that starts within the road does not drive; the ways of a
                # loop may be driven in either order.
                agrees = is_within(ours[1:], told) and town.starts_within(row["from"]) or sorted(ours) == sorted(told)
            is_unbuilt = "cannot be built" in program.told
            judged = reason_for_route(title, row["from"], row["to"])
            if told and ours is None and twice:
                judged = judged or "the route turns back where a street has no room for it"
            if not told and ours and is_unbuilt:
                judged = "others make the same turns and may: lanelets cannot forbid it to some; a note says so"
            if told and ours and is_unbuilt:
                judged = "a way that OSRM forbids to some, and lanelets cannot, is shorter; a note says so"
            if "Invalid " in title and told and ours is None:
                judged = "a restriction with more members than its kind may have binds them all, the safe reading; OSRM drops it"
            if "Handle any" in title:
                judged = "a restriction with an unknown value is a note, and no ban"
            count.add("OSRM " + name + " (routes)", f"{title}: {row['from']} to {row['to']}", agrees, f"they {told}, we {ours}", judged)


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
    for suite in ("osrm", "graphhopper", "osm2lanes", "valhalla"):
        parser.add_argument("--" + suite)
    parser.add_argument("--netconvert", nargs="+", default=[], metavar="EXTRACT")
    parser.add_argument("--list", action="store_true", help="name every row that differs or is judged")
    said = parser.parse_args()
    for suite, module, package in [(said.osm2lanes, "yaml", "pyyaml"), (said.valhalla, "lupa", "lupa")]:
        if suite and importlib.util.find_spec(module) is None:
            parser.error(f"to read {suite} the Python package {package} is needed: pip install {package}")
    program, count = Program(said.lanewright), Count()
    if said.osrm:
        osrm(program, said.osrm, count)
        osrm_routes(program, said.osrm, count)
    if said.graphhopper:
        graphhopper(program, said.graphhopper, count)
    if said.osm2lanes:
        osm2lanes(program, said.osm2lanes, count)
    if said.valhalla:
        suite_valhalla.access(program, said.valhalla, count)
        suite_valhalla.routes(program, said.valhalla, count)
    for extract in said.netconvert:
        suite_netconvert.lanes(program, extract, count)
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
