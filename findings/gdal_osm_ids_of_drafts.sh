#!/bin/sh
# GDAL 3.x cannot read OSM files whose node ids are negative, unsorted or large, though JOSM and Lanelet2 tools write just those.
#
# One would guess: an id is a 64-bit number, and its order in the file does not matter: JOSM gives new objects negative ids, Lanelet2 maps
#   drawn by hand keep them, and generated maps use ids above 2^47.
# What happens: the OSM driver keeps node places in an index that takes 0 <= id < 65,536 x (2^31 - 1) = 140,737,488,289,792, rising in the
#   file. Opening works and lists all layers; reading features stops at the first other id. With the open option or configuration
#   OSM_USE_CUSTOM_INDEXING=NO the same file is read.
# Source: GDAL, ogr/ogrsf_frmts/osm; here through the wheel of pyogrio, which brings GDAL.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check pyogrio==0.13.0 numpy
cat >"$place/run.py" <<'END'
import sys
import pyogrio

def features(first, second):
    with open(sys.argv[1], "w") as file:
        file.write(f"""<?xml version="1.0"?>
<osm version="0.6" generator="by hand">
  <node id="{first}" lat="49.0" lon="8.0" version="1"/><node id="{second}" lat="49.001" lon="8.0" version="1"/>
  <way id="3" version="1"><nd ref="{first}"/><nd ref="{second}"/><tag k="highway" v="residential"/></way>
</osm>""")
    try:
        return len(pyogrio.raw.read(sys.argv[1], layer="lines")[2])
    except Exception as error:
        return str(error)

limit = 65536 * (2**31 - 1)
print("GDAL", ".".join(map(str, pyogrio.__gdal_version__)))
cases = {(1, 2): True, (limit - 2, limit - 1): True, (limit - 1, limit): False, (-1, -2): False, (2, 1): False}
seen = {ids: features(*ids) for ids in cases}
for ids, count in seen.items():
    print(ids, "->", count)
pyogrio.set_gdal_config_options({"OSM_USE_CUSTOM_INDEXING": "NO"})
without = features(limit, limit + 1)
print("without the index:", without)
raise SystemExit(0 if {ids: count == 1 for ids, count in seen.items()} == cases and without == 1 else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/in.osm"
