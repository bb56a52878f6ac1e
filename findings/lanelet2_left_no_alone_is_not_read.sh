#!/usr/bin/env bash
# A line between two lanes of one direction can say by side who may cross it. One would guess that lane_change:left=no and
# lane_change:right=no are mirror images: each closes its side, or each closes both since the other side is not named.
# In Lanelet2 1.2.3 (PyPI wheel) they are not: over a dashed line, lane_change:right=no alone closes both sides, while
# lane_change:left=no alone is not read at all, and vehicles change lanes to both sides. With both tags each counts.
# Source: GenericTrafficRules of lanelet2_traffic_rules, as the routing graph of the wheel shows it below.
set -eu
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
python3 -m venv "$dir/venv"
"$dir/venv/bin/pip" install --quiet lanelet2==1.2.3
"$dir/venv/bin/python" - <<'PYTHON'
import itertools, sys
import lanelet2
from lanelet2.core import Lanelet, LineString3d, Point3d
from lanelet2.routing import RoutingGraph
from lanelet2.traffic_rules import Locations, Participants, create

ids = itertools.count(1)
line = lambda y: LineString3d(next(ids), [Point3d(next(ids), x, y, 0) for x in (0, 10)])


def changes(**sides):
    left, middle, right = line(2), line(0), line(-2)
    middle.attributes["type"], middle.attributes["subtype"] = "line_thin", "dashed"
    for side, value in sides.items():
        middle.attributes["lane_change:" + side] = value
    lanes = [Lanelet(next(ids), left, middle), Lanelet(next(ids), middle, right)]
    for lane in lanes:
        lane.attributes["subtype"] = "road"
    graph = RoutingGraph(lanelet2.core.createMapFromLanelets(lanes), create(Locations.Germany, Participants.Vehicle))
    return "to the left" * (graph.left(lanes[1]) is not None) or "-", "to the right" * (graph.right(lanes[0]) is not None) or "-"


seen = {
    "lane_change:left=no": changes(left="no"),
    "lane_change:right=no": changes(right="no"),
    "both no": changes(left="no", right="no"),
    "left=no, right=yes": changes(left="no", right="yes"),
}
for said, open_sides in seen.items():
    print(f"{said:22} crossed: {', '.join(open_sides)}")
expected = {
    "lane_change:left=no": ("to the left", "to the right"),
    "lane_change:right=no": ("-", "-"),
    "both no": ("-", "-"),
    "left=no, right=yes": ("-", "to the right"),
}
sys.exit(0 if seen == expected else 1)
PYTHON
