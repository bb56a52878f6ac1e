#!/bin/sh
# scenariogeneration 0.16.7: posts that are to stand half a metre beside the road stand in the middle of it, where OpenDRIVE has a lane offset,
# and in a turning lane, while this one gets wider.
#
# One would guess: `add_object_roadside` sets objects beside the road; `tOffset` is the distance from its edge, "additional to lane width",
#   "positive if further from the roadside". It asks for the roads to be adjusted first, so it knows where the edges are.
# What happens: the distance from the reference line is the sum of the first number of each lane's width in the section. `<laneOffset>`, which the
#   same library writes, is not counted: of a one-way road of 7 m around its reference line, the posts on the left stand in the middle and
#   those on the right 4 m away. A lane that grows from nothing, as `LaneDef` makes it, counts as 0 m up to its end, and a post
#   stands 2.7 m inside of it; one that ends counts in full. Where widths do not change and there is no offset, all is
#   right. There is no warning.
# Source: scenariogeneration/xodr/opendrive.py (Road.add_object_roadside, its help and the note "handle width parameters apart from a"), release
#   0.16.7; ASAM OpenDRIVE 1.8, lane offset, lane width, and `t` of objects, which counts from the reference line.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.11 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --only-binary :all: \
  scenariogeneration==0.16.7 pyclothoids==0.2.0 numpy==2.4.6 scipy==1.17.1 lxml==6.1.3 xmlschema==4.3.2 elementpath==5.1.4
cat >"$place/run.py" <<'END'
import pathlib
import sys
import xml.etree.ElementTree as ET

from scenariogeneration import xodr

path = pathlib.Path(sys.argv[1]) / "road.xodr"
LENGTH, STEP, BESIDE = 300, 50, 0.5  # of the road, between posts, beside the road; in metres


def value(records, start, s):
    """What cubic records say at a place; their own places are named by the attribute `start`."""
    here = [one for one in records if float(one.get(start)) <= s + 1e-9]
    if not here:
        return 0.0
    along = s - float(here[-1].get(start))
    return sum(float(here[-1].get(name)) * along ** power for power, name in enumerate("abcd"))


def edges(road, s):
    """The left and the right edge of a road, as its file says."""
    section = [one for one in road.iter("laneSection") if float(one.get("s")) <= s][-1]
    middle = value(road.findall("lanes/laneOffset"), "s", s)
    wide = {side: sum(value(lane.findall("width"), "sOffset", s - float(section.get("s"))) for lane in section.findall(side + "/lane"))
            for side in ("left", "right")}
    return middle + wide["left"], middle - wide["right"]


def posts(left, right, offset):
    """Where posts on both sides of a road stand: side and place, and the distance outside of the edge; negative ones are on the road."""
    road = xodr.create_road(xodr.Line(LENGTH), id=1, left_lanes=left, right_lanes=right, lane_width=3.5)
    if offset:
        road.lanes.add_laneoffset(xodr.LaneOffset(0, offset))
    town = xodr.OpenDrive("posts")
    town.add_road(road)
    town.adjust_roads_and_lanes()
    post = xodr.Object(s=0, t=0, Type=xodr.ObjectType.pole, name="post", height=1, radius=0.1)
    road.add_object_roadside(post, STEP, tOffset=BESIDE)
    town.write_xml(str(path))
    found = ET.parse(path).getroot().find("road")
    seen = {}
    for one in found.iter("object"):
        for repeat in one.iter("repeat"):
            assert repeat.get("tStart") == repeat.get("tEnd")
            s, t = float(repeat.get("s")), float(repeat.get("tStart"))
            end = min(s + float(repeat.get("length")), LENGTH - 1)
            while s < end:
                left_edge, right_edge = edges(found, s)
                side = "left" if float(one.get("t")) > 0 else "right"
                seen[side, s] = round(t - left_edge if side == "left" else right_edge - t, 1)
                s += STEP
    return seen


so = True
for name, (left, right, offset), expected in (
    ("a lane each way", (1, 1, 0), {"left": {0.5}, "right": {0.5}}),
    ("two lanes one way, on the right of the line", (0, 2, 0), {"left": {0.5}, "right": {0.5}}),
    ("two lanes one way, around the line", (0, 2, 3.5), {"left": {-3.0}, "right": {4.0}}),
    ("turning lane grows from 100 m to 160 m", (1, xodr.LaneDef(100, 160, 1, 2, -2), 0), {"left": {0.5}, "right": {0.5, -2.7}}),
    ("lane ends from 100 m to 160 m", (1, xodr.LaneDef(100, 160, 2, 1, -2), 0), {"left": {0.5}, "right": {0.5, 3.7}}),
):
    seen = posts(left, right, offset)
    so &= {side: {distance for (where, _), distance in seen.items() if where == side} for side in ("left", "right")} == expected
    print("%s:" % name)
    for side in ("left", "right"):
        far = {}
        for (where, s), distance in seen.items():
            if where == side:
                far.setdefault(distance, []).append("%d" % s)
        print("  %-5s %s" % (side, "; ".join("%.1f m %s: posts at %s m" % (abs(distance), "beside" if distance > 0 else "inside of the edge", ", ".join(places))
                                             for distance, places in far.items())))
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   a lane each way:
#     left  0.5 m beside: posts at 0, 50, 100, 150, 200, 250 m
#     right 0.5 m beside: posts at 0, 50, 100, 150, 200, 250 m
#   two lanes one way, on the right of the line:
#     left  0.5 m beside: posts at 0, 50, 100, 150, 200, 250 m
#     right 0.5 m beside: posts at 0, 50, 100, 150, 200, 250 m
#   two lanes one way, around the line:
#     left  3.0 m inside of the edge: posts at 0, 50, 100, 150, 200, 250 m
#     right 4.0 m beside: posts at 0, 50, 100, 150, 200, 250 m
#   turning lane grows from 100 m to 160 m:
#     left  0.5 m beside: posts at 0, 50, 100, 150, 200, 250 m
#     right 0.5 m beside: posts at 0, 50, 100, 160, 210, 260 m; 2.7 m inside of the edge: posts at 150 m
#   lane ends from 100 m to 160 m:
#     left  0.5 m beside: posts at 0, 50, 100, 150, 200, 250 m
#     right 0.5 m beside: posts at 0, 50, 100, 160, 210, 260 m; 3.7 m beside: posts at 150 m
