#!/bin/sh
# Lanelet2 1.2.3 writes no height for points at exactly 0 m, and forgets Autoware's MetaInfo.
#
# One would guess: a map that the library has read and written again has the same tags; points at height 0 have `ele=0`.
# What happens: `ele` is left out where the height is 0 (0.000000001 is written in full), so that a flat map at height 0 has no heights
#   at all; validators that want `ele` on each node, as Autoware's do, find every one of them missing. `<MetaInfo format_version=…>`,
#   by which Autoware tells formats apart, is gone as well.
# Source: lanelet2_io, OsmHandlerWrite.cpp and OsmFile.cpp, release 1.2.3.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check lanelet2==1.2.3
cat >"$place/in.osm" <<'END'
<?xml version="1.0"?>
<osm version="0.6" generator="by hand">
  <MetaInfo format_version="1" map_version="2"/>
  <node id="1" lat="49.0" lon="8.0"><tag k="ele" v="0"/></node>
  <node id="2" lat="49.0" lon="8.001"><tag k="ele" v="0.000000001"/></node>
  <node id="3" lat="49.0" lon="8.002"><tag k="ele" v="0.0"/></node>
  <way id="4"><nd ref="1"/><nd ref="2"/><nd ref="3"/><tag k="type" v="road_border"/></way>
</osm>
END
cat >"$place/run.py" <<'END'
import re, sys
from lanelet2.io import Origin, load, write
from lanelet2.projection import UtmProjector

projector = UtmProjector(Origin(49, 8))
write(sys.argv[2], load(sys.argv[1], projector), projector)
text = open(sys.argv[2]).read()
print("heights written: %s, MetaInfo: %s" % (re.findall(r'k="ele" v="([^"]*)"', text), "MetaInfo" in text))
raise SystemExit(0 if re.findall(r'k="ele" v="([^"]*)"', text) == ["0.000000001"] and "MetaInfo" not in text else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/in.osm" "$place/out.osm"
# Seen:
#   heights written: ['0.000000001'], MetaInfo: False
