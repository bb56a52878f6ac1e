"""Reads a map with GDAL, osmium and simple-lanelet2, and holds what they find against what the file says."""

import json
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from collections import Counter
from pathlib import Path

# Importing the elements registers them: without, crosswalks and road markings do not load.
import autoware_lanelet2_extension_python.regulatory_elements  # noqa: F401
import lanelet2
from autoware_lanelet2_extension_python.projection import MGRSProjector

# What simple-lanelet2 makes of each subtype; others are plain elements to it.
CLASSES = {
    "right_of_way": "RightOfWay",
    "traffic_light": "AutowareTrafficLight",
    "crosswalk": "Crosswalk",
    "road_marking": "RoadMarking",
    "speed_limit": "SpeedLimit",
    "speed_bump": "SpeedBump",
    "detection_area": "DetectionArea",
    "no_parking_area": "NoParkingArea",
    "no_stopping_area": "NoStoppingArea",
    "bus_stop_area": "BusStopArea",
    "traffic_sign": "TrafficSign",
}


def run(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)}: {done.stdout}{done.stderr}")
    return done.stdout


def same(what: str, found: object, expected: object) -> None:
    if found != expected:
        raise SystemExit(f"{what}: {found}, and the file has {expected}")


def gdal(path: str, root: ET.Element) -> None:
    """Every way is a line or a surface with the places of its nodes: a reader that cannot take the ids opens the map empty, exit 0."""
    nodes = {node.get("id"): (float(node.get("lon")), float(node.get("lat"))) for node in root.iter("node")}
    ways = {way.get("id"): [nodes[nd.get("ref")] for nd in way.iter("nd")] for way in root.iter("way")}
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for layer, key in [("lines", "osm_id"), ("multipolygons", "osm_way_id")]:
            out = Path(folder) / f"{layer}.json"
            # With fewer decimals GDAL's writer takes digits behind several zeros for noise: 139.7000002 becomes 139.7.
            run("ogr2ogr", "-f", "GeoJSONSeq", "-lco", "COORDINATE_PRECISION=9", str(out), path, layer)
            for line in out.read_text().splitlines():
                feature = json.loads(line)
                found[feature["properties"][key]] = feature["geometry"]
    same("ways that ogr2ogr reads", sorted(found), sorted(ways))
    for way, geometry in found.items():
        if geometry["type"] == "LineString":
            apart = max(max(abs(a - b) for a, b in zip(p, q)) for p, q in zip(geometry["coordinates"], ways[way]))
            if len(geometry["coordinates"]) < 2 or apart > 1e-7:
                raise SystemExit(f"way {way} of ogr2ogr is {apart} degrees from where it lies")


def osmium(path: str, root: ET.Element) -> None:
    info = json.loads(run("osmium", "fileinfo", "-e", "-j", path))
    counts = {f"{kind}s": len(list(root.iter(kind))) for kind in ("node", "way", "relation")}
    same("elements that osmium reads", {kind: info["data"]["count"][kind] for kind in counts}, counts)
    # Fails on a node that is not there. `osmium check-refs` would tell of members of relations, too, but takes 4 MB of memory for
    # nearly every id of ours, which are spread over the whole range.
    with tempfile.TemporaryDirectory() as folder:
        run("osmium", "add-locations-to-ways", path, "-o", str(Path(folder) / "placed.osm.pbf"))


def simple_lanelet2(path: str, root: ET.Element) -> None:
    tags = [{tag.get("k"): tag.get("v") for tag in one.iter("tag")} for one in root.iter("relation")]
    loaded, errors = lanelet2.io.loadRobust(path, MGRSProjector(lanelet2.io.Origin(0, 0)))
    same("errors of simple-lanelet2", list(errors), [])
    same("lanelets", len(loaded.laneletLayer), sum(one.get("type") == "lanelet" for one in tags))
    subtypes = Counter(one.get("subtype") for one in tags if one.get("type") == "regulatory_element")
    found = Counter(one.attributes["subtype"] for one in loaded.regulatoryElementLayer)
    same("regulatory elements", found, subtypes)
    relations = {relation.get("id"): relation for relation in root.iter("relation")}
    for element in loaded.regulatoryElementLayer:
        subtype = element.attributes["subtype"]
        expected = CLASSES.get(subtype)
        if expected:
            same(f"the class of {subtype} {element.id}", type(element).__name__, expected)
        roles = Counter(member.get("role") for member in relations[str(element.id)].iter("member"))
        same(f"members of {subtype} {element.id}", {r: len(v) for r, v in element.parameters.items() if len(v)}, dict(roles))


def main() -> None:
    path = sys.argv[1]
    root = ET.parse(path).getroot()
    for reader in (gdal, osmium, simple_lanelet2):
        reader(path, root)


main()
