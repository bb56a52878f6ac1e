#!/bin/sh
# asam-qc-opendrive 1.0.0, ASAM's own checker of OpenDRIVE: a road without a gap is torn, a road with a gap of 3.5 m is fine, and two pieces of a
# line that lie 20 m apart are one too many.
#
# One would guess: its rule `contact_point_no_horizontal_gaps` compares where linked lanes end and begin. A lane that is added on the left moves the
#   centre lane: `<laneOffset>` jumps from 0 to 3.5 where the section begins, lane -1 goes on as -2, and its borders stay where they are.
# What happens: at the seam of two lane sections both sides are computed with the offset that holds behind the seam. So the lane that
#   goes straight on has a gap, and an error; a lane -1 that really jumps aside by 3.5 m has none. Offsets that do not jump are right.
#   And the pieces of a reference line are compared only if there are three or more: a road of two pieces, 20 m apart, gets no error
#   but the advice that the second line is redundant. The same gap in a road of three pieces is found.
# Source: qc_opendrive/checks/smoothness/lane_smoothness_contact_point_no_horizontal_gaps.py (_check_road_lane_sections_gaps;
#   `len(geometries) > 2` in _check_roads_internal_smoothness), as installed; ASAM OpenDRIVE 1.8, 11.4 lane offset and annex D.1.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 or 3.11 on Linux, for which pyclothoids has wheels.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile asam-qc-opendrive==1.0.0 asam-qc-baselib==1.1.0
cat >"$place/run.py" <<'END'
import pathlib
import subprocess
import sys
import xml.etree.ElementTree as ET

place = pathlib.Path(sys.argv[1])
MARK = '<roadMark sOffset="0" type="solid" color="standard" width="0.12"/>'
RULES = {
    "check_asam_xodr_lane_smoothness_contact_point_no_horizontal_gaps": "gap",
    "check_asam_xodr_performance_avoid_redundant_info": "redundant",
}


def lane(number, **links):
    link = "".join('<%s id="%d"/>' % one for one in links.items())
    return '<lane id="%d" type="driving" level="false">%s<width sOffset="0" a="3.5" b="0" c="0" d="0"/>%s</lane>' % (
        number, "<link>%s</link>" % link if link else "", MARK)


def section(s, *lanes):
    return '<laneSection s="%d"><center><lane id="0" type="none" level="false">%s</lane></center><right>%s</right></laneSection>' % (
        s, MARK, "".join(lanes))


def straight(*pieces):
    """Pieces of a reference line to the east, each (s, x, y, length)."""
    return "".join('<geometry s="%d" x="%d" y="%d" hdg="0" length="%d"><line/></geometry>' % piece for piece in pieces)


def offsets(*steps):
    return "".join('<laneOffset s="%d" a="%s" b="0" c="0" d="0"/>' % step for step in steps)


def check(line, lanes):
    """What the checker finds in a road of 100 m."""
    (place / "road.xodr").write_text(f"""<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="7" name="road" version="1" date="2026-01-01T00:00:00" north="0" south="0" east="0" west="0"/>
  <road name="east" length="100" id="1" junction="-1" rule="RHT"><planView>{line}</planView><lanes>{lanes}</lanes></road>
</OpenDRIVE>
""")
    (place / "config.xml").write_text(
        f'<Config><Param name="InputFile" value="{place}/road.xodr"/><CheckerBundle application="xodrBundle">'
        f'<Param name="resultFile" value="{place}/result.xqar"/></CheckerBundle></Config>')
    subprocess.run([place / "env/bin/qc_opendrive", "-c", place / "config.xml"], check=True, capture_output=True)
    checkers = list(ET.parse(place / "result.xqar").getroot().iter("Checker"))
    ran = {one.get("checkerId") for one in checkers if one.get("status") == "completed"}
    assert set(RULES) <= ran, ran
    return sorted((RULES[one.get("checkerId")], issue.get("description")) for one in checkers for issue in one.iter("Issue"))


one_line = straight((0, 0, 0, 100))
one_lane = section(0, lane(-1))
so = True
for name, line, lanes, expected in (
    ("lane -1 goes on as -1, no offset", one_line, section(0, lane(-1, successor=-1)) + section(50, lane(-1, predecessor=-1)), []),
    ("a lane is added on the left, lane -1 goes straight on as -2", one_line,
     offsets((0, 0), (50, 3.5)) + section(0, lane(-1, successor=-2)) + section(50, lane(-1), lane(-2, predecessor=-1)), ["gap"]),
    ("lane -1 jumps 3.5 m to the left", one_line,
     offsets((0, 0), (50, 3.5)) + section(0, lane(-1, successor=-1)) + section(50, lane(-1, predecessor=-1)), []),
    ("line of two pieces, 20 m apart", straight((0, 0, 0, 50), (50, 50, 20, 50)), one_lane, ["redundant"]),
    ("line of three pieces, the last two 20 m apart", straight((0, 0, 0, 25), (25, 25, 0, 25), (50, 50, 20, 50)), one_lane,
     ["gap", "redundant", "redundant"]),
):
    found = check(line, lanes)
    print("%s:" % name, "; ".join(sorted({"%s: %s" % (rule, text.strip()) for rule, text in found})) or "nothing")
    so &= [rule for rule, _ in found] == expected
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place"
# Seen:
#   lane -1 goes on as -1, no offset: nothing
#   a lane is added on the left, lane -1 goes straight on as -2: gap: The transition between lane elements should be defined with no gaps.
#   lane -1 jumps 3.5 m to the left: nothing
#   line of two pieces, 20 m apart: redundant: Redundant line geometry declaration.
#   line of three pieces, the last two 20 m apart: gap: The transition between geometry elements should be defined with no gaps. A gap of 20.0 meters has been found.; redundant: Redundant line geometry declaration.
