#!/bin/sh
# Valhalla 3.9.1: `maxspeed=100` with `maxspeed:forward=50` makes 50 km/h of both directions, and the sign to show is 100 for both.
#
# One would guess: what is said of one direction replaces `maxspeed` there, and `maxspeed` goes on for the other one, as the tags mean it
#   and OSRM's profiles read it; the attribute `speed_limit`, by which drivers are warned, is that of the direction.
# What happens: if only one direction has a speed of its own, it is copied to the other one, and `maxspeed` is not looked at. It makes no
#   difference whether the copy is the lower or the higher of the two. On a one-way street a limit against the way makes the one along
#   it void: the default of the class counts (60 km/h here). `speed_limit` is `maxspeed` alone: where each direction has its own
#   limit there is none. Right are `maxspeed` alone, and speeds with both suffixes.
# Source: valhalla, src/mjolnir/pbfgraphparser.cc (forward_tagged_speed) and graphbuilder.cc (speed_limit), release 3.9.1; docs/speeds.md
#   ("posted speed limit"); OSRM, profiles/lib/tags.lua; OSM wiki, Key:maxspeed, driving direction.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.12 or newer with pip.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m pip install --quiet --disable-pip-version-check --root-user-action ignore --no-compile --only-binary :all: \
    --target "$place/packages" pyvalhalla==3.9.1
cat >"$place/run.py" <<'END'
import json, os, subprocess, sys
import valhalla

place = sys.argv[1]
cases = {  # tags, then along the way and against it: speed by OSM, speed and limit by Valhalla (0: none)
    "maxspeed=100": ([100, 100], [100, 100], [100, 100]),
    "maxspeed:forward=50 maxspeed:backward=100": ([50, 100], [50, 100], [0, 0]),
    "maxspeed=100 maxspeed:forward=50": ([50, 100], [50, 50], [100, 100]),
    "maxspeed=50 maxspeed:backward=100": ([50, 100], [100, 100], [50, 50]),
    "maxspeed=100 maxspeed:backward=50 oneway=yes": ([100], [60], [100]),
}
nodes, ways = "", ""
for number, tags in enumerate(cases, 1):  # streets to the east, 10 km apart
    tagged = "".join('<tag k="%s" v="%s"/>' % tuple(tag.split("=")) for tag in tags.split())
    for at in (0, 1):
        nodes += f'<node id="{number * 10 + at}" version="1" lat="{40 + number / 10}" lon="{8 + at / 100}"/>'
    refs = f'<nd ref="{number * 10}"/><nd ref="{number * 10 + 1}"/>'
    ways += f'<way id="{number}" version="1">{refs}<tag k="highway" v="secondary"/>{tagged}</way>'
with open(f"{place}/streets.osm", "w") as file:
    file.write(f'<?xml version="1.0"?><osm version="0.6" generator="by hand">{nodes}{ways}</osm>')

os.mkdir(f"{place}/tiles")
config = valhalla.get_config(tile_extract="", tile_dir=f"{place}/tiles")
with open(f"{place}/config.json", "w") as file:
    json.dump(config, file)
program = os.path.join(os.path.dirname(valhalla.__file__), "bin", "valhalla_build_tiles")
subprocess.run([program, "-c", f"{place}/config.json", f"{place}/streets.osm"], check=True, capture_output=True)
actor = valhalla.Actor(config)

so = True
for number, (tags, (meant, speeds, limits)) in enumerate(cases.items(), 1):
    answer = actor.locate({"locations": [{"lat": 40 + number / 10, "lon": 8.005}], "costing": "auto", "verbose": True})
    edges = sorted(answer[0]["edges"], key=lambda edge: not edge["edge"]["forward"])
    found = [edge["edge"]["speeds"]["default"] for edge in edges]
    signs = [edge["edge_info"]["speed_limit"] for edge in edges]
    so &= found == speeds and signs == limits and all(edge["edge_info"]["way_id"] == number for edge in edges)
    print("%-45s OSM: %-11s Valhalla: %-11s speed_limit: %s" % (tags, meant, found, signs))
raise SystemExit(0 if so else 1)
END
PYTHONPATH="$place/packages" python3 "$place/run.py" "$place"
# Seen:
#   maxspeed=100                                  OSM: [100, 100]  Valhalla: [100, 100]  speed_limit: [100, 100]
#   maxspeed:forward=50 maxspeed:backward=100     OSM: [50, 100]   Valhalla: [50, 100]   speed_limit: [0, 0]
#   maxspeed=100 maxspeed:forward=50              OSM: [50, 100]   Valhalla: [50, 50]    speed_limit: [100, 100]
#   maxspeed=50 maxspeed:backward=100             OSM: [50, 100]   Valhalla: [100, 100]  speed_limit: [50, 50]
#   maxspeed=100 maxspeed:backward=50 oneway=yes  OSM: [100]       Valhalla: [60]        speed_limit: [100]
