#!/bin/sh
# simple-lanelet2 1.2.3 with Autoware's MGRSProjector: a street of 300 m in the east of Tokyo is 100 km long, since it crosses the border of two
# squares of the grid; written and read again, its west half lies 100 km from its east half on the ground as well.
#
# One would guess: the square of a map is a choice of origin, as Autoware's maps name one square for all of a map; beyond its border
#   coordinates go on, x = 100,050. With `setMGRSCode` the square is fixed; `forward` and `reverse` undo each other.
# What happens: `forward` gives each point its place within its own square, so that x falls from 99,999 to 0 in the midst of a lanelet. The code
#   that was set makes no difference to it. `reverse` takes one square for all points: the code that was set, else the one of the last point
#   that `forward` saw, whichever that is. So a map that goes through both, as in a load and a write, is torn on the ground.
#   Of this there is a line "Projected MGRS Grid changed" on the error output, and nothing in what is returned. The grid's lines lie each
#   100 km: this one leads through Edogawa and Urayasu. The same map by `UtmProjector` is whole. The package follows Autoware's
#   own projector here.
# Source: autoware_lanelet2_extension, lib/mgrs_projector.cpp (forward: remainder of the point's own square; reverse: the code that was set, else
#   the last one seen), and the Rust port of both in simple-lanelet2 (readme, Autoware maps).
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.9 or newer on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile simple-lanelet2==1.2.3
cat >"$place/run.py" <<'END'
import importlib.metadata
import pathlib
import sys

import lanelet2
from autoware_lanelet2_extension_python.projection import MGRSProjector
from lanelet2.io import Origin
from lanelet2.projection import UtmProjector

place = pathlib.Path(sys.argv[1])
source, copy = str(place / "tokyo.osm"), str(place / "copy.osm")
nodes, ways = "", ""
longitudes = [139.8935, 139.8945, 139.8955, 139.8965]
for way, latitude in (11, 35.68003), (12, 35.68):
    for number, longitude in enumerate(longitudes):
        nodes += f'<node id="{way}{number}" lat="{latitude}" lon="{longitude}"><tag k="ele" v="3"/></node>'
    ways += f'<way id="{way}">' + "".join(f'<nd ref="{way}{number}"/>' for number in range(4)) + '<tag k="type" v="line_thin"/><tag k="subtype" v="solid"/></way>'
pathlib.Path(source).write_text(
    f'<?xml version="1.0"?><osm version="0.6">{nodes}{ways}<relation id="1"><member type="way" ref="11" role="left"/><member type="way" ref="12" '
    'role="right"/><tag k="type" v="lanelet"/><tag k="subtype" v="road"/><tag k="location" v="urban"/></relation></osm>')


def show(name, map_):
    line = list(map_.laneletLayer)[0].rightBound
    xs, length = [round(point.x) for point in line], lanelet2.geometry.length(line)
    print(f"{name}: x {xs}, {length / 1000:.1f} km long")
    return round(length / 1000, 1)


def mgrs(code=None):
    projector = MGRSProjector(Origin(0, 0))
    if code:
        projector.setMGRSCode(code)
    return projector


print("simple-lanelet2", importlib.metadata.version("simple-lanelet2"))
utm = UtmProjector(Origin(35.68, 139.89))
so = show("UtmProjector", lanelet2.io.load(source, utm)) == 0.3
for code in None, "54SUE", "54SVE":
    projector = mgrs(code)
    map_ = lanelet2.io.load(source, projector)
    so &= show(f"MGRSProjector, code {code or 'not set'}", map_) == 100.1
    lanelet2.io.write(copy, map_, projector)
    so &= show("  written, and read by UtmProjector", lanelet2.io.load(copy, utm)) == 100.1
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   simple-lanelet2 1.2.3
#   UtmProjector: x [317, 407, 498, 588], 0.3 km long
#   MGRSProjector, code not set: x [99870, 99961, 51, 142], 100.1 km long
#     written, and read by UtmProjector: x [100317, 100407, 498, 588], 100.1 km long
#   MGRSProjector, code 54SUE: x [99870, 99961, 51, 142], 100.1 km long
#     written, and read by UtmProjector: x [317, 407, -99502, -99412], 100.1 km long
#   MGRSProjector, code 54SVE: x [99870, 99961, 51, 142], 100.1 km long
#     written, and read by UtmProjector: x [100317, 100407, 498, 588], 100.1 km long
