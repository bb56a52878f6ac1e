#!/bin/sh
# Lanelet2 1.2.3: the centre line of one and the same lanelet is 126 m or 8 m long, depending on the last bit of the projected coordinates.
#
# One would guess: another origin of the projection moves a centre line and turns it by a hair; its length stays the same within
#   millimetres, as that of the bounds does.
# What happens: where a lane runs around a block and ends some metres behind its own start, the centre line at times steps backwards
#   over the start to the end, and leaves the whole lane out. Whether it does so differs between origins a few metres apart: under
#   LocalCartesianProjector about every third origin is hit. Under UtmProjector none was: its coordinates are differences of large
#   numbers, whose few binary places leave no rounding in the middle of two points.
# Source: lanelet2_core/src/Lanelet.cpp, calculateCenterline, release 1.2.3. A step backwards is turned down only if it intersects the
#   line from the right to the left start (crossesEntry). The first step begins at the middle of that very line, so that they always
#   touch, but the floating point test for it says by chance yes or no; the nearest point of the other bound is then the one at the end.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check lanelet2==1.2.3
# A lane 4 m wide, once around a block to the left: straight edges, no bound crosses itself or the other, start and end 6 m apart.
cat >"$place/block.osm" <<'END'
<?xml version="1.0"?>
<osm version="0.6" generator="by hand">
  <node id="1" lat="49.0000144" lon="7.9999836"/>
  <node id="2" lat="49.0001658" lon="8.0002904"/>
  <node id="3" lat="49.0003532" lon="8.0000767"/>
  <node id="4" lat="49.0001694" lon="7.9997041"/>
  <node id="5" lat="48.9999820" lon="7.9999178"/>
  <node id="6" lat="48.9999856" lon="8.0000164"/>
  <node id="7" lat="49.0001586" lon="8.0003671"/>
  <node id="8" lat="49.0004036" lon="8.0000877"/>
  <node id="9" lat="49.0001766" lon="7.9996274"/>
  <node id="10" lat="48.9999604" lon="7.9998740"/>
  <way id="11"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="5"/><tag k="type" v="road_border"/></way>
  <way id="12"><nd ref="6"/><nd ref="7"/><nd ref="8"/><nd ref="9"/><nd ref="10"/><tag k="type" v="road_border"/></way>
  <relation id="13">
    <member type="way" ref="11" role="left"/><member type="way" ref="12" role="right"/>
    <tag k="type" v="lanelet"/><tag k="subtype" v="road"/><tag k="location" v="urban"/><tag k="one_way" v="yes"/>
  </relation>
</osm>
END
cat >"$place/run.py" <<'END'
import sys
from lanelet2 import geometry
from lanelet2.core import LineString3d, Point3d
from lanelet2.io import Origin, load
from lanelet2.projection import LocalCartesianProjector, UtmProjector


def line(*places):
    return geometry.to2D(LineString3d(0, [Point3d(0, x, y, 0) for x, y in places]))


def middle(p, q):
    return (p.x + q.x) * 0.5, (p.y + q.y) * 0.5


def seen(projector):
    lane = load(sys.argv[1], projector).laneletLayer[13]
    left, right = list(lane.leftBound), list(lane.rightBound)
    entry = line((right[0].x, right[0].y), (left[0].x, left[0].y))
    backwards = line(middle(left[0], right[0]), middle(left[-1], right[0]))
    bounds = geometry.length(lane.leftBound), geometry.length(lane.rightBound)
    return geometry.length2d(lane), geometry.intersects2d(entry, backwards), bounds


so = True
for projector in LocalCartesianProjector, UtmProjector:
    # 441 origins on a grid around the lane, some 10 m from one to the next
    all_seen = [seen(projector(Origin(49 + i / 10000, 8 + j / 10000))) for i in range(-10, 11) for j in range(-10, 11)]
    spread = max(max(ends) - min(ends) for ends in zip(*(bounds for _, _, bounds in all_seen)))
    short = [(length, touches) for length, touches, _ in all_seen if length < 60]
    whole = [(length, touches) for length, touches, _ in all_seen if length >= 60]
    print(projector.__name__)
    print("  lengths of the bounds differ by less than a millimetre:", spread < 0.001)
    print("  whole centre line: %d times, %.1f m" % (len(whole), whole[0][0]))
    print("  cut off: %d times%s" % (len(short), short and ", from %.1f m" % min(short)[0] or ""))
    print("  cut off just where the step backwards is said not to touch the entry:",
          all(touches for _, touches in whole) and not any(touches for _, touches in short))
    so &= spread < 0.001 and bool(short) == (projector is LocalCartesianProjector)
    so &= all(touches for _, touches in whole) and not any(touches for _, touches in short)
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/block.osm"
