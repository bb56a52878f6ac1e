#!/bin/sh
# imap-box-up 0.0.6, from OpenDRIVE to Apollo: a map with its origin in Helsinki is turned by 1.8 degrees, so that 5 km away it lies 156 m
# beside itself; the same UTM zone under another name lies 500 km further east.
#
# One would guess: the file's `geoReference` is a transverse Mercator of its own, the Apollo map is in UTM as its header says, and each point is
#   brought from the one to the other; or else the file is refused.
# What happens: only the place of `+lat_0` and `+lon_0` is computed in UTM, and is added to all coordinates. The grids' norths
#   differ by the convergence, (longitude - middle of the zone) x sin(latitude); so the map turns around its origin, which is right,
#   and scale factors are lost. On the zone's middle meridian nothing shows. `+x_0` and `+y_0` are not read:
#   UTM zone 33 written out, as `+proj=tmerc +lat_0=0 +lon_0=15 +k=0.9996 +x_0=500000`, counts its 500 km twice. With
#   `+proj=utm +zone=33` the file is right. There is no warning in any case.
# Source: imap/lib/convertor.py (convert_proj_txt), release 0.0.6; ASAM OpenDRIVE 1.8, geo referencing ("PROJ" string of the map's coordinates);
#   PROJ documentation, transverse Mercator (x_0, y_0, k) and UTM. The places to compare with are computed by PROJ.
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

import pyproj
from modules.map.proto import map_pb2

place = pathlib.Path(sys.argv[1])
SIDE = '<roadMark sOffset="0" type="solid" color="white" width="0.12"/>'


def off(text, x, y, heading):
    """How far the end of a road of 5 km is from its place, in metres; the road begins at (x, y)."""
    (place / "road.xodr").write_text(f"""<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="6" name="road" version="1" date="2026-01-01T00:00:00" north="0" south="0" east="0" west="0">
    <geoReference><![CDATA[{text}]]></geoReference>
  </header>
  <road name="road" length="5000" id="1" junction="-1" rule="RHT"><link/>
    <planView><geometry s="0" x="{x}" y="{y}" hdg="{heading}" length="5000"><line/></geometry></planView>
    <lanes><laneSection s="0"><center><lane id="0" type="none" level="false">{SIDE}</lane></center>
      <right><lane id="-1" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/>{SIDE}</lane></right></laneSection></lanes>
  </road>
</OpenDRIVE>
""")
    subprocess.run([sys.executable, "-c", "from imap.main import main; main()", "-f", "-s", "50", "-i", place / "road.xodr", "-o", place / "map.txt"],
                   check=True, capture_output=True, env={"MPLBACKEND": "agg", "MPLCONFIGDIR": str(place)})
    city = map_pb2.Map()
    city.ParseFromString((place / "map.bin").read_bytes())
    line = city.lane[0].left_boundary.curve.segment[0].line_segment.point  # of the lane -1: the reference line itself
    move = pyproj.Transformer.from_crs(text, city.header.projection.proj, only_best=True)
    meant = [move.transform(x + s * math.cos(heading), y + s * math.sin(heading)) for s in (0, 5000)]
    return [math.dist((point.x, point.y), there) for point, there in zip((line[0], line[-1]), meant)]


north, east = math.pi / 2, 0.0
local = "+proj=tmerc +lat_0=%s +lon_0=%s +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"
so = True
for name, text, x, y, heading, expected in (
    ("Helsinki, to the north", local % (60.17, 24.94), 0, 0, north, (0, 156)),
    ("Helsinki, to the east", local % (60.17, 24.94), 0, 0, east, (0, 156)),
    ("Oslo, to the north", local % (59.91, 10.75), 0, 0, north, (0, 132)),
    ("on the zone's middle meridian", local % (60.17, 27), 0, 0, north, (0, 2)),
    ("Berlin, UTM zone 33 by number", "+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs", 390000, 5820000, north, (0, 0)),
    ("Berlin, UTM zone 33 written out", "+proj=tmerc +lat_0=0 +lon_0=15 +k=0.9996 +x_0=500000 +y_0=0 +datum=WGS84 +units=m +no_defs",
     390000, 5820000, north, (500000, 500000)),
):
    seen = tuple(round(distance) for distance in off(text, x, y, heading))
    so &= seen == expected
    print("%-32s begins %d m off, ends %d m off" % (name + ":", *seen))
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   Helsinki, to the north:          begins 0 m off, ends 156 m off
#   Helsinki, to the east:           begins 0 m off, ends 156 m off
#   Oslo, to the north:              begins 0 m off, ends 132 m off
#   on the zone's middle meridian:   begins 0 m off, ends 2 m off
#   Berlin, UTM zone 33 by number:   begins 0 m off, ends 0 m off
#   Berlin, UTM zone 33 written out: begins 500000 m off, ends 500000 m off
