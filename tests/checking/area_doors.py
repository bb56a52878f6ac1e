"""For each map on stdin, a JSON list of paths: which lanelets lead into which areas (+) and out of them (-), by Lanelet2's own rules.

Asked for bicycles: the library's rules for vehicles keep them out of areas, and it has no Python class to derive Autoware's from.
"""

import json
import sys

import lanelet2
from lanelet2.io import Origin
from lanelet2.projection import UtmProjector

rules = lanelet2.traffic_rules.create(lanelet2.traffic_rules.Locations.Germany, "bicycle")


def doors(path):
    loaded = lanelet2.io.load(path, UtmProjector(Origin(35.25, 139.72)))
    found = []
    for area in loaded.areaLayer:
        for lanelet in loaded.laneletLayer:
            two_way = lanelet.attributes["one_way"] == "no" if "one_way" in lanelet.attributes else False
            directions = [lanelet] + ([lanelet.invert()] if two_way else [])
            if any(rules.canPass(one, area) for one in directions):
                found.append(["+", lanelet.id, area.id])
            if any(rules.canPass(area, one) for one in directions):
                found.append(["-", lanelet.id, area.id])
    return sorted(found)


json.dump([doors(path) for path in json.load(sys.stdin)], sys.stdout)
