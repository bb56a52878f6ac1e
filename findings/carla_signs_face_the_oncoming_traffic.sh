#!/bin/sh
# CARLA 0.9.16: a speed limit sign of OpenDRIVE that stands for one direction of traffic is shown to the other.
#
# One would guess: a signal with orientation="+" is for traffic that drives along the reference line, in right-hand traffic for lanes of
#   negative ids; `<validity>` only narrows this down to some of these lanes.
# What happens: without `<validity>`, CARLA gives a "+" signal to the lanes of positive ids and a "-" signal to those of negative ids. In
#   right-hand traffic the driver for whom the sign is gets no landmark, and oncoming traffic gets it. With rule="LHT" it comes out
#   right. With `<validity>` the orientation does not count at all.
# Source: LibCarla, road/MapBuilder.cpp (GenerateDefaultValiditiesForSignalReferences), as the wheel of 0.9.16 shows it; ASAM OpenDRIVE 1.8,
#   signals, orientation.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.10 to 3.12 on Linux.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check carla==0.9.16
cat >"$place/run.py" <<'END'
import carla

lane = '<lane id="%d" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'


def who_sees(orientation, rule="RHT", validity=""):
    """Who sees a sign in the middle of a road of two lanes from 20 m before it: who drives along the reference line, who against it."""
    town = carla.Map("signs", f"""<?xml version="1.0"?>
<OpenDRIVE><header revMajor="1" revMinor="4" name="signs"/>
  <road id="1" length="200" junction="-1" rule="{rule}">
    <planView><geometry s="0" x="0" y="0" hdg="0" length="200"><line/></geometry></planView>
    <lanes><laneSection s="0">
      <left>{lane % 1}</left><center><lane id="0" type="none" level="false"/></center><right>{lane % -1}</right>
    </laneSection></lanes>
    <signals>
      <signal s="100" t="-5" id="7" name="limit" dynamic="no" orientation="{orientation}" zOffset="2" country="DE" type="274" subtype="50"
              value="50" unit="km/h" height="0.6" width="0.6">{validity}</signal>
    </signals>
  </road>
</OpenDRIVE>""")
    seen = []
    for number in -1, 1:
        along = (number < 0) == (rule == "RHT")
        here = town.get_waypoint_xodr(1, number, 80.0 if along else 120.0)
        ahead = here.next(10)[0].s > here.s
        assert ahead == along, "the lanes themselves run as the rule says"
        if here.get_landmarks(50.0):
            seen.append("along" if along else "against")
    return seen


cases = {
    ("+", "RHT"): (["along"], ["against"]),
    ("-", "RHT"): (["against"], ["along"]),
    ("+", "LHT"): (["along"], ["along"]),
    ("+", "RHT", '<validity fromLane="-1" toLane="-1"/>'): (["along"], ["along"]),
    ("-", "RHT", '<validity fromLane="-1" toLane="-1"/>'): ([], ["along"]),
}
so = True
for case, (meant, expected) in cases.items():
    found = who_sees(*case)
    so &= found == expected
    print("%-50s meant for traffic %-12s CARLA shows it to traffic %s" % (" ".join(case), meant, found))
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" 2>/dev/null
# Seen:
#   + RHT                                              meant for traffic ['along']    CARLA shows it to traffic ['against']
#   - RHT                                              meant for traffic ['against']  CARLA shows it to traffic ['along']
#   + LHT                                              meant for traffic ['along']    CARLA shows it to traffic ['along']
#   + RHT <validity fromLane="-1" toLane="-1"/>        meant for traffic ['along']    CARLA shows it to traffic ['along']
#   - RHT <validity fromLane="-1" toLane="-1"/>        meant for traffic []           CARLA shows it to traffic ['along']
