"""Valhalla's reading of tags: its own lua/graph.lua run on tags of ways and nodes, and the routes of its tests under test/gurka."""

import itertools
import re

from suite_maps import Town, directions, is_within, once, text_of

CARS, BUSES = 1, 64  # bits of a node's access mask
# Why a row is right though Valhalla has another; all words of a reason's list have to be there.
JUDGED = [
    (["NoInfoBarrierAccess"], "a gate without access tags is open; Valhalla passes it where nothing else leads there"),
    (["highway=path"], "a way for people is built where a setting asks; a note says so"),
    (["service=emergency_access"], "closed to cars, as OSRM has it"),
    (["disused=yes"], "what is out of use is closed, with a note; other engines read no such key"),
    (["psv=no"], "a map has lanes for buses, and none that bars buses alone"),
    *(([f"={who}"], "the value names others than cars; Valhalla passes over it") for who in ("military", "use_sidepath", "emergency", "psv", "bus")),
    *(([f"{key}:{way}="], "the direction is closed or open as said; Valhalla reads no direction of this key, OSRM and GraphHopper do")
      for key in ("motorcar", "access") for way in ("forward", "backward")),
    (["oneway=reverse"], "an old value for -1"),
    (["oneway:motor_vehicle=no"], "the key of motor vehicles is more specific than oneway, as OSRM has it"),
    (["oneway=yes", "motor_vehicle:backward=yes"], "access opens no one-way road against its direction, as OSRM has it"),
    *((["oneway=-1", word], "forward and backward are those of the way; Valhalla reads this key for oneway=yes alone")
      for word in ("oneway:psv", "oneway:bus", "bus:backward", "lanes:psv:backward", "vehicle:backward")),
    *(([f"barrier={kind}", f"access={value}"], "access tags of a barrier come before its kind")
      for kind in ("jersey_barrier", "sump_buster", "fence") for value in ("yes", "permissive", "no")),
    *(([f"barrier={kind}"], "no car passes it, as OSRM has it") for kind in ("planter", "log", "stile", "turnstile", "bus_trap")),
]
VALUES = (
    "yes no private destination permissive designated delivery customers agricultural forestry emergency official permit "
    "residents psv bus military use_sidepath"
).split()
DIRECTED = "yes no destination private designated agricultural".split()
AGAINST = (
    "oneway:bus=no oneway:psv=no bus:backward=yes busway=opposite_lane busway:left=opposite_lane busway:right=opposite_lane "
    "lanes:psv:backward=1 oneway:motor_vehicle=no motor_vehicle:backward=yes vehicle:backward=no"
).split()
BARRIERS = (
    "bollard gate lift_gate swing_gate block cycle_barrier jersey_barrier kerb toll_booth cattle_grid bus_trap sump_buster chain "
    "planter log fence entrance border_control height_restrictor stile turnstile"
).split()
TESTS = (
    "access simple_restrictions only_restrictions sump_buster barrier_uturns construction node_type restricted_area loops"
).split()


def rows():
    """Tags of a way and of its node in the middle, as the words of both."""
    for highway in "motorway trunk primary tertiary unclassified residential living_street service track road busway".split():
        yield [f"highway={highway}"], []
    for highway in "pedestrian cycleway path footway".split():
        for key, value in itertools.product(["motor_vehicle", "vehicle"], ["yes", "designated", "no"]):
            yield [f"highway={highway}", f"{key}={value}"], []
    for key, value in itertools.product("access vehicle motor_vehicle motorcar bus psv".split(), VALUES):
        yield ["highway=residential", f"{key}={value}"], []
    for key, value in itertools.product("vehicle motor_vehicle motorcar bus psv".split(), ["yes", "designated", "no", "destination"]):
        yield ["highway=residential", "access=no", f"{key}={value}"], []
        yield ["highway=residential", "motor_vehicle=no", f"{key}={value}"], []
    for key, way, value in itertools.product("vehicle motor_vehicle motorcar access".split(), ["forward", "backward"], DIRECTED):
        yield ["highway=tertiary", f"{key}:{way}={value}"], []
        yield ["highway=tertiary", f"{key}=no", f"{key}:{way}={value}"], []
    for value in "yes no -1 true false 1 0 reverse alternating reversible".split():
        yield ["highway=secondary", f"oneway={value}"], []
    for value, against in itertools.product(["yes", "-1"], AGAINST):
        yield ["highway=secondary", "lanes=2", f"oneway={value}", against], []
    for word in "impassable=yes smoothness=impassable service=emergency_access service=driveway junction=roundabout disused=yes".split():
        yield ["highway=service", word], []
    for barrier in BARRIERS:
        yield ["highway=tertiary"], [f"barrier={barrier}"]
        for key, value in itertools.product("access motor_vehicle bus".split(), "yes no private permissive destination".split()):
            yield ["highway=tertiary"], [f"barrier={barrier}", f"{key}={value}"]
    for key, value in itertools.product("access vehicle motor_vehicle motorcar".split(), "yes no private destination".split()):
        yield ["highway=tertiary"], [f"{key}={value}"]
    yield ["highway=tertiary"], ["barrier=bollard", "bollard=rising"]
    yield ["highway=tertiary"], ["barrier=bollard", "bollard=removable"]


