#!/bin/sh
# MetaDrive 0.4.3, from a network of SUMO: where one drives on the left, the dashed line between two lanes lies on the kerb, and the centre
# line of a street with two lanes each way is not there.
#
# One would guess: a network with `lefthand="true"` is the mirror image of a right-hand one, lines and all; the lanes are read at their right places.
# What happens: the line between a lane and the next is drawn on the left of the lane, since in right-hand traffic the next lane is there. With
#   `lefthand`, SUMO counts the lanes of an edge from the left, and the next is on the right. So the dashed line that belongs between the lanes
#   is drawn on the outer edge of the street, nothing is drawn between the lanes, and the edges of the two directions, which should meet
#   in the centre, are taken from between the lanes and do not meet: no yellow line. Who reads the lines finds none between
#   the kerbs, 12.8 m apart, and kerbs that look as if they may be crossed. With one lane each way the lines are right.
# Source: metadrive-simulator 0.4.3, metadrive/utils/sumo/map_utils.py (_compute_traffic_dividers), as SumoMapManager uses it; netconvert of
#   eclipse-sumo 1.28.0, option --lefthand.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.11 or newer on Linux. Of its dependencies MetaDrive gets those that maps need, and
#   its two outer packages are entered without their __init__.py, which would load the graphics.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
get() {
  "$place/env/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: "$@"
}
get sumolib==1.28.0 eclipse-sumo==1.28.0 numpy==2.4.6 scipy==1.17.1 shapely==2.2.0
get --no-deps metadrive-simulator==0.4.3
cat >"$place/run.py" <<'END'
import importlib.metadata
import subprocess
import sys
import types
from importlib.metadata import version

root = importlib.metadata.distribution("metadrive-simulator").locate_file("metadrive")
for name, folder in (("metadrive", root), ("metadrive.utils", root / "utils")):
    sys.modules[name] = types.ModuleType(name)
    sys.modules[name].__path__ = [str(folder)]
from metadrive.utils.sumo.map_utils import RoadLaneJunctionGraph, extract_map_features  # noqa: E402

place = sys.argv[1]


def street(lanes, *options):
    """Middles of the lanes and places of the lines, by their y, in a street from west to east with its centre at y = 0."""
    with open(place + "/s.nod.xml", "w") as file:
        file.write('<nodes><node id="w" x="0" y="0"/><node id="e" x="200" y="0"/></nodes>')
    with open(place + "/s.edg.xml", "w") as file:
        file.write(f'<edges><edge id="east" from="w" to="e" numLanes="{lanes}" speed="14"/>'
                   f'<edge id="west" from="e" to="w" numLanes="{lanes}" speed="14"/></edges>')
    subprocess.run([place + "/env/bin/netconvert", "-n", place + "/s.nod.xml", "-e", place + "/s.edg.xml", "-o", place + "/s.net.xml",
                    "--offset.disable-normalization", "--no-turnarounds", *options], check=True, stdout=subprocess.DEVNULL)
    middles, dashed, yellow = [], [], []
    for feature in extract_map_features(RoadLaneJunctionGraph(place + "/s.net.xml")).values():
        y = sum(point[1] for point in feature["polyline"]) / len(feature["polyline"])
        which = {"LANE_SURFACE_STREET": middles, "ROAD_LINE_BROKEN_SINGLE_WHITE": dashed, "ROAD_LINE_SOLID_SINGLE_YELLOW": yellow}
        which[feature["type"]].append(round(float(y), 1) + 0.0)
    return sorted(middles), sorted(dashed), sorted(yellow)


print("metadrive", version("metadrive-simulator"), "- netconvert", version("eclipse-sumo"))
good = True
for name, lanes, options, expected in [
    ("right-hand, two lanes each way", 2, [], ([-4.8, -1.6, 1.6, 4.8], [-3.2, 3.2], [0.0])),
    ("left-hand, two lanes each way", 2, ["--lefthand"], ([-4.8, -1.6, 1.6, 4.8], [-6.4, 6.4], [])),
    ("right-hand, one lane each way", 1, [], ([-1.6, 1.6], [], [0.0])),
    ("left-hand, one lane each way", 1, ["--lefthand"], ([-1.6, 1.6], [], [0.0])),
]:
    middles, dashed, yellow = street(lanes, *options)
    print(f"{name}: lanes at {middles}, dashed lines at {dashed}, yellow lines at {yellow}")
    good &= (middles, dashed, yellow) == expected
raise SystemExit(0 if good else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
