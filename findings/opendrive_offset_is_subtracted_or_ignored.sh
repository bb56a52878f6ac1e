#!/bin/sh
# A street of London that SUMO's netconvert 1.28.0 writes as OpenDRIVE lies 14 km west of itself for CommonRoad Scenario Designer 0.8.5 and 7 km
# west for CARLA 0.9.16; with netconvert's default projection it lies in the South Atlantic and in Catalonia.
#
# One would guess: `<offset>` in the header, part of OpenDRIVE since 1.6, is added to the road's coordinates before the projection is undone.
#   netconvert writes it, since it moves a network to begin at x = 0, y = 0.
# What happens: the Scenario Designer, here on the way to Lanelet2, subtracts the offset, so that a place is wrong by twice the offset, on the
#   other side of the projection's origin; for UTM that is the other side of the equator. CARLA's client does not read it: the corner
#   of the network takes the place of the origin. With a local projection nobody warns.
#   (For UTM, CARLA does warn, and takes 42 degrees north, 2 degrees east.)
# Source: ASAM OpenDRIVE 1.8, geo referencing; crdesigner, opendrive_parser/parser.py (parse_opendrive_road_geometry), release 0.8.5, and issue 18
#   of CommonRoad/commonroad-scenario-designer; carla pull request 9508, which came after release 0.9.16 and reads offsets for UTM only.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 to 3.12 on Linux; installs 1.7 GB for a while.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile \
  commonroad-scenario-designer==0.8.5 commonroad-io==2024.3 eclipse-sumo==1.28.0 carla==0.9.16
cat >"$place/run.py" <<'END'
import os
import pathlib
import re
import subprocess
import sys

import carla
import pyproj
import sumo
from crdesigner.map_conversion.map_conversion_interface import opendrive_to_lanelet

place = pathlib.Path(sys.argv[1])
osm, xodr, lanelet2 = place / "street.osm", place / "street.xodr", place / "lanelet2.osm"
LATITUDE, LONGITUDE = 51.5, -0.1  # where the street begins
osm.write_text(f"""<?xml version="1.0"?>
<osm version="0.6" generator="by hand">
  <node id="1" lat="{LATITUDE}" lon="{LONGITUDE}"/><node id="2" lat="{LATITUDE}" lon="-0.09"/>
  <way id="11"><nd ref="1"/><nd ref="2"/><tag k="highway" v="primary"/><tag k="oneway" v="yes"/><tag k="lanes" v="1"/></way>
</osm>""")


def kilometres(latitude, longitude):
    """How far a place is from the begin of the street."""
    return pyproj.Geod(ellps="WGS84").inv(LONGITUDE, LATITUDE, longitude, latitude)[2] / 1000


def read(*options):
    """The begin of the street by the standard, by the Scenario Designer, and by CARLA."""
    netconvert = os.path.join(os.path.dirname(sumo.__file__), "bin", "netconvert")
    subprocess.run([netconvert, "--osm-files", osm, "--opendrive-output", xodr, *options], check=True, stdout=subprocess.DEVNULL)
    text = xodr.read_text()
    projection = pyproj.Proj(re.search(r"<!\[CDATA\[\s*(.*?)\s*\]\]>", text).group(1))
    x, y = (float(value) for value in re.search(r'<offset x="(.*?)" y="(.*?)"', text).groups())
    start = [float(value) for value in re.search(r'<geometry s="0.0*" x="(.*?)" y="(.*?)"', text).groups()]
    longitude, latitude = projection(start[0] + x, start[1] + y, inverse=True)
    places = {"offset added": (latitude, longitude)}
    opendrive_to_lanelet(xodr, str(lanelet2))
    first = re.search(r'<node [^>]*lat="(.*?)" lon="(.*?)"', lanelet2.read_text()).groups()
    places["Scenario Designer"] = tuple(float(value) for value in first)
    town = carla.Map("street", text)
    seen = town.transform_to_geolocation(town.generate_waypoints(1000.0)[0].transform.location)
    places["CARLA"] = seen.latitude, seen.longitude
    return (x, y), places


so = True
local = "+proj=tmerc +lat_0=51.5 +lon_0=-0.2 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m"
for name, options, expected in (
    ("tmerc from 51.5, -0.2", ["--proj", local], {"offset added": 0.0, "Scenario Designer": 13.9, "CARLA": 6.9}),
    ("UTM, by default", [], {"offset added": 0.0, "Scenario Designer": 11436, "CARLA": 1068}),
):
    offset, places = read(*options)
    print("%s: netconvert writes the offset %.0f, %.0f" % (name, *offset))
    for reader, (latitude, longitude) in places.items():
        far = kilometres(latitude, longitude)
        print("  %-17s begins at %8.4f, %8.4f, %7.1f km off" % (reader, latitude, longitude, far))
        so &= abs(far - expected[reader]) < (0.1 if expected[reader] < 1000 else 10)
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place" 2>"$place/log" || { code=$?; tail -3 "$place/log" >&2; exit $code; }
# Seen:
#   tmerc from 51.5, -0.2: netconvert writes the offset 6944, 5
#     offset added      begins at  51.5000,  -0.1000,     0.0 km off
#     Scenario Designer begins at  51.4999,  -0.3000,    13.9 km off
#     CARLA             begins at  51.5000,  -0.2000,     6.9 km off
#   UTM, by default: netconvert writes the offset 701278, 5709417
#     offset added      begins at  51.5000,  -0.1000,     0.0 km off
#     Scenario Designer begins at -50.2928, -19.9129, 11435.8 km off
#     CARLA             begins at  42.0000,   2.0000,  1068.1 km off
