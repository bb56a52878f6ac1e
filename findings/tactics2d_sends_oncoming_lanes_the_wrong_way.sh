#!/bin/sh
# tactics2d 0.1.9, from OpenDRIVE to Lanelet2: all lanes of a two-way street run the same way, nobody may change lanes over a broken line, and
# the broken centre line becomes solid; with a speed limit in it, the file is refused by Lanelet2.
#
# One would guess: `Xodr2OsmConverter` gives the oncoming lanes (positive ids in right-hand traffic) bounds in the direction of their traffic; lanes
#   side by side share the line between them, which is how Lanelet2 knows neighbours; a limit is a tag or a regulatory element of its lane.
# What happens: left and right are taken along the reference line, for every lane, and so the direction is that of the line: who is in
#   the oncoming lane is led against the traffic. Each lane gets two ways of its own, so that no lane has a neighbour. The mark of the
#   centre line is not found, and "solid" is put. All that without a word, and the drawing is right in every place. A limit
#   becomes a relation of its own, without a sign and with no lanelet that refers to it: `lanelet2.io.load` stops at it, and
#   `loadRobust` leaves it out, so that 30 km/h is the 50 of towns. In tactics2d's own maps (`XODRParser`) the oncoming lanes
#   run the wrong way as well. rule="LHT" changes nothing.
# Source: tactics2d/map/parser/parse_xodr.py (_load_lane), tactics2d/map/writer/osm_writer.py (write_boundary_ways, write_speed_regulatory,
#   _get_roadmark), release 0.1.9; Lanelet2, LaneletPrimitives.md; ASAM OpenDRIVE 1.8, lanes.
# Exits 0 while it is so, 1 if that changes, 2 if it cannot be installed. Needs CPython 3.10 to 3.13 on Linux. Of its dependencies
# tactics2d gets those that the converter needs.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
{ python3 -m venv "$place/env" && "$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --no-deps --only-binary :all: \
  tactics2d==0.1.9 lanelet2==1.2.3 numpy==2.2.6 scipy==1.15.3 shapely==2.0.7 pyproj==3.7.1 certifi==2025.10.5 defusedxml==0.7.1 \
  geopandas==1.1.4 pandas==2.3.3 pyogrio==0.12.1 packaging==25.0 python-dateutil==2.9.0.post0 pytz==2025.2 tzdata==2025.2 six==1.17.0; } ||
  { echo "tactics2d 0.1.9 cannot be installed here: it needs CPython 3.10 to 3.13 on Linux and PyPI" >&2; exit 2; }
cat >"$place/run.py" <<'END'
import importlib.metadata
import pathlib
import sys

import lanelet2
from lanelet2.projection import UtmProjector
from tactics2d.map.converter import Xodr2OsmConverter
from tactics2d.map.parser import XODRParser

place = pathlib.Path(sys.argv[1])
broken = '<roadMark sOffset="0" type="broken" weight="standard" color="standard" width="0.12" laneChange="both"/>'


def road(number, x, link, rule):
    """100 m to the east, two lanes for each direction, 30 km/h."""
    def lane(index):
        return (f'<lane id="{index}" type="driving" level="false"><link><predecessor id="{index}"/><successor id="{index}"/></link>'
                f'<width sOffset="0" a="3.5" b="0" c="0" d="0"/>{broken}<speed sOffset="0" max="30" unit="km/h"/></lane>')
    return (f'<road name="" length="100" id="{number}" junction="-1" rule="{rule}"><link>{link}</link><type s="0" type="town"/>'
            f'<planView><geometry s="0" x="{x}" y="0" hdg="0" length="100"><line/></geometry></planView><lanes><laneSection s="0">'
            f'<left>{lane(2)}{lane(1)}</left><center><lane id="0" type="none" level="false">{broken}</lane></center>'
            f'<right>{lane(-1)}{lane(-2)}</right></laneSection></lanes></road>')


print(*(f"{name} {importlib.metadata.version(name)}" for name in ("tactics2d", "lanelet2")))
so = True
for rule in "RHT", "LHT":
    xodr, osm = str(place / "street.xodr"), str(place / "street.osm")
    pathlib.Path(xodr).write_text(
        '<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="7" name="street" version="1" date="" north="0" south="0" east="0" west="0"/>'
        + road(1, 0, '<successor elementType="road" elementId="2" contactPoint="start"/>', rule)
        + road(2, 100, '<predecessor elementType="road" elementId="1" contactPoint="end"/>', rule) + "</OpenDRIVE>")
    Xodr2OsmConverter().convert(xodr, osm)
    try:
        lanelet2.io.load(osm, UtmProjector(lanelet2.io.Origin(0, 0)))
        refused = False
    except RuntimeError as error:
        refused = "of type speed_limit failed" in str(error)
    loaded, errors = lanelet2.io.loadRobust(osm, UtmProjector(lanelet2.io.Origin(0, 0)))
    left_out = sum("of type speed_limit failed" in error for error in errors)
    rules = lanelet2.traffic_rules.create(lanelet2.traffic_rules.Locations.Germany, lanelet2.traffic_rules.Participants.VehicleCar)
    graph = lanelet2.routing.RoutingGraph(loaded, rules)
    limits = pathlib.Path(osm).read_text().count('<tag k="speed_limit" v="30.0"/>')
    print(f"{rule}: {len(loaded.laneletLayer)} lanelets, {limits} limits of 30 km/h in the file; refused: {refused}, left out: {left_out}")
    rows = []
    for lane in loaded.laneletLayer:
        start, end = lane.centerline[0], lane.centerline[len(lane.centerline) - 1]
        onward = [next_lane.centerline[0] for next_lane in graph.following(lane)]
        if min(start.x, end.x) < 50:
            rows.append((round(start.y / 1.75), "to the east" if end.x > start.x else "to the west", [round(point.x, -1) for point in onward],
                         graph.left(lane) is not None or graph.right(lane) is not None, lane.leftBound.attributes["subtype"],
                         lane.rightBound.attributes["subtype"], round(rules.speedLimit(lane).speedLimit), len(lane.regulatoryElements)))
    for index, course, onward, neighbour, left, right, speed, elements in sorted(rows, reverse=True):
        print(f"  lane at y = {index * 1.75:5.2f} {course}, goes on at x = {onward}; may change lanes: {neighbour}; "
              f"left {left}, right {right}; {speed} km/h, regulatory elements: {elements}")
    so &= refused and len(loaded.laneletLayer) == limits == left_out == 8 and sorted(rows, reverse=True) == [
        (index, "to the east", [100], False, left, right, 50, 0)
        for index, left, right in [(3, "dashed", "dashed"), (1, "dashed", "solid"), (-1, "solid", "dashed"), (-3, "dashed", "dashed")]]
    own = [lane.left_side.coords[-1][0] > lane.left_side.coords[0][0] for lane in XODRParser().parse(xodr).lanes.values()]
    print("  in tactics2d's own map, lanes to the east:", sum(own), "of", len(own))
    so &= own == [True] * 8
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   tactics2d 0.1.9 lanelet2 1.2.3
#   RHT: 8 lanelets, 8 limits of 30 km/h in the file; refused: True, left out: 8
#     lane at y =  5.25 to the east, goes on at x = [100.0]; may change lanes: False; left dashed, right dashed; 50 km/h, regulatory elements: 0
#     lane at y =  1.75 to the east, goes on at x = [100.0]; may change lanes: False; left dashed, right solid; 50 km/h, regulatory elements: 0
#     lane at y = -1.75 to the east, goes on at x = [100.0]; may change lanes: False; left solid, right dashed; 50 km/h, regulatory elements: 0
#     lane at y = -5.25 to the east, goes on at x = [100.0]; may change lanes: False; left dashed, right dashed; 50 km/h, regulatory elements: 0
#     in tactics2d's own map, lanes to the east: 8 of 8
#   LHT: 8 lanelets, 8 limits of 30 km/h in the file; refused: True, left out: 8
#     lane at y =  5.25 to the east, goes on at x = [100.0]; may change lanes: False; left dashed, right dashed; 50 km/h, regulatory elements: 0
#     lane at y =  1.75 to the east, goes on at x = [100.0]; may change lanes: False; left dashed, right solid; 50 km/h, regulatory elements: 0
#     lane at y = -1.75 to the east, goes on at x = [100.0]; may change lanes: False; left solid, right dashed; 50 km/h, regulatory elements: 0
#     lane at y = -5.25 to the east, goes on at x = [100.0]; may change lanes: False; left dashed, right dashed; 50 km/h, regulatory elements: 0
#     in tactics2d's own map, lanes to the east: 8 of 8
