#!/bin/sh
# GEOS 3.14.1 (shapely 2.2.0): a bridge 10 m above a road sags to 5 m where they cross, even if the road is only taken away from it.
#
# One would guess: GEOS works in the plane and carries heights along; so a level bridge is 10 m high afterwards, most of all in
#   `difference`, whose result consists of parts of the bridge. Lines without heights stay without.
# What happens: where lines cross in the plane both are cut, and the cut gets the mean of the two heights: bridge and road meet halfway
#   (`union_all`, `node`, `difference`, `shapely.ops.split`, and clipping by a polygon with heights as well). Where a road just ends below
#   the bridge, the bridge goes down to the road's 0 m. Where the bridge has a vertex of its own at the cut, it keeps 10 m: the result
#   depends on how it was digitised. A road without heights, on the other hand, gets the bridge's 10 m all along in a union.
#   To keep heights, take them off the other side first (`shapely.force_2d`), and give `difference` the bridge first.
# Source: GEOS OverlayNG, and the proposal for its heights, JTS issue 626, which calls levels that differ a case without guarantees.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check shapely==2.2.0 numpy
cat >"$place/run.py" <<'END'
import shapely
from shapely import LineString

bridge = LineString([(0, 0, 10), (100, 0, 10)])
vertex = LineString([(0, 0, 10), (50, 0, 10), (100, 0, 10)])
road = LineString([(50, -50, 0), (50, 50, 0)])
below = LineString([(50, 0, 0), (50, 50, 0)])
plain = LineString([(50, -50), (50, 50)])


def heights(geometry):
    """Heights along the bridge at 0, 50 and 100 m, and of the ends of the road if it is part of the result."""
    at = {(x, y): z for x, y, z in shapely.get_coordinates(geometry, include_z=True).tolist()}
    return [at.get(place) for place in ((0, 0), (50, 0), (100, 0), (50, -50), (50, 50)) if place in at]


seen = {
    "bridge and road, united": heights(shapely.union_all([bridge, road])),
    "bridge less the road": heights(bridge.difference(road)),
    "bridge less a road that ends below it": heights(bridge.difference(below)),
    "bridge with a vertex there, less the road": heights(vertex.difference(road)),
    "bridge less a road without heights": heights(bridge.difference(plain)),
    "bridge and a road without heights, united": heights(shapely.union_all([bridge, plain])),
}
print("GEOS", ".".join(map(str, shapely.geos_version)))
for what, z in seen.items():
    print("%-42s %s" % (what, z))
expected = [[10, 5, 10, 0, 0], [10, 5, 10], [10, 0, 10], [10, 10, 10], [10, 10, 10], [10, 10, 10, 10, 10]]
raise SystemExit(0 if list(seen.values()) == expected else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   GEOS 3.14.1
#   bridge and road, united                    [10.0, 5.0, 10.0, 0.0, 0.0]
#   bridge less the road                       [10.0, 5.0, 10.0]
#   bridge less a road that ends below it      [10.0, 0.0, 10.0]
#   bridge with a vertex there, less the road  [10.0, 10.0, 10.0]
#   bridge less a road without heights         [10.0, 10.0, 10.0]
#   bridge and a road without heights, united  [10.0, 10.0, 10.0, 10.0, 10.0]
