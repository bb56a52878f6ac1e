#!/bin/sh
# imap-box-up 0.0.6, from OpenDRIVE to Apollo, asked for heights: each straight part of a road lies at 0 m, and each curve begins at the
# height of the road's beginning; a road that climbs steadily has four steps of up to 9 m.
#
# One would guess: with the option for the z axis, a point has the height that `<elevation>` gives for its place along the road; of how many
#   straights and curves the reference line is made does not matter.
# What happens: a straight is computed in the plane and gets 0 m, whatever the profile says. A curve asks the profile for the height at its
#   distance from its own beginning, not from that of the road. A road that climbs by 5 % from 5 m has 0 m on its first straight,
#   starts its first curve at 5 m in place of 10 m, and ends at 0 m in place of 25 m. Only a road that is a single
#   curve is right. The bounds and the start position of each lane have the same heights. There is no warning.
# Source: imap/lib/opendrive/plan_view.py (Geometry.sampling, Arc.sampling), release 0.0.6; ASAM OpenDRIVE 1.8, road elevation
#   ("s-coordinate of start position" along the reference line of the road), and plan view.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.11 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --no-deps --only-binary :all: \
  imap-box-up==0.0.6 record-msg==0.1.1 protobuf==3.19.4 numpy==1.26.4 scipy==1.13.0 pyproj==3.7.2 certifi==2025.10.5 concave-hull==0.0.7 \
  matplotlib==3.11.2 packaging==25.0 cycler==0.12.1 kiwisolver==1.5.1 pyparsing==3.3.3 python-dateutil==2.9.0 six==1.17.0 contourpy==1.3.3 \
  fonttools==4.68.0 pillow==13.0.0
cat >"$place/run.py" <<'END'
import math
import pathlib
import subprocess
import sys

from modules.map.proto import map_pb2

place = pathlib.Path(sys.argv[1])
QUARTER = math.pi * 25  # a quarter of a circle of 50 m radius, in metres
SIDE = '<roadMark sOffset="0" type="solid" color="white" width="0.12"/>'
LANE = '<lane id="-1" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/>%s</lane>' % SIDE


def convert(pieces):
    """The line and the heights of the middle of a lane along a road; the road begins at 5 m and climbs by 5 %."""
    s, plan = 0.0, ""
    for x, y, heading, length, curvature in pieces:
        shape = '<arc curvature="%s"/>' % curvature if curvature else "<line/>"
        plan += '<geometry s="%.9f" x="%s" y="%s" hdg="%.9f" length="%.9f">%s</geometry>' % (s, x, y, heading, length, shape)
        s += length
    (place / "road.xodr").write_text(f"""<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="6" name="hill" version="1" date="2026-01-01T00:00:00" north="0" south="0" east="0" west="0">
    <geoReference><![CDATA[+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs]]></geoReference>
  </header>
  <road name="hill" length="{s:.9f}" id="1" junction="-1" rule="RHT"><link/><planView>{plan}</planView>
    <elevationProfile><elevation s="0" a="5" b="0.05" c="0" d="0"/></elevationProfile>
    <lanes><laneSection s="0"><center><lane id="0" type="none" level="false">{SIDE}</lane></center><right>{LANE}</right></laneSection></lanes>
  </road>
</OpenDRIVE>
""")
    subprocess.run([sys.executable, "-c", "from imap.main import main; main()", "-f", "-z", "True",
                    "-i", place / "road.xodr", "-o", place / "map.txt"], check=True, capture_output=True, env={"MPLBACKEND": "agg", "MPLCONFIGDIR": str(place)})
    city = map_pb2.Map()
    city.ParseFromString((place / "map.bin").read_bytes())
    return city.lane[0].central_curve.segment[0].line_segment.point


roads = {
    "one curve": [(0, 0, 0, QUARTER, 0.02)],
    "one straight of 400 m": [(0, 0, 0, 400, 0)],
    "straight, curve, straight, curve, straight": [
        (0, 0, 0, 100, 0), (100, 0, 0, QUARTER, 0.02), (150, 50, math.pi / 2, 100, 0), (150, 150, math.pi / 2, QUARTER, -0.02), (200, 200, 0, 50, 0)],
}
seen = {}
for name, pieces in roads.items():
    points = convert(pieces)
    ends = []  # heights where a piece begins and ends
    first = 0
    for _, _, _, length, _ in pieces:
        last = first + math.ceil(length)  # the tool puts a point at each metre, and one at the end of each piece
        ends.append((round(points[first].z, 1), round(points[last].z, 1)))
        first = last + 1
    assert first == len(points)
    seen[name] = ends
    s, meant = 0.0, []
    for _, _, _, length, _ in pieces:
        meant.append((round(5 + s * 0.05, 1), round(5 + (s + length) * 0.05, 1)))
        s += length
    for title, heights in (("meant", meant), ("imap", ends)):
        print("%-44s %-5s %s" % (name + ":", title, ", ".join("%.1f to %.1f" % pair for pair in heights)))
expected = {
    "one curve": [(5.0, 8.9)],
    "one straight of 400 m": [(0.0, 0.0)],
    "straight, curve, straight, curve, straight": [(0.0, 0.0), (5.0, 8.9), (0.0, 0.0), (5.0, 8.9), (0.0, 0.0)],
}
raise SystemExit(0 if seen == expected else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   one curve:                                   meant 5.0 to 8.9
#   one curve:                                   imap  5.0 to 8.9
#   one straight of 400 m:                       meant 5.0 to 25.0
#   one straight of 400 m:                       imap  0.0 to 0.0
#   straight, curve, straight, curve, straight:  meant 5.0 to 10.0, 10.0 to 13.9, 13.9 to 18.9, 18.9 to 22.9, 22.9 to 25.4
#   straight, curve, straight, curve, straight:  imap  0.0 to 0.0, 5.0 to 8.9, 0.0 to 0.0, 5.0 to 8.9, 0.0 to 0.0
