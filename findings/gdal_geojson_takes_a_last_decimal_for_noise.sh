#!/bin/sh
# GDAL 3.x writes GeoJSON with 7 decimals, but some points in Asia, Australia and America move by up to 8 cm: 139.7000009 becomes 139.7.
#
# One would guess: 7 decimals (the default of GeoJSONSeq and of RFC7946=YES, or COORDINATE_PRECISION=7) are rounded to the nearest, so that
#   no coordinate changes by more than half of the last decimal, 0.6 cm on the ground.
# What happens: a last digit behind five zeros or five nines is taken for noise of binary numbers and dropped, if the number has more than
#   ten characters, point and sign included. So it hits longitudes from 100 degrees east and from 10 degrees west on: where one happens
#   to be 139.7000009, it is written as 139.7, nine units of its last decimal away. 99.7000009 stays what it is, and so does a latitude
#   of 35.5000009. Without the options, or with 9 decimals, nothing moves.
# Source: GDAL, ogr/ogrutils.cpp, OGRFormatDouble; here through the wheel of pyogrio, which brings GDAL.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check pyogrio==0.13.0 numpy
cat >"$place/run.py" <<'END'
import json
import sys
from pathlib import Path

import pyogrio

folder = Path(sys.argv[1])
longitudes = [139.7000009, 139.6999991, -122.4000009, 139.7100009, 139.7654321, 8.4000009, 99.7000009, -99.7000009]
point = lambda lon: {"type": "Feature", "properties": {}, "geometry": {"type": "Point", "coordinates": [lon, 35.5000009]}}
(folder / "in.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [point(lon) for lon in longitudes]}))
meta, _, geometry, fields = pyogrio.raw.read(folder / "in.geojson")

def moved(driver, **options):
    """Longitudes and latitudes that were written elsewhere, in units of the seventh decimal."""
    out = folder / f"out{len(list(folder.iterdir()))}"
    pyogrio.raw.write(out, geometry, fields, meta["fields"], driver=driver, geometry_type="Point", crs="EPSG:4326", layer_options=options)
    text = out.read_text()
    features = json.loads(text)["features"] if driver == "GeoJSON" else map(json.loads, text.replace("\x1e", "").splitlines())
    pairs = zip(longitudes, [one["geometry"]["coordinates"] for one in features])
    far = {before: round((after[0] - before) * 1e7) for before, after in pairs}
    return {before: units for before, units in far.items() if units}

print("GDAL", ".".join(map(str, pyogrio.__gdal_version__)))
expected = {139.7000009: -9, 139.6999991: 9, -122.4000009: 9, -99.7000009: 9}
cases = {
    "GeoJSONSeq": (moved("GeoJSONSeq"), expected),
    "GeoJSON, RFC7946=YES": (moved("GeoJSON", RFC7946="YES"), expected),
    "GeoJSON, COORDINATE_PRECISION=7": (moved("GeoJSON", COORDINATE_PRECISION="7"), expected),
    "GeoJSON, COORDINATE_PRECISION=9": (moved("GeoJSON", COORDINATE_PRECISION="9"), {}),
    "GeoJSON": (moved("GeoJSON"), {}),
}
for name, (found, _) in cases.items():
    print(f"{name}: moved {found}")
raise SystemExit(0 if all(found == wanted for found, wanted in cases.values()) else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
