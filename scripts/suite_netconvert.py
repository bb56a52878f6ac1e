"""The lanes that netconvert of SUMO (package eclipse-sumo) reads from the tags of an extract's ways."""

import collections
import importlib.util
import json
import os
import shutil
import subprocess
import tempfile
import xml.etree.ElementTree as xml

# A row is a set of such tags; ways that differ only in others are one row.
TELLING = ("lanes", "oneway", "access", "vehicle", "motor_vehicle", "motorcar", "bus", "psv", "busway", "junction", "highway", "service")
IMPLIED = {"motorway", "trunk"}


def command():
    """The program, and the environment in which it finds its tables."""
    package = importlib.util.find_spec("sumo")
    if package is None:
        return [shutil.which("netconvert") or "netconvert"], None
    home = os.path.dirname(package.origin)
    return [os.path.join(home, "bin", "netconvert")], {**os.environ, "SUMO_HOME": home}


def theirs(extract, folder):
    """By way the numbers of lanes for cars along it and against it, and those for buses but not for cars."""
    run, environment = command()
    out = os.path.join(folder, "net.xml")
    options = ["--no-internal-links", "--no-turnarounds", "--osm.lane-access", "--no-warnings"]
    subprocess.run([*run, "--osm-files", extract, "-o", out, *options], check=True, capture_output=True, env=environment)
    ways = collections.defaultdict(dict)
    for edge in xml.parse(out).getroot().iter("edge"):
        against, way = edge.get("id").startswith("-"), edge.get("id").lstrip("-").split("#")[0]
        cars, buses = 0, 0
        for lane in edge.iter("lane"):
            allow, disallow = (lane.get(k) for k in ("allow", "disallow"))
            may = lambda who: who in allow.split() if allow is not None else who not in (disallow or "").split()
            cars, buses = cars + may("passenger"), buses + (may("bus") and not may("passenger"))
        # Where a way is divided, at a junction with lanes for turns for example, its pieces differ.
        ways[way].setdefault(against, set()).add((cars, buses))
    return {way: tuple(only(sides.get(side, {(0, 0)})) for side in (False, True)) for way, sides in ways.items()}


def only(found):
    return next(iter(found)) if len(found) == 1 else None


def ours(program, extract, folder):
    out = os.path.join(folder, "out.geojson")
    subprocess.run([program.path, "geometry", extract, "-o", out], check=True, capture_output=True)
    features = [f["properties"] for f in json.load(open(out))["features"]]
    one_way = {f["id"]: f["osm_ids"] for f in features if f["type"] == "road"}
    ways = collections.defaultdict(lambda: collections.defaultdict(lambda: [[0, 0], [0, 0]]))
    for lane in features:
        # Of a road over several ways the first gives its name, and it may lead against the others.
        if lane["type"] != "lane" or len(one_way.get(lane["road"], [0, 0])) != 1:
            continue
        sides = ways[lane["road"].split(":")[0]][lane["road"]]
        kind = {"drive": 0, "bus": 1}.get(lane.get("kind", "drive"))
        for side in {"forward": [0], "backward": [1]}.get(lane.get("travel"), [0, 1]) if kind is not None else []:
            sides[side][kind] += 1
    found = {way: {tuple(map(tuple, sides)) for sides in roads.values()} for way, roads in ways.items()}
    return {way: only(roads) for way, roads in found.items()}


def judged(tags, they):
    """Why the lanes of a row are right though netconvert has others; None if no reason is known."""
    has = lambda *words: any(word in key for key in tags for word in words)
    if tags["highway"] == "service" and not any(side[0] for side in they):
        return "netconvert keeps service roads for deliveries and buses"
    if "lanes:both_ways" in tags:
        return "a lane for both directions lies in the middle; netconvert gives it to one"
    if has("lanes:bus", "lanes:psv", "psv:", "bus:"):
        return "the tags name lanes of buses, which netconvert does not read"
    if has(":lanes") and not any(key.startswith("lanes") for key in tags):
        return "a list tells how many lanes there are; netconvert takes the number of its type of road"
    return None


def lanes(program, extract, count):
    """A row for each set of tags about lanes and access that a way of the extract has."""
    with tempfile.TemporaryDirectory() as folder:
        they, we = theirs(extract, folder), ours(program, extract, folder)
    for way in xml.parse(extract).getroot().iter("way"):
        a, b = they.get(way.get("id")), we.get(way.get("id"))
        if a is None or b is None or None in a:
            continue
        tags = {t.get("k"): t.get("v") for t in way.iter("tag")}
        told = {k: v for k, v in sorted(tags.items()) if k.split(":")[0] in TELLING or ":lanes" in k}
        counted = any("lanes" in key for key in told)
        # Without lanes in its tags a way has those that either assumes.
        first = lambda sides: tuple((min(side[0], 1), min(side[1], 1)) for side in sides)
        a, b = (a, b) if counted else (first(a), first(b))
        words = " ".join(f"{k}={v}" for k, v in told.items())
        if words not in count.told:
            count.told.add(words)
            count.add("netconvert", f"{words} (way {way.get('id')})", a == b, f"they {a}, we {b}", judged(told, a))
