#!/bin/sh
# roadgen 0.41.2, from OpenDRIVE to Lanelet2: a road that swings 3.5 m aside around an island runs straight through it; with a lane that gets wider
# anywhere on the road, it goes around the island again. Banking that comes and goes is lost in the same way.
#
# One would guess: the reader takes `<laneOffset>` and `<superelevation>`, or has a line in `read_warnings()` for what it takes less exactly, as it
#   has for many other things; and the Lanelet2 file has the shape that the OpenDRIVE file of the same map has.
# What happens: the bounds of a lane get points where the reference line bends and where a width changes. Where only the lane offset or the banking
#   changes, there are none. A straight of 400 m has two points, one at each end; the offset of 3.5 m between 100 m and 300 m is gone. An offset
#   that begins at 300 m and stays is spread over all 400 m, so the lanes are 2.6 m aside at 300 m. A banking of 5 % between 100 m and
#   300 m is gone as well. `lane_centerline` gives the same; there is no warning, and `issues()` is empty.
#   `export_opendrive` of the same map writes the offset in full, so that the two files of one map are 3.5 m apart.
#   On a bend, where there are points, the same offset is right. So it is on a straight if a lane's width changes there, be it by a centimetre:
#   along the change there is a point each 2 m.
# Source: release 0.41.2 (a compiled wheel; seen from outside). Its readme, "Reading OpenDRIVE back", lists what is read less exactly: widths,
#   heights, types, roofs; lane offsets and banking are not on the list. ASAM OpenDRIVE 1.8, `<laneOffset>` and `<superelevation>`.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.9 or newer on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: roadgen==0.41.2
cat >"$place/run.py" <<'END'
import sys
import xml.etree.ElementTree as xml
from importlib.metadata import version

import roadgen

C, D = 3 * 3.5 / 40**2, -2 * 3.5 / 40**3  # a cubic that leads 3.5 m aside within 40 m


def poly(tag, s, a=0.0, b=0.0, c=0.0, d=0.0, at="s"):
    return f'<{tag} {at}="{s}" a="{a}" b="{b}" c="{c}" d="{d}"/>'


ISLAND = (poly("laneOffset", 0) + poly("laneOffset", 100, 0, 0, C, D) + poly("laneOffset", 140, 3.5)
          + poly("laneOffset", 260, 3.5, 0, -C, -D) + poly("laneOffset", 300))
LATE = poly("laneOffset", 0) + poly("laneOffset", 300, 0, 0, C, D) + poly("laneOffset", 340, 3.5)
BANK = "".join([poly("superelevation", 0), poly("superelevation", 100, 0, 0.001), poly("superelevation", 150, 0.05),
                poly("superelevation", 250, 0.05, -0.001), poly("superelevation", 300)])
FIXED = poly("width", 0, 3.5, at="sOffset")
# wider by 1 cm, from 100 m to 300 m
WIDER = FIXED + poly("width", 100, 3.5, 0.00005, at="sOffset") + poly("width", 300, 3.51, at="sOffset")


def lane(number, width):
    return (f'<lane id="{number}" type="driving" level="false"><link/>{width}'
            '<roadMark sOffset="0" type="solid" weight="standard" color="white" width="0.12"/></lane>')


def read(offset="", bank="", width=FIXED):
    with open(sys.argv[1], "w") as file:
        file.write(f"""<?xml version="1.0"?>
<OpenDRIVE><header revMajor="1" revMinor="7" name="" version="1" date="2025-01-01T00:00:00" north="0" south="0" east="0" west="0" vendor="hand">
<geoReference><![CDATA[+proj=tmerc +lat_0=35 +lon_0=139 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs]]></geoReference></header>
<road name="" length="400" id="1" junction="-1" rule="RHT"><link/><type s="0" type="town"/>
<planView><geometry s="0" x="0" y="0" hdg="0" length="400"><line/></geometry></planView>
<elevationProfile>{poly("elevation", 0, 10)}</elevationProfile><lateralProfile>{bank}</lateralProfile>
<lanes>{offset}<laneSection s="0"><left>{lane(1, FIXED)}</left><center>{lane(0, "")}</center><right>{lane(-1, width)}</right></laneSection></lanes>
<objects/><signals/></road></OpenDRIVE>""")
    world = roadgen.read_opendrive(sys.argv[1])
    told = [each for each in world.read_warnings() if "altitude" not in each]
    return world, told + world.issues()


def edge(world):
    """The right bound of the lane that runs east, in the Lanelet2 file: x, y, height."""
    root = xml.fromstring(world.to_lanelet2_osm())
    tags = {n.get("id"): {t.get("k"): t.get("v") for t in n.iter("tag")} for n in root.iter("node")}
    ways = {w.get("id"): [tags[r.get("ref")] for r in w.iter("nd")] for w in root.iter("way")}
    bounds = [[ways[m.get("ref")] for m in r.iter("member") if m.get("role") == "right"][0] for r in root.iter("relation")]
    lines = [[(float(p["local_x"]), float(p["local_y"]), float(p.get("ele", 0))) for p in bound] for bound in bounds]
    return sorted(min(lines, key=lambda line: line[0][1]))


def at(line, x):
    """y and height of a line where it passes x."""
    for (x0, y0, z0), (x1, y1, z1) in zip(line, line[1:]):
        if x0 <= x <= x1:
            share = (x - x0) / (x1 - x0)
            return round(y0 + share * (y1 - y0), 2), round(z0 + share * (z1 - z0), 2)


print("roadgen", version("roadgen"))
good = True
for name, arguments, place, truth, expected in [
    ("around an island, y at 200 m", {"offset": ISLAND}, 200, (0.0, 10.0), ((-3.5, 10.0), 2)),
    ("same, a lane wider by 1 cm", {"offset": ISLAND, "width": WIDER}, 200, (0.0, 10.0), ((-0.01, 10.0), None)),
    ("3.5 m aside from 300 m on, y at 300 m", {"offset": LATE}, 300, (-3.5, 10.0), ((-0.88, 10.0), 2)),
    ("banked by 5 %, height at 200 m", {"bank": BANK}, 200, (-3.5, 9.83), ((-3.5, 10.0), 2)),
]:
    world, told = read(**arguments)
    line = edge(world)
    seen = at(line, place)
    print(f"{name}: right bound (y, height) {seen}, in OpenDRIVE {truth}; {len(line)} points; warnings: {told}")
    good &= seen == expected[0] and not told and (len(line) == expected[1] if expected[1] else len(line) > 50)
world, _ = read(offset=ISLAND)
offsets = [float(each.get("a")) for each in xml.fromstring(world.to_opendrive_xml()).iter("laneOffset")]
middle = [point[1] for point in world.lane_centerline(world.lane_ids()[0])]
print("offsets in the OpenDRIVE file of the map around the island:", offsets, "- its centre line, y:", middle)
raise SystemExit(0 if good and offsets == [0, 0, 3.5, 3.5, 0] and middle == [-1.75, -1.75] else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/road.xodr"
