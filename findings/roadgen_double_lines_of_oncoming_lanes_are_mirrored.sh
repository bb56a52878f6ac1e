#!/bin/sh
# roadgen 0.41.2, from OpenDRIVE to Lanelet2: between oncoming lanes a double line has its solid half on the wrong side, so that those who may
# change lanes may not, and the others may.
#
# One would guess: a road that is the same in both directions gives lanelets that are the same in both directions.
# What happens: OpenDRIVE names the halves of `broken solid` from the inside of the road to the outside; only at the centre lane it is
#   from left to right. Lanelet2 names the halves of `dashed_solid` from left to right along the line. All lines that roadgen writes run along
#   the reference line; there, seen from a lane of positive id, the inside is on the right. The names are taken over without turning them
#   around, so the lines of positive ids are mirrored. Negative ids and the centre line are right. In left-hand traffic it is the same: there the
#   positive ids run along the reference line, and it is they who get the wrong half. No warning is given.
# Source: release 0.41.2 (a compiled wheel; seen from outside), read by Lanelet2 1.2.3 (PyPI wheel). ASAM OpenDRIVE 1.8, annex,
#   e_roadMarkType: "From inside to outside, exception: center lane - from left to right". Lanelet2's documentation, LinestringTagging, and
#   its issue 50: the subtype is relative to the direction of the line.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.9 to 3.13 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: roadgen==0.41.2 lanelet2==1.2.3
cat >"$place/run.py" <<'END'
import os
import sys
from importlib.metadata import version

import lanelet2
import roadgen

WIDTH = 3.5


def lane(number, mark):
    width = f'<width sOffset="0" a="{WIDTH}" b="0" c="0" d="0"/>' if number else ""
    return (f'<lane id="{number}" type="driving" level="false"><link/>{width}'
            f'<roadMark sOffset="0" type="{mark}" weight="standard" color="white" width="0.12"/></lane>')


def changes(mark, rule):
    """Which lane may change to which, by id of OpenDRIVE; the line between 1 and 2, and between -1 and -2, is the mark."""
    xodr, osm = os.path.join(sys.argv[1], "road.xodr"), os.path.join(sys.argv[1], "road.osm")
    with open(xodr, "w") as file:
        file.write(f"""<?xml version="1.0"?>
<OpenDRIVE><header revMajor="1" revMinor="7" name="" version="1" date="2025-01-01T00:00:00" north="0" south="0" east="0" west="0" vendor="hand">
<geoReference><![CDATA[+proj=tmerc +lat_0=35 +lon_0=139 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs]]></geoReference></header>
<road name="" length="100" id="1" junction="-1" rule="{rule}"><link/><type s="0" type="town"/>
<planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
<elevationProfile><elevation s="0" a="10" b="0" c="0" d="0"/></elevationProfile><lateralProfile/>
<lanes><laneSection s="0"><left>{lane(2, "solid")}{lane(1, mark)}</left><center>{lane(0, "solid solid")}</center>
<right>{lane(-1, mark)}{lane(-2, "solid")}</right></laneSection></lanes><objects/><signals/></road></OpenDRIVE>""")
    world = roadgen.read_opendrive(xodr)
    told = [each for each in world.read_warnings() if "altitude" not in each] + world.issues() + world.format_warnings()
    world.export_lanelet2(osm, trace=False)
    projector = lanelet2.projection.LocalCartesianProjector(lanelet2.io.Origin(35, 139))
    laneletmap = lanelet2.io.load(osm, projector)
    rules = lanelet2.traffic_rules.create(lanelet2.traffic_rules.Locations.Germany, lanelet2.traffic_rules.Participants.Vehicle)
    graph = lanelet2.routing.RoutingGraph(laneletmap, rules)
    number = {}
    for each in laneletmap.laneletLayer:
        middle = (each.leftBound[0].y + each.rightBound[0].y) / 2
        number[each.id] = round(middle / WIDTH + (0.5 if middle > 0 else -0.5))
    assert sorted(number.values()) == [-2, -1, 1, 2]
    found = {(number[each.id], number[other.id]) for each in laneletmap.laneletLayer for other in graph.besides(each)
             if other.id != each.id and {graph.left(each), graph.right(each)} & {other}}
    return sorted(found), told


print("roadgen", version("roadgen"), "- lanelet2", version("lanelet2"))
good = True
for mark, rule, due, expected in [
    ("broken", "RHT", [(-2, -1), (-1, -2), (1, 2), (2, 1)], [(-2, -1), (-1, -2), (1, 2), (2, 1)]),
    ("broken solid", "RHT", [(-1, -2), (1, 2)], [(-1, -2), (2, 1)]),
    ("solid broken", "RHT", [(-2, -1), (2, 1)], [(-2, -1), (1, 2)]),
    ("broken solid", "LHT", [(-1, -2), (1, 2)], [(-1, -2), (2, 1)]),
]:
    seen, told = changes(mark, rule)
    print(f"{mark}, {rule}: may change {seen}; by OpenDRIVE {due}; warnings: {told}")
    good &= seen == expected and not told
raise SystemExit(0 if good else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
