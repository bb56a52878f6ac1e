#!/bin/sh
# Valhalla 3.9.1: a bollard stops cars; a concrete barrier, a fence or a heap of rubble across the street stops nobody.
#
# One would guess: the more a barrier keeps out, the fewer get past it. Valhalla's own list of tags says so: a bollard is for those on foot
#   and by bicycle, `jersey_barrier`, `barrier_board`, `fence`, `wall` and `debris` are for nobody, unless the node names somebody.
# What happens: the list gives such nodes an access of zero, but only nodes of a few kinds (gate, bollard, sump buster, toll booth…) cut a
#   street in two. Any other node in the midst of a way stays a point of its shape, and its access is forgotten, also an explicit
#   `motor_vehicle=no` or `access=no`. If the mapper has cut the way at the very same node, it counts. `jersey_barrier` was
#   a kind of bollard until pull request 5217 made it stricter.
# Source: valhalla, lua/graph.lua (nodes_proc) and src/mjolnir/pbfgraphparser.cc (node tags), release 3.9.1; OSM wiki, Key:barrier.
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
cases = {  # tags of the barrier, and who gets past it: within one way, and where two ways meet
    "barrier=bollard": ("pedestrian", "pedestrian"),
    "barrier=jersey_barrier": ("auto pedestrian", ""),
    "barrier=barrier_board": ("auto pedestrian", ""),
    "barrier=fence": ("auto pedestrian", ""),
    "barrier=debris": ("auto pedestrian", ""),
    "barrier=planter motor_vehicle=no": ("auto pedestrian", "pedestrian"),
    "barrier=stile access=no": ("auto pedestrian", ""),
}
nodes, ways, streets = "", "", []
for tags in cases:
    for cut in (False, True):  # streets to the east, 10 km apart
        number, latitude = len(streets) * 10, 40 + 0.1 * len(streets)
        streets.append((tags, latitude))
        tagged = "".join('<tag k="%s" v="%s"/>' % tuple(tag.split("=")) for tag in tags.split())
        for at in range(1, 4):
            nodes += f'<node id="{number + at}" version="1" lat="{latitude:.1f}" lon="{8 + at / 1000}">{tagged if at == 2 else ""}</node>'
        for at, part in enumerate([(1, 2), (2, 3)] if cut else [(1, 2, 3)]):
            refs = "".join(f'<nd ref="{number + node}"/>' for node in part)
            ways += f'<way id="{number + at + 1}" version="1">{refs}<tag k="highway" v="residential"/></way>'
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
    ends = [{"lat": latitude, "lon": longitude} for longitude in (8.0012, 8.0028)]
    try:
        actor.route({"locations": ends, "costing": who})
    except valhalla.ValhallaError as error:
        if "No path" not in str(error):
            raise
        return False
    return True


found = {}
for tags, latitude in streets:
    found.setdefault(tags, []).append(" ".join(who for who in ("auto", "pedestrian") if passes(latitude, who)))
for tags, (within, between) in found.items():
    print("%-33s in the midst of a way: %-16s where two ways meet: %s" % (tags, within or "nobody", between or "nobody"))
raise SystemExit(0 if found == {tags: list(each) for tags, each in cases.items()} else 1)
END
PYTHONPATH="$place/packages" python3 "$place/run.py" "$place"
# Seen:
#   barrier=bollard                   in the midst of a way: pedestrian       where two ways meet: pedestrian
#   barrier=jersey_barrier            in the midst of a way: auto pedestrian  where two ways meet: nobody
#   barrier=barrier_board             in the midst of a way: auto pedestrian  where two ways meet: nobody
#   barrier=fence                     in the midst of a way: auto pedestrian  where two ways meet: nobody
#   barrier=debris                    in the midst of a way: auto pedestrian  where two ways meet: nobody
#   barrier=planter motor_vehicle=no  in the midst of a way: auto pedestrian  where two ways meet: pedestrian
#   barrier=stile access=no           in the midst of a way: auto pedestrian  where two ways meet: nobody
