#!/bin/sh
# Lanelet2 1.2.3: one tag that shuts out lorries shuts out everybody, and a ban on cars beside a permission for vehicles does nothing.
#
# One would guess: `participant:vehicle:truck=no` on a road closes it to lorries, and cars go on driving there. And of
#   `participant:vehicle=yes` with `participant:vehicle:car=no` the more exact tag decides, so cars stay out.
# What happens: as soon as any tag that begins with `participant:` stands on a lanelet, the defaults of its subtype are gone, and who
#   is not named may not enter: the road is closed to cars, too, and drops out of their routing graph. A named group hides its members,
#   in both directions: `vehicle=yes` lets the banned car in, `vehicle=no` keeps the permitted car out. `designated` counts as `no`.
# Source: lanelet2_traffic_rules, GenericTrafficRules.cpp (canPass, and the override that it looks up), release 1.2.3.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check lanelet2==1.2.3
cat >"$place/run.py" <<'END'
from lanelet2 import traffic_rules
from lanelet2.core import AttributeMap, Lanelet, LineString3d, Point3d

def road(**participants):
    line = lambda ids, y: LineString3d(ids[0], [Point3d(ids[1], 0, y, 0), Point3d(ids[2], 20, y, 0)])
    tags = AttributeMap()
    for key, value in {"type": "lanelet", "subtype": "road", "location": "urban", **participants}.items():
        tags[key] = value
    return Lanelet(9, line((1, 2, 3), 3), line((4, 5, 6), 0), tags)

cases = [
    ({}, True),
    ({"participant:vehicle:truck": "no"}, False),
    ({"participant:pedestrian": "no"}, False),
    ({"participant:vehicle": "yes", "participant:vehicle:car": "no"}, True),
    ({"participant:vehicle": "no", "participant:vehicle:car": "yes"}, False),
    ({"participant:vehicle": "designated"}, False),
]
car = traffic_rules.create(traffic_rules.Locations.Germany, "vehicle:car")
seen = [(tags, car.canPass(road(**tags))) for tags, _ in cases]
for tags, passes in seen:
    print("a car may drive here: %-5s  %s" % (passes, tags or "no participant tag"))
raise SystemExit(0 if seen == cases else 1)
END
"$place/env/bin/python" "$place/run.py"
# Seen:
#   a car may drive here: True   no participant tag
#   a car may drive here: False  {'participant:vehicle:truck': 'no'}
#   a car may drive here: False  {'participant:pedestrian': 'no'}
#   a car may drive here: True   {'participant:vehicle': 'yes', 'participant:vehicle:car': 'no'}
#   a car may drive here: False  {'participant:vehicle': 'no', 'participant:vehicle:car': 'yes'}
#   a car may drive here: False  {'participant:vehicle': 'designated'}
