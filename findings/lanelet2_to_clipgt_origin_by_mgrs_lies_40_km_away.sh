#!/bin/sh
# autoware-lanelet2-to-clipgt 0.1.0: with the origin `54SUE815501`, an example of its own readme, the map comes out 40 km north of the origin;
# with `54SUE` and an offset in metres it is up to half a metre off, and too high by the offset's height.
#
# One would guess: half of the digits of an MGRS code are the easting, half the northing: 815 and 501 are 81.5 km and 50.1 km. An origin is where
#   local x, y, z = 0 lies, as the readme says; the same place in its three ways of writing gives the same map.
# What happens: a short code gets zeros at its end, `54SUE8155010000`, and is then 81,550 m and 10,000 m. Codes of two, four, six and
#   eight digits all suffer; ten digits and no digits do not. Of `offset` the decimals are cut off, and mgrs 1.6.0, which the package
#   allows, adds half a metre, since it gives the middle of the square and not its corner as before: 81655.73 is 81655.5. The height
#   of the origin (`z`, `altitude`) is passed to Lanelet2's UtmProjector, which has no use for it: heights stay above sea level. No
#   warning. A way out: `lat_lon`, and heights subtracted by hand.
# Source: autoware_lanelet2_to_clipgt/projection.py (_normalize_mgrs_grid, mgrs_offset_to_origin) and conf/map/example.yaml, as installed;
#   readme of release 0.1.0; release notes of mgrs 1.6.0.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.11 to 3.13 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile \
  autoware-lanelet2-to-clipgt==0.1.0 simple-lanelet2==1.2.3 mgrs==1.6.0 pyarrow==26.0.1 pandas==3.1.1 numpy==2.4.6 pyproj==3.7.2
cat >"$place/run.py" <<'END'
import pathlib
import sys

import pyarrow.parquet
import pyproj
from autoware_lanelet2_to_clipgt import convert, origin_from_map_config

place = pathlib.Path(sys.argv[1])
to_degrees = pyproj.Transformer.from_crs(32654, 4326, always_xy=True)  # UTM, zone 54
SQUARE = 300_000, 3_900_000  # the corner of 54SUE


def corner(x, y):
    """Longitude and latitude of a place in 54SUE."""
    return to_degrees.transform(SQUARE[0] + x, SQUARE[1] + y)


def begin(x, y, height, config):
    """Where a lane whose left line begins at x, y of 54SUE begins in the converter's output."""
    nodes = ""
    for number, (east, north) in enumerate([(0, 0), (50, 0), (0, -3.5), (50, -3.5)], 1):
        longitude, latitude = corner(x + east, y + north)
        nodes += '<node id="%d" lat="%.11f" lon="%.11f"><tag k="ele" v="%s"/></node>' % (number, latitude, longitude, height)
    line = '<way id="%d"><nd ref="%d"/><nd ref="%d"/><tag k="type" v="line_thin"/><tag k="subtype" v="solid"/></way>'
    (place / "map.osm").write_text(
        '<?xml version="1.0"?><osm version="0.6" generator="by hand">%s%s%s<relation id="13"><member type="way" ref="11" role="left"/>'
        '<member type="way" ref="12" role="right"/><tag k="type" v="lanelet"/><tag k="subtype" v="road"/><tag k="location" v="urban"/>'
        '<tag k="one_way" v="yes"/></relation></osm>' % (nodes, line % (11, 1, 2), line % (12, 3, 4)))
    convert(place / "map.osm", place / "clip", origin_from_map_config(config))
    lane, = pyarrow.parquet.read_table(place / "clip" / "lane.parquet").to_pylist()
    return tuple(round(lane["lane"]["left_rail"][0][axis], 2) + 0.0 for axis in "xyz")


so = True
for name, (x, y, z), config, expected in (
    ("54SUE815501", (81_500, 50_100, 0), {"mgrs_grid": "54SUE815501"}, (-50.5, 40_099.5, 0)),
    ("54SUE81505010", (81_500, 50_100, 0), {"mgrs_grid": "54SUE81505010"}, (-5.5, 49_099.5, 0)),
    ("54SUE8150050100", (81_500, 50_100, 0), {"mgrs_grid": "54SUE8150050100"}, (-0.5, -0.5, 0)),
    ("54SUE, offset 81655.73, 50137.43, 42.5", (81_655.73, 50_137.43, 42.5),
     {"mgrs_grid": "54SUE", "offset": {"x": 81_655.73, "y": 50_137.43, "z": 42.5}}, (0.23, -0.07, 42.5)),
    ("54SUE, offset 81655.99, 50137.01, 42.5", (81_655.99, 50_137.01, 42.5),
     {"mgrs_grid": "54SUE", "offset": {"x": 81_655.99, "y": 50_137.01, "z": 42.5}}, (0.49, -0.49, 42.5)),
    ("lat_lon of the same place, altitude 42.5", (81_655.99, 50_137.01, 42.5), {"lat_lon": dict(
        zip(("longitude", "latitude"), corner(81_655.99, 50_137.01)), altitude=42.5)}, (0.0, 0.0, 42.5)),
):
    seen = begin(x, y, z, config)
    print("%-41s a lane that begins there begins at x, y, z = %8.2f, %8.2f, %5.2f" % (name + ":", *seen))
    so &= all(abs(one - other) < 0.02 for one, other in zip(seen, expected))
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   54SUE815501:                              a lane that begins there begins at x, y, z =   -50.50, 40099.50,  0.00
#   54SUE81505010:                            a lane that begins there begins at x, y, z =    -5.50, 49099.50,  0.00
#   54SUE8150050100:                          a lane that begins there begins at x, y, z =    -0.50,    -0.50,  0.00
#   54SUE, offset 81655.73, 50137.43, 42.5:   a lane that begins there begins at x, y, z =     0.23,    -0.07, 42.50
#   54SUE, offset 81655.99, 50137.01, 42.5:   a lane that begins there begins at x, y, z =     0.49,    -0.49, 42.50
#   lat_lon of the same place, altitude 42.5: a lane that begins there begins at x, y, z =     0.00,     0.00, 42.50
