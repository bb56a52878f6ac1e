#!/usr/bin/env python3
"""Loads each cell, and each block of 3 x 3 cells merged by id, in the real Lanelet2 library and holds routing in it against
that of the whole map: divided_maps.py WHOLE.osm CELLS [WHOLE.osm CELLS ...]. The list of the cells is read as Autoware does.

The plain library does not know the regulatory elements that Autoware adds; what it says of those is no fault of a cell, as long
as it says the same of the whole.
"""
import os
import re
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

try:
    import lanelet2
    from lanelet2.projection import UtmProjector
    from lanelet2.io import Origin
except ImportError:
    print("no lanelet2")
    sys.exit(0)


def projector_of(path):
    for _, element in ElementTree.iterparse(path):
        if element.tag == "node" and element.get("lat"):
            return UtmProjector(Origin(float(element.get("lat")), float(element.get("lon"))))
    raise SystemExit(f"{path} has no places")


def load(path, projector):
    loaded, errors = lanelet2.io.loadRobust(path, projector)
    return loaded, {line.strip() for error in errors for line in str(error).splitlines() if "Error" not in line[:6]}


def graph_of(loaded):
    rules = lanelet2.traffic_rules.create(lanelet2.traffic_rules.Locations.Germany, lanelet2.traffic_rules.Participants.Vehicle)
    return lanelet2.routing.RoutingGraph(loaded, rules)


def neighbours(graph, lane, among):
    """All that the graph says of a lanelet, as far as it speaks of these."""
    of = lambda lanelets: sorted(other.id for other in lanelets if other.id in among)
    one = lambda other: of([other] if other else [])
    return {
        "following": of(graph.following(lane)),
        "previous": of(graph.previous(lane)),
        "left": one(graph.left(lane)),
        "right": one(graph.right(lane)),
        "adjacentLeft": one(graph.adjacentLeft(lane)),
        "adjacentRight": one(graph.adjacentRight(lane)),
        "conflicting": of(x for x in graph.conflicting(lane) if hasattr(x, "leftBound")),
    }


def listed(folder):
    """The cells with their corners, each found where Autoware looks: by its name from the directory of the list."""
    cells, resolution = {}, None
    for line in open(os.path.join(folder, "lanelet2_map_metadata.yaml"), encoding="utf8"):
        key, value = line.strip().split(": ", 1)
        if key.endswith("_resolution"):
            resolution = float(value)
            continue
        x, y = (float(number) for number in re.fullmatch(r"\[(.*), (.*)\]", value).groups())
        path = os.path.join(folder, key)
        assert os.path.isfile(path), f"{path} is not there"
        cells[round(x / resolution), round(y / resolution)] = path
    return cells


def merged(paths, target):
    """One map of several cells, by id: what two cells share must be the same, letter for letter."""
    root, known = ElementTree.Element("osm", version="0.6"), {}
    for path in paths:
        for element in ElementTree.parse(path).getroot():
            if element.tag not in ("node", "way", "relation"):
                continue
            element.tail = "\n"
            key, text = (element.tag, element.get("id")), ElementTree.tostring(element)
            if known.setdefault(key, text) != text:
                raise SystemExit(f"{path}: {key} is not the same in another cell")
            if known[key] is text:
                root.append(element)
    ElementTree.ElementTree(root).write(target)


def hold(whole_path, folder):
    projector = projector_of(whole_path)
    whole, whole_errors = load(whole_path, projector)
    whole_graph = graph_of(whole)
    cells = listed(folder)
    blocks = {cell: [path] for cell, path in cells.items()}
    faults = []
    with tempfile.TemporaryDirectory() as scratch:
        for name, around in (("cell", 0), ("block", 1)):
            for x, y in blocks:
                near = [cells[x + i, y + j] for i in range(-around, around + 1) for j in range(-around, around + 1) if (x + i, y + j) in cells]
                path = near[0] if around == 0 else os.path.join(scratch, "block.osm")
                if around:
                    merged(near, path)
                part, errors = load(path, projector)
                faults += [f"{name} {x} {y}: {error}" for error in errors - whole_errors]
                among = {lane.id for lane in part.laneletLayer}
                graph = graph_of(part)
                lanes = list(part.laneletLayer)
                for lane in lanes:
                    own, all_of = (neighbours(g, m.laneletLayer[lane.id], among) for g, m in ((graph, part), (whole_graph, whole)))
                    if own != all_of:
                        faults.append(f"{name} {x} {y}: lanelet {lane.id}: {own} is {all_of} in the whole map")
                if around:
                    faults += routes(lanes, among, (graph, part), (whole_graph, whole), f"{name} {x} {y}")
    return [f"{folder}: {fault}" for fault in faults], len(cells)


def routes(lanes, among, own, whole, where):
    """Routes that lie within the block in the whole map are found in the block."""
    faults = []
    for start in lanes[::7]:
        for end in lanes[::5]:
            of = [g.getRoute(m.laneletLayer[start.id], m.laneletLayer[end.id]) for g, m in (own, whole)]
            paths = [[lane.id for lane in route.shortestPath()] if route else None for route in of]
            if paths[1] is not None and set(paths[1]) <= among and paths[0] != paths[1]:
                faults.append(f"{where}: route {start.id} to {end.id}: {paths[0]} is {paths[1]} in the whole map")
    return faults


def main():
    faults = []
    for whole, folder in zip(sys.argv[1::2], sys.argv[2::2]):
        found, cells = hold(whole, folder)
        print(f"{folder}: {cells} cells, {len(found)} faults")
        faults += found
    print("\n".join(faults[:20]))
    sys.exit(1 if faults else 0)


main()
