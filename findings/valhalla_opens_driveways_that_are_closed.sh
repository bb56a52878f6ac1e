#!/bin/sh
# Valhalla 3.9.1: `service=driveway` opens a closed road to cars and lorries; `motor_vehicle=no` beside it counts for nothing.
#
# One would guess: a driveway is a road that leads to a house, and less public than other service roads; `motor_vehicle=no` closes it as
#   any other road. The documentation speaks of driveways as private, and to be avoided.
# What happens: after all tags of access have been read, `service=driveway` sets each kind of traffic to yes, if there is no `access` tag.
#   So it is with driveways of `motor_vehicle=no`, `vehicle=no` or `motorcar=no`, even with a footpath to a door: cars and lorries
#   drive there, and through, where it leads on to the next street. `access=yes` beside it, of all things, makes `motor_vehicle=no`
#   hold again.
# Source: valhalla, lua/graph.lua (ways_proc, "service=driveway means all are routable"), release 3.9.1; OSM wiki, service=driveway, access.
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
kinds = "auto", "truck", "pedestrian"
everybody, on_foot = list(kinds), ["pedestrian"]
cases = {  # tags of the link between two streets, and who may use it: by OSM, by Valhalla
    "highway=service": (everybody, everybody),
    "highway=service motor_vehicle=no": (on_foot, on_foot),
    "highway=service service=alley motor_vehicle=no": (on_foot, on_foot),
    "highway=service service=driveway motor_vehicle=no": (on_foot, everybody),
    "highway=service service=driveway vehicle=no": (on_foot, everybody),
    "highway=service service=driveway motorcar=no": (["truck", "pedestrian"], everybody),
    "highway=service service=driveway access=yes motor_vehicle=no": (on_foot, on_foot),
    "highway=service service=driveway access=no": ([], []),
    "highway=footway": (on_foot, on_foot),
    "highway=footway service=driveway": (on_foot, everybody),
}
nodes, ways = "", ""
for number, tags in enumerate(cases, 1):  # a street, the link and a street, to the east; 10 km from one case to the next
    tagged = "".join('<tag k="%s" v="%s"/>' % tuple(tag.split("=")) for tag in tags.split())
    for at in range(4):
        nodes += f'<node id="{number * 10 + at}" version="1" lat="{40 + number / 10}" lon="{8 + at / 1000}"/>'
    for at, of_way in enumerate(['<tag k="highway" v="residential"/>', tagged, '<tag k="highway" v="residential"/>']):
        refs = f'<nd ref="{number * 10 + at}"/><nd ref="{number * 10 + at + 1}"/>'
        ways += f'<way id="{number * 10 + at}" version="1">{refs}{of_way}</way>'
with open(f"{place}/streets.osm", "w") as file:
    file.write(f'<?xml version="1.0"?><osm version="0.6" generator="by hand">{nodes}{ways}</osm>')

os.mkdir(f"{place}/tiles")
config = valhalla.get_config(tile_extract="", tile_dir=f"{place}/tiles")
with open(f"{place}/config.json", "w") as file:
    json.dump(config, file)
program = os.path.join(os.path.dirname(valhalla.__file__), "bin", "valhalla_build_tiles")
subprocess.run([program, "-c", f"{place}/config.json", f"{place}/streets.osm"], check=True, capture_output=True)
actor = valhalla.Actor(config)


def passes(latitude, who):
    ends = [{"lat": latitude, "lon": longitude} for longitude in (8.0002, 8.0028)]
    try:
        actor.route({"locations": ends, "costing": who})
    except valhalla.ValhallaError as error:
        if "No path" not in str(error):
            raise
        return False
    return True


so = True
for number, (tags, (meant, expected)) in enumerate(cases.items(), 1):
    found = [who for who in kinds if passes(40 + number / 10, who)]
    so &= found == expected
    print("%-61s OSM: %-22s Valhalla: %s" % (tags, " ".join(meant) or "-", " ".join(found) or "-"))
raise SystemExit(0 if so else 1)
END
PYTHONPATH="$place/packages" python3 "$place/run.py" "$place"
# Seen:
#   highway=service                                               OSM: auto truck pedestrian  Valhalla: auto truck pedestrian
#   highway=service motor_vehicle=no                              OSM: pedestrian             Valhalla: pedestrian
#   highway=service service=alley motor_vehicle=no                OSM: pedestrian             Valhalla: pedestrian
#   highway=service service=driveway motor_vehicle=no             OSM: pedestrian             Valhalla: auto truck pedestrian
#   highway=service service=driveway vehicle=no                   OSM: pedestrian             Valhalla: auto truck pedestrian
#   highway=service service=driveway motorcar=no                  OSM: truck pedestrian       Valhalla: auto truck pedestrian
#   highway=service service=driveway access=yes motor_vehicle=no  OSM: pedestrian             Valhalla: pedestrian
#   highway=service service=driveway access=no                    OSM: -                      Valhalla: -
#   highway=footway                                               OSM: pedestrian             Valhalla: pedestrian
#   highway=footway service=driveway                              OSM: pedestrian             Valhalla: auto truck pedestrian