def access(program, repo, count):
    """Whether cars, and buses where the tags name them, drive a way in either direction."""
    from lupa.luajit21 import LuaRuntime

    lua = LuaRuntime(unpack_returned_tuples=True)
    lua.execute(text_of(repo, "lua/graph.lua"))

    def told(way, node, who, bit):
        read = lua.globals().ways_proc(lua.table_from(way), len(way))
        if read[0] != 0:
            return False, False
        passes = not node or lua.globals().nodes_proc(lua.table_from(node), len(node))[1]["access_mask"] & bit
        return tuple(bool(passes) and read[1][f"{who}_{toward}"] == "true" for toward in ("forward", "backward"))

    for way_words, node_words in rows():
        way, node = (dict(word.split("=", 1) for word in words) for words in (way_words, node_words))
        words = " ".join(way_words + ["node/" + word for word in node_words])
        kinds = [("auto", CARS, False)]
        if "bus" in words or "psv" in words:
            kinds.append(("bus", BUSES, True))
        for who, bit, buses in kinds:
            theirs, ours = told(way, node, who, bit), directions(program, way, node, buses)
            suite = "Valhalla graph.lua" + (", buses" if buses else "")
            count.add(suite, words, theirs == ours, f"they {theirs}, we {ours}", judged(words))


def judged(words):
    return next((why for needed, why in JUDGED if all(word in words for word in needed)), None)


def routes(program, repo, count):
    """The routes of cars and buses over the small maps of the tests of routes."""
    for test in TESTS:
        town = {}
        text, name = text_of(repo, f"test/gurka/test_{test}.cc").replace("= {};", ";"), ""
        heads = r'R"\(|\b(?:ways|nodes|relations) = \{|TEST(?:_F)?\(\w+, (\w+)\)|gurka::do_action\(|check_auto_path\(map, '
        for head in re.finditer(heads, text):
            rest = text[head.end():]
            if head[0].startswith('R"'):
                town = {"drawn": rest[:rest.index(')"')], "ways": [], "nodes": {}, "relations": []}
            elif head[0].startswith("TEST"):
                name = head[1]
            elif head[0].startswith("ways"):
                town["ways"] = [(m[1], tags(m[2])) for m in re.finditer(r'\{"(\w+)",\s*\{(.*?\})\s*\}\s*\}', block(rest), re.S)]
            elif head[0].startswith("nodes"):
                town["nodes"] = {m[1]: tags(m[2]) for m in re.finditer(r'\{"(\w)",\s*\{(.*?\})\s*\}', block(rest), re.S)}
            elif head[0].startswith("relations"):
                parts = re.split(r"\}\}\s*,\s*\{\{", block(rest))
                town["relations"] = [restriction(part) for part in parts if "_member" in part]
            elif query := asked(head[0], rest):
                walk(program, test, name, town, query, count)


def block(text):
    """The text up to the brace that closes the one before it."""
    depth = 1
    for i, c in enumerate(text):
        depth += {"{": 1, "}": -1}.get(c, 0)
        if depth == 0:
            return text[:i]
    return text


def tags(text):
    return dict(re.findall(r'\{"([^"]+)",\s*"([^"]*)"\}', text))


def restriction(text):
    return re.findall(r'gurka::(\w+)_member,\s*"(\w+)",\s*"(\w+)"', text), tags(text)


def asked(head, rest):
    """From, to, who drives, and the names of the ways: None for no route; or nothing if this test asks something else."""
    listed = lambda m: re.findall(r'"(\w+)"', m[1])
    if head.startswith("check"):
        expected = re.match(r"\{([^}]*)\}\)", rest)
        return expected and ("A", "B", "auto", listed(expected) or None)
    question = re.match(r'\s*(?:valhalla::)?Options::route,\s*map,\s*\{"(\w)",\s*"(\w)"\},\s*"(auto|bus)"\s*\)', rest)
    if not question:
        return None
    rest = rest.split("do_action")[0].split("\n}")[0]
    expected = re.search(r"raw::expect_path\(result,\s*\{([^}]*)\}", rest)
    if expected is None and "runtime_error" not in rest:
        return None
    return (*question.groups(), listed(expected) or None if expected else None)


def walk(program, test, name, town, query, count):
    start, end, who, theirs = query
    grid = 60.0
    lines = [line for line in town["drawn"].split("\n") if line.strip()]
    drawn = [(x * grid, -y * grid, c) for y, line in enumerate(lines) for x, c in enumerate(line) if c.isalnum()]
    nodes = {c: (x, y, town["nodes"].get(c, {})) for x, y, c in drawn}
    # A digit beside a road is a place to start from.
    if any(c not in nodes for way, _ in town["ways"] for c in way) or start not in nodes or end not in nodes:
        return
    at = {way: i for i, (way, _) in enumerate(town["ways"])}
    relations = []
    for members, kept in town["relations"]:
        known = [(kind, at.get(ref) if kind == "way" else ref, role) for kind, ref, role in members]
        relations.append(([member for member in known if member[1] is not None], kept))
    ways = [(list(way), {k: v for k, v in kept.items() if k != "osm_id"}) for way, kept in town["ways"]]
    words = [f"node/{k}={v}" for kept in town["nodes"].values() for k, v in kept.items()]
    words += [f"{k}={v}" for _, kept in ways for k, v in kept.items()]
    names = [way for way, _ in town["ways"]]
    for c in (start, end):
        # Where a street only bends, another one begins, so that routes have an end there.
        x, y, _ = nodes[c]
        if sum(c in (way[0], way[-1]) for way, _ in ways) == 2 and all(abs(a - x) > 1 or b >= y for a, b, _ in drawn):
            nodes[c + "'"] = (x, y - 90.0, {})
            ways.append(([c, c + "'"], {"highway": "residential"}))
            names.append("")
    built = Town(program, nodes, ways, relations, names, who == "bus")
    ours, theirs = built.route(start, end), theirs and once(theirs)
    ours = ours and [way for way in ours if way]
    agrees = (ours is None) == (theirs is None) and (ours is None or is_within(ours, theirs))
    what = f"{test} {name}: {start} to {end} by {who}, {' '.join(dict.fromkeys(words))}"
    count.add("Valhalla gurka (routes)", what, agrees, f"they {theirs}, we {ours}", judged(what))
