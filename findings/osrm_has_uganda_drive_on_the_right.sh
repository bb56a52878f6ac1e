#!/bin/sh
# OSRM 26.10.0 looks up by place on which side one drives, and has all of Uganda drive on the right; Kiribati, Niue and St Helena as well.
#
# One would guess: the index, which is new and on by default, may be in doubt near borders, but has no country as a whole on the wrong side,
#   least of all one that is on the left in the file which one had to pass by hand before (`data/driving_side.geojson`, still part of
#   the same source archive).
# What happens: Nairobi drives on the left, Kampala, Gulu and Mbarara on the right, as Kigali does, where it is true. `driving_side` of each
#   step, the costs of turns and `approaches=curb` are mirrored. In Kampala the turn to the right, across the oncoming traffic, is the
#   cheap one; and to a house on the left, 780 m ahead, one drives 1.2 km, to stand on the other side of the street.
#   A way out: the tag `driving_side` on ways, or `--location-dependent-data` with polygons.
# Source: osrm-backend 26.10.0, docs/profiles.md (driving side) and data/driving_side.geojson; pull request 7725, which brought the index;
#   the wheel of osrm-bindings.
# Exits 0 while it is so, 1 if that changes, 2 if it cannot be installed. Needs CPython 3.12 or newer on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
# The newest Python that is new enough.
fits() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 12))' 2>/dev/null; }
for python in python3.14 python3.13 python3.12 python3; do if fits "$python"; then break; fi; done
{ "$python" -m venv "$place/env" && "$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --no-deps --only-binary :all: \
  osrm-bindings==26.10.0; } || { echo "osrm-bindings 26.10.0 cannot be installed here: it needs CPython 3.12 or newer on Linux and PyPI" >&2; exit 2; }
cat >"$place/run.py" <<'END'
import importlib.metadata
import json
import pathlib
import subprocess
import sys

import osrm

place = pathlib.Path(sys.argv[1])
home = pathlib.Path(osrm.__file__).parent
towns = {  # latitude, longitude, side on which one drives, side that OSRM says
    "Nairobi": (-1.2864, 36.8172, "left", "left"), "Kampala": (0.3136, 32.5811, "left", "right"), "Gulu": (2.7746, 32.2990, "left", "right"),
    "Mbarara": (-0.6072, 30.6545, "left", "right"), "Tarawa, Kiribati": (1.3291, 172.9790, "left", "right"),
    "Alofi, Niue": (-19.0554, -169.9187, "left", "right"), "Jamestown, St Helena": (-15.9244, -5.7181, "left", "right"),
    "Kigali": (-1.9441, 30.0619, "right", "right")}
step = 0.001  # of a degree, about 111 m

# In each town a street to the east, 1.1 km long, with a side street to the north and one to the south at its middle.
nodes = ways = ""
for town, (latitude, longitude, _, _) in enumerate(towns.values(), 1):
    for number, (east, north) in enumerate([(0, 0), (5, 0), (10, 0), (5, 3), (5, -3)]):
        nodes += f'<node id="{town * 10 + number}" version="1" lat="{latitude + north * step:.6f}" lon="{longitude + east * step:.6f}"/>'
    for number, refs in enumerate([(0, 1, 2), (1, 3), (1, 4)]):
        ways += (f'<way id="{town * 10 + number}" version="1">' + "".join(f'<nd ref="{town * 10 + ref}"/>' for ref in refs)
                 + '<tag k="highway" v="secondary"/></way>')
(place / "towns.osm").write_text(f'<?xml version="1.0"?><osm version="0.6" generator="by hand">{nodes}{ways}</osm>')


def build(*options):
    for program, *arguments in [("extract", "-p", home / "share/profiles/car.lua", *options, place / "towns.osm"),
                                ("partition", place / "towns.osrm"), ("customize", place / "towns.osrm")]:
        subprocess.run([home / "bin" / f"osrm-{program}", *arguments], check=True, capture_output=True)
    return osrm.OSRM(storage_config=str(place / "towns.osrm"), use_shared_memory=False, algorithm="MLD")


def route(engine, town, *points, **options):
    latitude, longitude = towns[town][:2]
    return engine.Route(osrm.RouteParameters(
        coordinates=[(longitude + east * step, latitude + north * step) for east, north in points], steps=True, **options))["routes"][0]


def driving(engine, town):
    """The side, what a turn to the right costs more than one to the left, and the way to a house to the left of the street, at the kerb."""
    left, right = route(engine, town, (1, 0), (5, 2)), route(engine, town, (1, 0), (5, -2))
    house = route(engine, town, (1, 0.1), (8, 0.1), approaches=["unrestricted", "curb"])
    return left["legs"][0]["steps"][0]["driving_side"], round(right["duration"] - left["duration"], 1), round(house["distance"], -1)


print("osrm-bindings", importlib.metadata.version("osrm-bindings"))
so = True
engine = build()
for town, (_, _, really, expected) in towns.items():
    side, more, far = driving(engine, town)
    print(f"{town}: {side}, really {really}; a turn to the right costs {more:+} s against one to the left; to the house on the left {far:.0f} m")
    so &= side == expected and (more > 3 and far < 800 if side == "left" else more < -3 and far > 1100)
ring = [[32, 0], [33, 0], [33, 1], [32, 1], [32, 0]]
(place / "left.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"driving_side": "left"}, "geometry": {"type": "Polygon", "coordinates": [ring]}}]}))
side, more, far = driving(build("--location-dependent-data", place / "left.geojson"), "Kampala")
print(f"Kampala, told by a polygon: {side}; {more:+} s; {far:.0f} m")
so &= side == "left" and more > 3 and far < 800
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   osrm-bindings 26.10.0
#   Nairobi: left, really left; a turn to the right costs +5.2 s against one to the left; to the house on the left 780 m
#   Kampala: right, really left; a turn to the right costs -5.2 s against one to the left; to the house on the left 1220 m
#   Gulu: right, really left; a turn to the right costs -5.2 s against one to the left; to the house on the left 1220 m
#   Mbarara: right, really left; a turn to the right costs -5.2 s against one to the left; to the house on the left 1220 m
#   Tarawa, Kiribati: right, really left; a turn to the right costs -5.2 s against one to the left; to the house on the left 1220 m
#   Alofi, Niue: right, really left; a turn to the right costs -5.2 s against one to the left; to the house on the left 1160 m
#   Jamestown, St Helena: right, really left; a turn to the right costs -5.2 s against one to the left; to the house on the left 1180 m
#   Kigali: right, really right; a turn to the right costs -5.2 s against one to the left; to the house on the left 1220 m
#   Kampala, told by a polygon: left; +5.2 s; 780 m
