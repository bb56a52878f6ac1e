#!/bin/sh
# ndslive-math 1.1.0, of the NDS association: who drives from Munich to the north has a bearing of 180 degrees, and each other course is turned around
# as well.
#
# One would guess: `there.bearing_from(here)` is the course from here to there, clockwise from north: its help says "initial bearing from `other`
#   toward this point", and calls `other` the starting point.
# What happens: the formula has the two points the other way around. The result is the bearing at `there`, back to `here`. On a street that is the
#   opposite course to a hair; over long distances it is not even that, for the way back starts in the direction in which the great
#   circle arrives, so that to add 180 degrees mends it within a city only. Berlin to Tokyo, which is 42 degrees, comes out as -30, and not as -138.
#   The distance is right; headings of links, of vehicles on them, and signs that are matched by their direction, are those of the opposite
#   lane. A way out: `here.bearing_from(there)`, against the help.
# Source: ndslive/math/wgs84.py (bearing_from and its help), release 1.1.0; compared with geographiclib 2.0 on WGS 84.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 or newer.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile ndslive-math==1.1.0 geographiclib==2.0
cat >"$place/run.py" <<'END'
import importlib.metadata
import math

from geographiclib.geodesic import Geodesic
from ndslive.math import Wgs84

ways = {  # longitude, latitude
    "100 m to the north": ((11.575, 48.137), (11.575, 48.1379)),
    "100 m to the east": ((11.575, 48.137), (11.57634, 48.137)),
    "100 m to the south-west": ((11.575, 48.137), (11.57405, 48.13636)),
    "Berlin to Tokyo": ((13.405, 52.52), (139.692, 35.69)),
}
print("ndslive-math", importlib.metadata.version("ndslive-math"))
print(" ", Wgs84.bearing_from.__doc__.splitlines()[0])
so = "from ``other`` toward this point" in Wgs84.bearing_from.__doc__
for name, (start, end) in ways.items():
    here, there = Wgs84(*start), Wgs84(*end)
    wanted = Geodesic.WGS84.Inverse(start[1], start[0], end[1], end[0])
    told = math.degrees(there.bearing_from(here))
    back = math.degrees(here.bearing_from(there))
    print(f"{name}: {here.distance_to(there):.0f} m, course {wanted['azi1']:.1f}; there.bearing_from(here) {told:.1f}, here.bearing_from(there) {back:.1f}")
    # back from the goal to the start
    arrival = wanted["azi2"] + 180
    so &= abs((told - arrival + 180) % 360 - 180) < 0.3 and abs((back - wanted["azi1"] + 180) % 360 - 180) < 0.3
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   ndslive-math 1.1.0
#     Initial bearing (forward azimuth) from ``other`` toward this point.
#   100 m to the north: 100 m, course 0.0; there.bearing_from(here) 180.0, here.bearing_from(there) 0.0
#   100 m to the east: 99 m, course 90.0; there.bearing_from(here) -90.0, here.bearing_from(there) 90.0
#   100 m to the south-west: 100 m, course -135.2; there.bearing_from(here) 44.7, here.bearing_from(there) -135.3
#   Berlin to Tokyo: 8916072 m, course 41.6; there.bearing_from(here) -29.9, here.bearing_from(there) 41.6
