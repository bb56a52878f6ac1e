#!/bin/sh
# CommonRoad Scenario Designer 0.8.5 makes of a lane 3.5 m wide one of 5.3 m at 49 degrees north, and of 7 m in Helsinki.
#
# One would guess: CommonRoad's scenarios are in metres, vehicles drive in them in metres per second; so a converted map has the sizes of
#   its source, all the more an OpenDRIVE file, which is in metres already and has its projection in the header.
# What happens: `lanelet_to_commonroad` and `opendrive_to_commonroad` go to EPSG:3857, the projection of web maps, which is drawn larger by
#   1/cos(latitude). Widths, lengths and radii grow, speed limits and vehicles do not: a lane has room for two cars, each way takes
#   half as long again, curves are wider. The conversion back divides by the same factor, so that a round trip shows nothing. An
#   OpenDRIVE file without `geoReference` keeps its size. A way out: set `general_config.proj_string_cr` to a UTM zone before.
# Source: crdesigner/common/config/general_config.py (proj_string_cr) and gui_config.py (pseudo_mercator), release 0.8.5.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 to 3.12 on Linux; installs 1.2 GB for a while.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile commonroad-scenario-designer==0.8.5 commonroad-io==2024.3
cat >"$place/run.py" <<'END'
import sys
import numpy
from crdesigner.common.config.general_config import general_config
from crdesigner.map_conversion.map_conversion_interface import lanelet_to_commonroad, opendrive_to_commonroad
from pyproj import Transformer

osm, xodr = sys.argv[1:]


def size(scenario):
    lane = scenario.lanelet_network.lanelets[0]
    return "%.2f m x %.1f m" % (numpy.linalg.norm(lane.left_vertices[0] - lane.right_vertices[0]), lane.distance[-1])


def tmerc(latitude):
    return f"+proj=tmerc +lat_0={latitude} +lon_0=8 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m"


def lanelet2(latitude):
    """A lanelet 3.5 m wide and 100 m long."""
    degrees = Transformer.from_crs(tmerc(latitude), "EPSG:4326", always_xy=True)
    corners = [degrees.transform(x, y) for y in (1.75, -1.75) for x in (0, 100)]
    nodes = "".join(f'<node id="{i + 1}" lat="{lat:.11f}" lon="{lon:.11f}"/>' for i, (lon, lat) in enumerate(corners))
    with open(osm, "w") as file:
        file.write(f"""<?xml version="1.0"?><osm version="0.6" generator="by hand">{nodes}
  <way id="11"><nd ref="1"/><nd ref="2"/><tag k="type" v="line_thin"/><tag k="subtype" v="solid"/></way>
  <way id="12"><nd ref="3"/><nd ref="4"/><tag k="type" v="line_thin"/><tag k="subtype" v="solid"/></way>
  <relation id="21"><member type="way" ref="11" role="left"/><member type="way" ref="12" role="right"/>
    <tag k="type" v="lanelet"/><tag k="subtype" v="road"/><tag k="location" v="urban"/><tag k="one_way" v="yes"/></relation>
</osm>""")
    return size(lanelet_to_commonroad(osm))


def opendrive(header):
    """A road of one lane of the same size."""
    with open(xodr, "w") as file:
        file.write(f"""<?xml version="1.0"?>
<OpenDRIVE><header revMajor="1" revMinor="4" name="" version="1" date="" north="0" south="0" east="0" west="0">{header}</header>
<road id="1" name="" length="100" junction="-1"><link/><type s="0" type="town"/>
  <planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView><elevationProfile/><lateralProfile/>
  <lanes><laneSection s="0"><center><lane id="0" type="none" level="false"/></center><right>
    <lane id="-1" type="driving" level="false"><link/><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>
  </right></laneSection></lanes></road></OpenDRIVE>""")
    return size(opendrive_to_commonroad(xodr))


reference = f"<geoReference><![CDATA[{tmerc(49)}]]></geoReference>"
seen = {
    "Lanelet2 at the equator": lanelet2(0),
    "Lanelet2 at 49 degrees": lanelet2(49),
    "Lanelet2 at 60.2 degrees": lanelet2(60.2),
    "OpenDRIVE at 49 degrees": opendrive(reference),
    "OpenDRIVE of no place": opendrive(""),
}
general_config.proj_string_cr = "EPSG:32632"
seen["Lanelet2 at 49 degrees, proj_string_cr = EPSG:32632"] = lanelet2(49)
for source, made in seen.items():
    print("%-52s 3.50 m x 100.0 m -> %s" % (source, made))
expected = ["3.52 m x 100.0 m", "5.34 m x 152.1 m", "7.04 m x 200.7 m", "5.34 m x 152.1 m", "3.50 m x 100.0 m", "3.50 m x 100.0 m"]
raise SystemExit(0 if list(seen.values()) == expected else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/map.osm" "$place/road.xodr" 2>"$place/log" || { code=$?; tail -3 "$place/log" >&2; exit $code; }
# Seen:
#   Lanelet2 at the equator                              3.50 m x 100.0 m -> 3.52 m x 100.0 m
#   Lanelet2 at 49 degrees                               3.50 m x 100.0 m -> 5.34 m x 152.1 m
#   Lanelet2 at 60.2 degrees                             3.50 m x 100.0 m -> 7.04 m x 200.7 m
#   OpenDRIVE at 49 degrees                              3.50 m x 100.0 m -> 5.34 m x 152.1 m
#   OpenDRIVE of no place                                3.50 m x 100.0 m -> 3.50 m x 100.0 m
#   Lanelet2 at 49 degrees, proj_string_cr = EPSG:32632  3.50 m x 100.0 m -> 3.50 m x 100.0 m
