#!/bin/sh
# pycrg 2.2.0 (ASAM's OpenCRG library 2.0.1): to raise a road surface by 1 m moves it by 5.4 km and turns it by 17 degrees; pyopencrg 0.2.2
# neither moves nor raises it, so that one file lies at two places.
#
# One would guess: a road lies where the file says (start and end in x, y, z, and a heading); `REFLINE_OFFSET_Z = 1` lifts it by 1 m; a section
#   without a line in it changes nothing; and two readers find a point of the road at one place.
# What happens: the reference library applies the section `$ROAD_CRG_MODS` on opening. Without that section it applies defaults of its own:
#   the start of the road goes to x = y = z = 0, with heading 0, and holes at the borders are filled with the last height beside them. With a section
#   of any content, or of none, the defaults are off, and the road is where the file says. So one modifier for the height also moves, turns
#   and opens holes. `pyopencrg.read` applies neither modifiers nor defaults unless it is told `apply_mods=True`: it has the place of
#   the file, without the offset.
#   Who lays such a surface over an OpenDRIVE road or a lanelet map by its coordinates gets them from one of these readers only.
# Source: pycrg 2.2.0, readme, "Loading a file", and the bundled OpenCRG 2.0.1 (crgDataSetModifierSetDefault); pyopencrg 0.2.2, readme (`apply_mods`).
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 to 3.14 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: numpy==2.2.6 pycrg==2.2.0 PyOpenCRG==0.2.2
cat >"$place/run.py" <<'END'
import os
import sys
from importlib.metadata import version

import numpy
import pycrg
import pyopencrg

# 100 m of road, 4 m wide, level across, climbing by 5 %, with a hole at its left border between 50 m and 60 m
across = numpy.linspace(-2.0, 2.0, 9)
heights = numpy.zeros((201, across.size))
heights[100:120, -2:] = numpy.nan
HEADING = 0.3  # radians, 17 degrees


def write(name, mods):
    path = os.path.join(sys.argv[1], name + ".crg")
    pycrg.write(path, heights, 0.5, across, numpy.full(200, HEADING), x0=5000.0, y0=2000.0, z0=30.0, slope=0.05, fmt="LRFI", mods=mods)
    return path


def numbers(*each):
    return tuple(None if value != value else round(float(value), 2) + 0.0 for value in each)


def reference(path):
    """x, y, z of the point 50 m along, and z in the hole, by ASAM's library."""
    with pycrg.RoadSurface.open(path, check=True) as road:
        return numbers(*road.uv_to_xy(50.0, 0.0), road.uv_to_z(50.0, 0.0), road.uv_to_z(55.0, 1.9))


def other(path, **arguments):
    road = pyopencrg.read(path, check="strict", **arguments)
    x, y = road.uv_to_xy(50.0, 0.0)
    return numbers(x, y, road.uv_to_z(50.0, 0.0), road.uv_to_z(55.0, 1.9))


print("pycrg", version("pycrg"), "- pyopencrg", version("pyopencrg"), "- x, y, z at 50 m, z in the hole")
good = True
HERE = (5047.77, 2014.78, 32.5, None)
for name, mods, expected in [
    ("no section", None, [(50.0, 0.0, 2.5, 2.75), HERE, (50.0, 0.0, 2.5, 2.75)]),
    ("empty section", {}, [HERE, HERE, HERE]),
    ("raised by 1 m", {"refline_offset_z": 1.0}, [(5047.77, 2014.78, 33.5, None), HERE, (5047.77, 2014.78, 33.5, None)]),
]:
    path = write(name, mods)
    with open(path) as file:
        section = [line.strip() for line in file if "MODS" in line or "OFFSET" in line.upper()]
    seen = [reference(path), other(path), other(path, apply_mods=True)]
    print(f"{name} {section}: pycrg {seen[0]}, pyopencrg {seen[1]}, pyopencrg with apply_mods {seen[2]}")
    good &= seen == expected
raise SystemExit(0 if good else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
