#!/bin/sh
# py123d 0.7.0 (123D): where OpenDRIVE says that there is no line, a dashed white one is painted; so it is for a kerb, grass, and a solid blue line.
# And a line that turns from solid to dashed does so at the wrong end of the road, if it belongs to the lanes of positive ids.
#
# One would guess: `<roadMark type="none">` gives no line, or `RoadLineType.NONE`, which means just that ("No painted line is present"); what
#   the table of types does not know gives `UNKNOWN`. `sOffset` counts from the start of the lane section, on either side of the road.
# What happens: "none" is turned into "dashed" on purpose (a note asks whether that is right), and everything unknown, a kerb between
#   two lanes among it, is `DASHED_WHITE`: a line that anybody may cross. Lines of positive lanes are turned around first, to
#   run with the traffic, and then measured from their new beginning: of 200 m, solid up to 150 m, the last 150 m come out
#   solid. The centre line suffers the same, for it is taken from the lanes of positive ids if there are any. Negative lanes are right.
# Source: py123d/parser/opendrive/opendrive_map_parser.py (_map_road_mark_to_type, _iter_road_lines), lane_helper.py (np.flip) and
#   datatypes/map_objects/map_layer_types.py (RoadLineType), release 0.7.0; ASAM OpenDRIVE 1.8, road markings.
# Exits 0 while it is so, 1 if that changes, 2 if it cannot be installed. Needs CPython 3.10 to 3.13 on Linux. Of its dependencies
# py123d gets those that maps need.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
{ python3 -m venv "$place/env" && "$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --no-deps --only-binary :all: \
  py123d==0.7.0 numpy==2.2.6 scipy==1.15.3 shapely==2.1.2 pyquaternion==0.9.9 trimesh==5.2.0 \
  typing-extensions==4.15.0 networkx==3.4.2; } ||
  { echo "py123d 0.7.0 cannot be installed here: it needs CPython 3.10 to 3.13 on Linux and PyPI" >&2; exit 2; }
cat >"$place/run.py" <<'END'
import importlib.metadata
import math
import pathlib
import sys

from py123d.parser.opendrive.opendrive_map_parser import OpenDriveMapParser


def lanes(marks):
    """Two lanes of 3.5 m for each direction; marks (sOffset, type, colour) between them and on the centre line."""
    painted = "".join(f'<roadMark sOffset="{s}" type="{kind}" weight="standard" color="{colour}" width="0.12"/>' for s, kind, colour in marks)

    def lane(number):
        return (f'<lane id="{number}" type="driving" level="false"><link><predecessor id="{number}"/><successor id="{number}"/></link>'
                f'<width sOffset="0" a="3.5" b="0" c="0" d="0"/>{painted if abs(number) == 1 else ""}</lane>')
    return (f'<laneSection s="0"><left>{lane(2)}{lane(1)}</left><center><lane id="0" type="none" level="false">{painted}</lane></center>'
            f'<right>{lane(-1)}{lane(-2)}</right></laneSection>')


def ring(path, marks):
    """A ring road, since the parser leaves out lanes that lead nowhere. Its first piece, 200 m to the east, has the marks."""
    half, roads = math.pi * 50, ""
    for number, (x, y, heading, length, curvature) in enumerate([
            (0, 0, 0, 200, 0), (200, 0, 0, half, 1 / 50), (200, 100, math.pi, 200, 0), (0, 100, math.pi, half, 1 / 50)]):
        shape = f'<arc curvature="{curvature}"/>' if curvature else "<line/>"
        roads += (
            f'<road name="" length="{length}" id="{number}" junction="-1"><link>'
            f'<predecessor elementType="road" elementId="{(number - 1) % 4}" contactPoint="end"/>'
            f'<successor elementType="road" elementId="{(number + 1) % 4}" contactPoint="start"/></link>'
            f'<planView><geometry s="0" x="{x}" y="{y}" hdg="{heading}" length="{length}">{shape}</geometry></planView>'
            '<elevationProfile><elevation s="0" a="0" b="0" c="0" d="0"/></elevationProfile><lateralProfile/>'
            f'<lanes><laneOffset s="0" a="0" b="0" c="0" d="0"/>{lanes([] if number else marks)}</lanes></road>')
    path.write_text('<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="7" name="" version="1" date="" north="0" south="0" east="0" '
                    f'west="0" vendor=""/>{roads}</OpenDRIVE>')


def lines(marks):
    """The lines of the map: y, smaller and greater x, type."""
    path = pathlib.Path(sys.argv[1]) / "ring.xodr"
    ring(path, marks)
    return sorted(
        (round(float(item.polyline.array[0][1]), 1), *sorted(round(float(item.polyline.array[end][0])) for end in (0, -1)), item.road_line_type.name)
        for item in OpenDriveMapParser(path).iter_map_objects() if type(item).__name__ == "RoadLine")


print("py123d", importlib.metadata.version("py123d"))
so = True
for kind, colour, wrong in [("solid", "white", "SOLID_WHITE"), ("broken", "yellow", "DASHED_YELLOW"), ("none", "standard", "DASHED_WHITE"),
                            ("curb", "standard", "DASHED_WHITE"), ("grass", "standard", "DASHED_WHITE"), ("solid", "blue", "DASHED_WHITE")]:
    found = lines([(0, kind, colour)])
    print(f"{kind}, {colour}:", sorted({line[3] for line in found}), "on", len(found), "lines")
    so &= found == [(y, 0, 200, wrong) for y in (-3.5, 0, 3.5)]
so &= lines([]) == []
print("solid up to x = 150, then broken:")
found = lines([(0, "solid", "white"), (150, "broken", "white")])
for y, start, end, kind in found:
    print(f"  y = {y}: {kind} from x = {start} to {end}")
so &= found == [(-3.5, 0, 150, "SOLID_WHITE"), (-3.5, 150, 200, "DASHED_WHITE"), (0.0, 0, 50, "DASHED_WHITE"), (0.0, 50, 200, "SOLID_WHITE"),
                (3.5, 0, 50, "DASHED_WHITE"), (3.5, 50, 200, "SOLID_WHITE")]
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   py123d 0.7.0
#   solid, white: ['SOLID_WHITE'] on 3 lines
#   broken, yellow: ['DASHED_YELLOW'] on 3 lines
#   none, standard: ['DASHED_WHITE'] on 3 lines
#   curb, standard: ['DASHED_WHITE'] on 3 lines
#   grass, standard: ['DASHED_WHITE'] on 3 lines
#   solid, blue: ['DASHED_WHITE'] on 3 lines
#   solid up to x = 150, then broken:
#     y = -3.5: SOLID_WHITE from x = 0 to 150
#     y = -3.5: DASHED_WHITE from x = 150 to 200
#     y = 0.0: DASHED_WHITE from x = 0 to 50
#     y = 0.0: SOLID_WHITE from x = 50 to 200
#     y = 3.5: DASHED_WHITE from x = 0 to 50
#     y = 3.5: SOLID_WHITE from x = 50 to 200
