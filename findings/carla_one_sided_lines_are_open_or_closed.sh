#!/bin/sh
# CARLA 0.9.16: a line that OpenDRIVE opens from one side only is open from both sides, or closed from both; in left-hand traffic it is
# open from the wrong side.
#
# One would guess: with `laneChange="increase"` one may change to the lane of the higher id, thus from -2 to -1, and not back;
#   `decrease` is the other way around. This is how the standard puts a line that is dashed on one side and solid on the other.
# What happens: `increase` is read as "to the right" and `decrease` as "to the left", though ids rise from right to left; for the lane to
#   the right of the line it is then turned around once more. In right-hand traffic both lanes may cross an `increase` line of lane -1, and
#   nobody a `decrease` line; on lanes of positive ids it is the other way around. With rule="LHT" just the lane that may not cross may.
#   `both` and `none` are right.
# Source: LibCarla, road/element/LaneMarking.cpp (GetLaneChange), as the wheel of 0.9.16 shows it; ASAM OpenDRIVE 1.8, road mark.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 to 3.12 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check carla==0.9.16
cat >"$place/run.py" <<'END'
import carla


def mark(kind, change):
    return f'<roadMark sOffset="0" type="{kind}" weight="standard" color="standard" width="0.12" laneChange="{change}"/>'


def lane(number, line):
    return f'<lane id="{number}" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/>{line}</lane>'


def changes(ids, change, rule="RHT"):
    """The changes that CARLA allows over the line between two lanes; `ids` names the inner lane, to which the line belongs, first."""
    inner, outer = lane(ids[0], mark("broken", change)), lane(ids[1], mark("solid", "none"))
    left = f"<left>{outer}{inner}</left>" if ids[0] > 0 else ""
    right = f"<right>{inner}{outer}</right>" if ids[0] < 0 else ""
    town = carla.Map("lines", f"""<?xml version="1.0"?>
<OpenDRIVE><header revMajor="1" revMinor="4" name="lines"/>
  <road id="1" length="100" junction="-1" rule="{rule}">
    <planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
    <lanes><laneSection s="0">
      {left}<center><lane id="0" type="none" level="false">{mark("solid", "none")}</lane></center>{right}
    </laneSection></lanes>
  </road>
</OpenDRIVE>""")
    found = set()
    for number in ids:
        here = town.get_waypoint_xodr(1, number, 50.0)
        for side, there in ((carla.LaneChange.Left, here.get_left_lane()), (carla.LaneChange.Right, here.get_right_lane())):
            if there is not None and int(here.lane_change) & int(side):
                found.add((number, there.lane_id))
    return found


cases = {  # lanes and traffic, word: what the standard says, what CARLA does
    ((-1, -2), "increase", "RHT"): ({(-2, -1)}, {(-2, -1), (-1, -2)}),
    ((-1, -2), "decrease", "RHT"): ({(-1, -2)}, set()),
    ((1, 2), "increase", "RHT"): ({(1, 2)}, set()),
    ((1, 2), "decrease", "RHT"): ({(2, 1)}, {(2, 1), (1, 2)}),
    ((-1, -2), "increase", "LHT"): ({(-2, -1)}, {(-1, -2)}),
    ((-1, -2), "decrease", "LHT"): ({(-1, -2)}, {(-2, -1)}),
    ((-1, -2), "both", "RHT"): ({(-1, -2), (-2, -1)}, {(-1, -2), (-2, -1)}),
    ((-1, -2), "none", "RHT"): (set(), set()),
}
so = True
for (ids, word, rule), (meant, expected) in cases.items():
    found = changes(ids, word, rule)
    so &= found == expected
    words = [", ".join("%d to %d" % way for way in sorted(ways)) or "nobody" for ways in (meant, found)]
    print("%s, lanes %s, %-8s: meant %-18s CARLA: %s" % (rule, ids, word, words[0] + ";", words[1]))
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" 2>/dev/null
# Seen:
#   RHT, lanes (-1, -2), increase: meant -2 to -1;          CARLA: -2 to -1, -1 to -2
#   RHT, lanes (-1, -2), decrease: meant -1 to -2;          CARLA: nobody
#   RHT, lanes (1, 2), increase: meant 1 to 2;            CARLA: nobody
#   RHT, lanes (1, 2), decrease: meant 2 to 1;            CARLA: 1 to 2, 2 to 1
#   LHT, lanes (-1, -2), increase: meant -2 to -1;          CARLA: -1 to -2
#   LHT, lanes (-1, -2), decrease: meant -1 to -2;          CARLA: -2 to -1
#   RHT, lanes (-1, -2), both    : meant -2 to -1, -1 to -2; CARLA: -2 to -1, -1 to -2
#   RHT, lanes (-1, -2), none    : meant nobody;            CARLA: nobody
