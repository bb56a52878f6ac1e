#!/usr/bin/env python3
"""What the C++ Lanelet2 library and PROJ make of places: JSON tasks on stdin, JSON answers on stdout.

A task: {"by": "lanelet2" | "proj", "kind": one of Autoware's projector types, "origin": [lat, lon], "places": [[lat, lon, ele], ...]}.
Its answer: [[x, y], ...] in metres; null where the library is not here.
"""
import json
import math
import sys

import numpy

try:
    import lanelet2.projection
    from lanelet2.core import GPSPoint
    from lanelet2.io import Origin
except ImportError:
    lanelet2 = None
try:
    import pyproj
except ImportError:
    pyproj = None

# The scale factor of map_projector_info.yaml is a 32-bit float in Autoware.
SCALE = float(numpy.float32(0.9996))
SQUARE = 100_000.0


def zone_of(lat, lon):
    """UTM's zone with the exceptions of Norway and Svalbard."""
    if 56 <= lat < 64 and 3 <= lon < 12:
        return 32
    if 72 <= lat <= 84 and 0 <= lon < 42:
        return 31 if lon < 9 else 33 if lon < 21 else 35 if lon < 33 else 37
    return int((lon + 180) // 6) % 60 + 1


def in_square(x, y):
    return [math.fmod(x, SQUARE), math.fmod(y, SQUARE)]


def by_lanelet2(task):
    kind, (lat, lon) = task["kind"], task["origin"]
    point = lambda place: GPSPoint(*place)
    if kind == "MGRS":
        made = {}

        def forward(place):
            key = (zone_of(*place[:2]), place[0] >= 0)
            if key not in made:
                made[key] = lanelet2.projection.UtmProjector(Origin(place[0], place[1]), False, False)
            there = made[key].forward(point(place))
            return in_square(there.x, there.y)

        return [forward(place) for place in task["places"]]
    if kind == "LocalCartesianUTM":
        projector = lanelet2.projection.UtmProjector(Origin(lat, lon), True, False)
    elif kind == "LocalCartesian":
        projector = lanelet2.projection.LocalCartesianProjector(Origin(lat, lon, 0.0))
    else:
        return None
    there = [projector.forward(point(place)) for place in task["places"]]
    return [[p.x, p.y] for p in there]


def by_proj(task):
    kind, (lat, lon) = task["kind"], task["origin"]
    places = task["places"]
    lats, lons, eles = (numpy.array(column) for column in zip(*places))
    if kind == "MGRS":
        zones = numpy.array([zone_of(*place[:2]) for place in places])
        x, y = numpy.empty(len(places)), numpy.empty(len(places))
        for zone in sorted(set(zones)):
            for south in (False, True):
                here = (zones == zone) & ((lats < 0) == south)
                if here.any():
                    plane = pyproj.Proj(proj="utm", zone=int(zone), ellps="WGS84", south=south)
                    x[here], y[here] = plane(lons[here], lats[here])
        return [in_square(*there) for there in zip(x, y)]
    if kind == "LocalCartesian":
        pipeline = pyproj.Transformer.from_pipeline(
            "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84 "
            f"+step +proj=topocentric +ellps=WGS84 +lon_0={lon} +lat_0={lat} +h_0=0"
        )
        x, y, _ = pipeline.transform(lons, lats, eles)
        return [list(there) for there in zip(x, y)]
    if kind == "LocalCartesianUTM":
        plane = pyproj.Proj(proj="utm", zone=zone_of(lat, lon), ellps="WGS84")
    else:
        plane = pyproj.Proj(proj="tmerc", lon_0=lon, k=SCALE, ellps="WGS84")
    (x, y), (x0, y0) = plane(lons, lats), plane(lon, lat)
    return [list(there) for there in zip(x - x0, y - y0)]


def answer(task):
    if task["by"] == "lanelet2":
        return by_lanelet2(task) if lanelet2 else None
    return by_proj(task) if pyproj else None


json.dump([answer(task) for task in json.load(sys.stdin)], sys.stdout)
