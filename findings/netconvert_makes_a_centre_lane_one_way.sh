#!/bin/sh
# netconvert of SUMO 1.28.0 makes the centre lane of a road a through lane of one direction, although `lanes:forward` and
# `lanes:backward` say that each direction has one lane.
#
# One would guess: with `lanes=3`, `lanes:forward=1`, `lanes:backward=1` and `lanes:both_ways=1` each direction gets the one lane that its
#   own key counts; whether the lane in the middle is left out or given to both, neither direction has two.
# What happens: the edge along the way has two lanes and the edge against it one, without a warning: the total counts, less the lanes
#   against the way. So the lane for turns is a lane of through traffic, and the road has twice the capacity in one direction. Without
#   `lanes` the same tags give one lane each way.
# Source: OpenStreetMap's page of lanes:both_ways; the wheel of 1.28.0.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check eclipse-sumo==1.28.0
cat >"$place/run.py" <<'END'
import os, subprocess, sys, xml.etree.ElementTree as ET
import sumo

place = sys.argv[1]
NETCONVERT = os.path.join(os.path.dirname(sumo.__file__), "bin", "netconvert")


def lanes(tags):
    """The numbers of lanes along the way and against it, and whether a warning names lanes."""
    words = "".join('<tag k="%s" v="%s"/>' % tuple(word.split("=")) for word in tags.split())
    source, net = os.path.join(place, "in.osm"), os.path.join(place, "net.xml")
    with open(source, "w") as file:
        file.write('<osm version="0.6"><node id="1" lat="48" lon="9"/><node id="2" lat="48" lon="9.01"/><way id="7"><nd ref="1"/>'
                   '<nd ref="2"/>%s</way></osm>' % words)
    done = subprocess.run([NETCONVERT, "--osm-files", source, "-o", net, "--no-internal-links"], capture_output=True, text=True, check=True)
    edges = {e.get("id"): len(e.findall("lane")) for e in ET.parse(net).getroot().iter("edge")}
    return edges["7"], edges["-7"], "lane" in done.stderr


each = "highway=secondary lanes:forward=1 lanes:backward=1 lanes:both_ways=1"
with_total, without = lanes(each + " lanes=3"), lanes(each)
print("with lanes=3: %d along, %d against, warned of lanes: %s" % with_total)
print("without lanes: %d along, %d against, warned of lanes: %s" % without)
raise SystemExit(0 if with_total == (2, 1, False) and without[:2] == (1, 1) else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   with lanes=3: 2 along, 1 against, warned of lanes: False
#   without lanes: 1 along, 1 against, warned of lanes: False
