#!/bin/sh
# A lanelet deleted in JOSM is back after pyosmium 4.3.2 has copied the map; GDAL and osm2geojson draw it all along.
#
# One would guess: what was deleted and saved is no longer in the file; or every reader of `.osm` knows the mark that JOSM leaves there.
# What happens: JOSM keeps a deleted object that has a version in the file, whole, with `action="delete"` and still `visible="true"`, for the
#   upload to come. Lanelet2 leaves it out. libosmium (pyosmium, the osmium tool), GDAL and osm2geojson do not know the attribute and
#   take the object for a living one; `osmium.FileProcessor` gives `deleted` as False. A copy through pyosmium loses the mark, so that
#   Lanelet2, too, drives on the deleted lanelet.
# Source: OSM wiki, JOSM file format; lanelet2_io/src/OsmFile.cpp (isDeleted); the wheels of PyPI below.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check \
    lanelet2==1.2.3 osmium==4.3.2 osm2geojson==0.3.2 pyogrio==0.13.0 numpy
# Two lanelets side by side as JOSM saves them; the one to the south, 22, and its outer line were deleted.
cat >"$place/map.osm" <<'END'
<?xml version="1.0" encoding="UTF-8"?>
<osm version="0.6" generator="JOSM">
  <node id="1" version="1" visible="true" lat="49.00004" lon="8.000"/><node id="2" version="1" visible="true" lat="49.00004" lon="8.001"/>
  <node id="3" version="1" visible="true" lat="49.00000" lon="8.000"/><node id="4" version="1" visible="true" lat="49.00000" lon="8.001"/>
  <node id="5" version="1" visible="true" lat="48.99996" lon="8.000" action="delete"/>
  <node id="6" version="1" visible="true" lat="48.99996" lon="8.001" action="delete"/>
  <way id="11" version="1" visible="true"><nd ref="1"/><nd ref="2"/><tag k="type" v="line_thin"/></way>
  <way id="12" version="1" visible="true"><nd ref="3"/><nd ref="4"/><tag k="type" v="line_thin"/></way>
  <way id="13" version="1" visible="true" action="delete"><nd ref="5"/><nd ref="6"/><tag k="type" v="line_thin"/></way>
  <relation id="21" version="1" visible="true">
    <member type="way" ref="11" role="left"/><member type="way" ref="12" role="right"/>
    <tag k="type" v="lanelet"/><tag k="subtype" v="road"/>
  </relation>
  <relation id="22" version="1" visible="true" action="delete">
    <member type="way" ref="12" role="left"/><member type="way" ref="13" role="right"/>
    <tag k="type" v="lanelet"/><tag k="subtype" v="road"/>
  </relation>
</osm>
END
cat >"$place/run.py" <<'END'
import sys
import osm2geojson, osmium, pyogrio
from lanelet2.io import Origin, load
from lanelet2.projection import UtmProjector

source, copy = sys.argv[1:]


def lanelets(file):
    return sorted(lane.id for lane in load(file, UtmProjector(Origin(49, 8))).laneletLayer)


with osmium.SimpleWriter(copy) as writer:
    for thing in osmium.FileProcessor(source):
        writer.add(thing)
features = [feature["properties"] for feature in osm2geojson.xml2geojson(open(source).read())["features"]]
ways = {
    "pyosmium": [way.id for way in osmium.FileProcessor(source, osmium.osm.WAY) if not way.deleted],
    "GDAL": [int(way) for way in pyogrio.raw.read(source, layer="lines", columns=["osm_id"])[3][0]],
    "osm2geojson": sorted(thing["id"] for thing in features if thing["type"] == "way"),
    "lanelet2": sorted(line.id for line in load(source, UtmProjector(Origin(49, 8))).lineStringLayer),
}
for tool, seen in ways.items():
    print("ways that %s sees: %s" % (tool, seen))
print("lanelets that lanelet2 sees: %s, in pyosmium's copy: %s" % (lanelets(source), lanelets(copy)))
alive = all(seen == [11, 12, 13] for tool, seen in ways.items() if tool != "lanelet2")
raise SystemExit(0 if alive and ways["lanelet2"] == [11, 12] and (lanelets(source), lanelets(copy)) == ([21], [21, 22]) else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/map.osm" "$place/copy.osm"
# Seen:
#   ways that pyosmium sees: [11, 12, 13]
#   ways that GDAL sees: [11, 12, 13]
#   ways that osm2geojson sees: [11, 12, 13]
#   ways that lanelet2 sees: [11, 12]
#   lanelets that lanelet2 sees: [21], in pyosmium's copy: [21, 22]
