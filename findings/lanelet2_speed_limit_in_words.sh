#!/bin/sh
# Lanelet2 1.2.3: a speed limit in words (`none`, `walk`, `unlimited`) is 0 km/h.
#
# One would guess: `speed_limit=none`, which OpenStreetMap uses on German motorways, means no limit, or is refused as no number.
# What happens: the text is read up to the first character that is no number. Where that is the first, the limit is 0 km/h, mandatory,
#   without an error, also on lanelets of subtype `highway`. `speed_limit:vehicle=none` alone does the same.
#   A unit behind the number is known: `30 mph` and `14 m/s` are converted.
# Source: lanelet2_traffic_rules, GenericTrafficRules.cpp (speedLimit), lanelet2_core, Attribute.cpp (asVelocity), release 1.2.3.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check lanelet2==1.2.3
cat >"$place/run.py" <<'END'
from lanelet2 import traffic_rules
from lanelet2.core import AttributeMap, Lanelet, LineString3d, Point3d

def highway(**limits):
    line = lambda ids, y: LineString3d(ids[0], [Point3d(ids[1], 0, y, 0), Point3d(ids[2], 20, y, 0)])
    tags = AttributeMap()
    for key, value in {"type": "lanelet", "subtype": "highway", "location": "nonurban", **limits}.items():
        tags[key] = value
    return Lanelet(9, line((1, 2, 3), 3), line((4, 5, 6), 0), tags)

cases = [
    ({"speed_limit": "50"}, 50),
    ({"speed_limit": "30 mph"}, 48),
    ({"speed_limit": "14 m/s"}, 50),
    ({"speed_limit": "none"}, 0),
    ({"speed_limit": "walk"}, 0),
    ({"speed_limit:vehicle": "none"}, 0),
]
rules = traffic_rules.create(traffic_rules.Locations.Germany, traffic_rules.Participants.Vehicle)
seen = [(tags, round(rules.speedLimit(highway(**tags)).speedLimit)) for tags, _ in cases]
for tags, limit in seen:
    print("%3d km/h  %s" % (limit, tags))
raise SystemExit(0 if seen == cases else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#    50 km/h  {'speed_limit': '50'}
#    48 km/h  {'speed_limit': '30 mph'}
#    50 km/h  {'speed_limit': '14 m/s'}
#     0 km/h  {'speed_limit': 'none'}
#     0 km/h  {'speed_limit': 'walk'}
#     0 km/h  {'speed_limit:vehicle': 'none'}
