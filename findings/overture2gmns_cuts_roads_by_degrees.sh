#!/bin/sh
# overture2gmns 0.2.1: in Helsinki, the 50 km/h that Overture Maps gives a road up to its corner end 251 m before the corner, and so does the
# link: its node is the crossing at the corner, its geometry never gets there.
#
# One would guess: the positions of Overture (`at`, `between`) are shares of the length in metres, measured on WGS 84; the documentation
#   says so, and warns of distances in degrees. The converter measures the lengths of links in just this way, with pyproj's Geod.
# What happens: the road is cut at shares of its length in degrees, where a metre to the east counts twice as much as a metre to the north
#   (at 60 degrees). The first half of a road, 1 km to the east, comes out as 749 m, the second half, 1 km to the north, as 1251 m.
#   Limits, access and lengths, and so travel times, are off. Of nodes that have a connector the place is right, so
#   that links begin and end beside their nodes; without the file of connectors the node lies wrong as well, and the side street is
#   hung up there. Near the equator, and on roads that are straight, all is right. With connectors there is no word of it.
# Source: overture2gmns/converter.py (shapely's `substring` and `interpolate` with `normalized=True`), release 0.2.1;
#   docs.overturemaps.org, guides, transportation, linear referencing ("not planar distance on raw lon/lat coordinates").
# Exits 0 while it is so, 1 if that changes, 2 if it cannot be installed. Needs CPython 3.11 to 3.13.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
{ python3 -m venv "$place/env" && "$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --only-binary :all: \
  overture2gmns==0.2.1 pyproj==3.7.2 shapely==2.1.2 numpy==2.2.6; } ||
  { echo "overture2gmns 0.2.1 cannot be installed here: it needs PyPI, and CPython 3.11 to 3.13 for the wheels of its dependencies" >&2; exit 2; }
cat >"$place/run.py" <<'END'
import importlib.metadata
import json
import pathlib
import sys

import overture2gmns
from pyproj import Geod
from shapely import wkt

place = pathlib.Path(sys.argv[1])
globe = Geod(ellps="WGS84")


def write(name, features):
    (place / name).write_text(json.dumps({"type": "FeatureCollection", "features": [
        {"type": "Feature", "id": properties["id"], "geometry": {"type": kind, "coordinates": where}, "properties": properties}
        for kind, where, properties in features]}))


def segment(name, points, connectors, **rules):
    return ("LineString", points, {"id": name, "subtype": "road", "class": "secondary", **rules,
                                   "connectors": [{"connector_id": key, "at": at} for key, at in connectors]})


def limit(speed, *between):
    return {"max_speed": {"value": speed, "unit": "km/h"}, "between": between}


def convert(latitude, turn, connectors=True):
    """A road of 1 km to the east and 1 km in the direction `turn`; halfway a side street leaves. Rows of links, along their segments."""
    start = (24.94, latitude)
    corner = globe.fwd(*start, 90, 1000)[:2]
    end = globe.fwd(*corner, turn, 1000)[:2]
    side = globe.fwd(*corner, 180, 500)[:2]
    middle = globe.line_length(*zip(start, corner)) / globe.line_length(*zip(start, corner, end))
    assert abs(middle - 0.5) < 1e-6
    write("segments.geojson", [
        segment("road", [start, corner, end], [("a", 0), ("b", 0.5), ("c", 1)], speed_limits=[limit(50, 0, 0.5), limit(30, 0.5, 1)]),
        segment("side", [corner, side], [("b", 0), ("d", 1)])])
    write("connectors.geojson", [("Point", where, {"id": key}) for key, where in zip("abcd", (start, corner, end, side))])
    network = overture2gmns.getNetFromFile(place / "segments.geojson", place / "connectors.geojson" if connectors else None)
    rows = []
    for link in network.links.values():
        if link.dir_flag == 1:
            line = wkt.loads(link.geometry)
            gaps = [round(globe.inv(network.nodes[node].x_coord, network.nodes[node].y_coord, *line.coords[index])[2])
                    for node, index in ((link.from_node_id, 0), (link.to_node_id, -1))]
            rows.append((link.overture_segment_id, round(link.free_speed * 1.609344), round(link.length * 1609.344), *gaps))
    return rows, network.diagnostics.get("connector_coordinate_conflicts", 0)


print("overture2gmns", importlib.metadata.version("overture2gmns"))
right = [("road", 50, 1000, 0, 0), ("road", 30, 1000, 0, 0), ("side", 56, 500, 0, 0)]
helsinki = [("road", 50, 749, 0, 251), ("road", 30, 1251, 251, 0), ("side", 56, 500, 0, 0)]
alone = [("road", 50, 749, 0, 0), ("road", 30, 1251, 0, 0), ("side", 56, 500, 251, 0)]
so = True
for title, arguments, rows, conflicts in [
        ("on the equator", (0, 0), right, 0), ("Helsinki, straight on", (60.17, 90), right, 0),
        ("Helsinki, around the corner", (60.17, 0), helsinki, 0), ("the same without connectors", (60.17, 0, False), alone, 1)]:
    found, said = convert(*arguments)
    print(title + f": {said} conflicts counted")
    for row in found:
        print("  %s, %d km/h: %d m; begins %d m from its first node, ends %d m from its last" % row)
    near = len(found) == len(rows) and all(a[:2] == b[:2] and max(abs(x - y) for x, y in zip(a[2:], b[2:])) <= 4 for a, b in zip(found, rows))
    so &= near and said == conflicts
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   overture2gmns 0.2.1
#   on the equator: 0 conflicts counted
#     road, 50 km/h: 1003 m; begins 0 m from its first node, ends 3 m from its last
#     road, 30 km/h: 997 m; begins 3 m from its first node, ends 0 m from its last
#     side, 56 km/h: 500 m; begins 0 m from its first node, ends 0 m from its last
#   Helsinki, straight on: 0 conflicts counted
#     road, 50 km/h: 1000 m; begins 0 m from its first node, ends 0 m from its last
#     road, 30 km/h: 1000 m; begins 0 m from its first node, ends 0 m from its last
#     side, 56 km/h: 500 m; begins 0 m from its first node, ends 0 m from its last
#   Helsinki, around the corner: 0 conflicts counted
#     road, 50 km/h: 749 m; begins 0 m from its first node, ends 251 m from its last
#     road, 30 km/h: 1251 m; begins 251 m from its first node, ends 0 m from its last
#     side, 56 km/h: 500 m; begins 0 m from its first node, ends 0 m from its last
#   the same without connectors: 1 conflicts counted
#     road, 50 km/h: 749 m; begins 0 m from its first node, ends 0 m from its last
#     road, 30 km/h: 1251 m; begins 0 m from its first node, ends 0 m from its last
#     side, 56 km/h: 500 m; begins 251 m from its first node, ends 0 m from its last
