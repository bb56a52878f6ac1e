#!/bin/sh
# Lanelet2 1.2.3: `Origin(lat=35.68, lon=139.77)` lies 139.77 m above the ellipsoid; the map that is loaded with it, 139.77 m too low.
#
# One would guess: in Python, arguments by name mean what arguments by position mean; `Origin(35.68, 139.77)` has height 0, and `alt=40`
#   sets the height, or is refused.
# What happens: the constructor's third argument is named `lon` as well. A longitude by name is the height, too; `alt=40` is taken without
#   complaint and dropped. `UtmProjector` and `MercatorProjector` do not use the origin's height, so that latitude and longitude look
#   right everywhere; under `LocalCartesianProjector` all heights are lower by the longitude (in America: higher), in metres.
# Source: lanelet2_python, python_api/io.cpp, release 1.2.3; the signature that `help(lanelet2.io.Origin)` shows.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check lanelet2==1.2.3
cat >"$place/map.osm" <<'END'
<?xml version="1.0"?>
<osm version="0.6" generator="by hand">
  <node id="1" lat="35.68" lon="139.77"><tag k="ele" v="5"/></node><node id="2" lat="35.68" lon="139.771"><tag k="ele" v="5"/></node>
  <way id="3"><nd ref="1"/><nd ref="2"/><tag k="type" v="road_border"/></way>
</osm>
END
cat >"$place/run.py" <<'END'
import sys
from lanelet2.io import Origin, load
from lanelet2.projection import LocalCartesianProjector, UtmProjector

origins = {
    "Origin(35.68, 139.77)": Origin(35.68, 139.77),
    "Origin(35.68, 139.77, 40)": Origin(35.68, 139.77, 40),
    "Origin(lat=35.68, lon=139.77)": Origin(lat=35.68, lon=139.77),
    "Origin(lat=35.68, lon=139.77, alt=40)": Origin(lat=35.68, lon=139.77, alt=40),
}
seen = {}
for written, origin in origins.items():
    local, utm = (load(sys.argv[1], kind(origin)).pointLayer[1].z for kind in (LocalCartesianProjector, UtmProjector))
    seen[written] = round(origin.position.alt, 2), round(local, 2), round(utm, 2)
    print("%-38s height of the origin %6.2f; a point at ele 5: local %7.2f, UTM %.2f" % (written, *seen[written]))
raise SystemExit(0 if list(seen.values()) == [(0, 5, 5), (40, -35, 5), (139.77, -134.77, 5), (139.77, -134.77, 5)] else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/map.osm"
# Seen:
#   Origin(35.68, 139.77)                  height of the origin   0.00; a point at ele 5: local    5.00, UTM 5.00
#   Origin(35.68, 139.77, 40)              height of the origin  40.00; a point at ele 5: local  -35.00, UTM 5.00
#   Origin(lat=35.68, lon=139.77)          height of the origin 139.77; a point at ele 5: local -134.77, UTM 5.00
#   Origin(lat=35.68, lon=139.77, alt=40)  height of the origin 139.77; a point at ele 5: local -134.77, UTM 5.00
