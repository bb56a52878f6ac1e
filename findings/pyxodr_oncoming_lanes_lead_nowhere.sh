#!/bin/sh
# pyxodr-omega-prime 0.1.5: oncoming lanes of an OpenDRIVE map lead nowhere; pyxodr 0.1.3, of which it is a fork, links them.
#
# One would guess: `traffic_flow_successors` are, as the help of both says, the successors that traffic may legally flow to; on a two-way
#   street each direction flows on, whichever way its roads are drawn.
# What happens: a successor whose traffic runs against the reference line of its road is skipped. Lanes left of the line (with rule="LHT",
#   those right of it) are the successor of no lane: one direction of each two-way street falls to pieces, and the other one ends where
#   a road is drawn the other way. Of the four links in a street of three roads, two are left. Geometry and directions are right,
#   there is no warning, and on roads of one direction drawn along the traffic nothing shows.
# Source: pyxodr_omega_prime/road_objects/lane.py (traffic_flow_successors), release 0.1.5, and the same file of pyxodr 0.1.3.
# Exits 0 while it is so, 1 if that changes.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: pyxodr-omega-prime==0.1.5 pyxodr==0.1.3
cat >"$place/run.py" <<'END'
import sys

import pyxodr.road_objects.network
import pyxodr_omega_prime.road_objects.network

STREETS = {
    # For each road: where it starts, its heading, and by contact point its predecessor and successor.
    "all drawn to the east": [(0, 0, None, "2 start"), (100, 0, "1 end", "3 start"), (200, 0, "2 end", None)],
    "the second one drawn to the west": [(0, 0, None, "2 end"), (200, 3.141592653589793, "3 start", "1 end"), (200, 0, "2 start", None)],
}


def street(name, rule):
    """Three roads of 100 m in a row, with one lane for each direction."""
    text = '<?xml version="1.0"?>\n<OpenDRIVE><header revMajor="1" revMinor="7"/>\n'
    for number, (x, heading, *ends) in enumerate(STREETS[name], 1):
        links, lanes = "", {}
        for kind, end in zip(("predecessor", "successor"), ends):
            if end:
                other, contact = end.split()
                links += f'<{kind} elementType="road" elementId="{other}" contactPoint="{contact}"/>'
        for lane in 1, -1:
            joined = ""
            for kind, end in zip(("predecessor", "successor"), ends):
                if end:  # ids change sign where the other road is drawn the other way
                    turned = (STREETS[name][int(end[0]) - 1][1] == 0) != (heading == 0)
                    joined += f'<{kind} id="{-lane if turned else lane}"/>'
            width = '<width sOffset="0" a="3.5" b="0" c="0" d="0"/>'
            lanes[lane] = f'<lane id="{lane}" type="driving" level="false"><link>{joined}</link>{width}</lane>'
        text += f"""<road id="{number}" name="" length="100" junction="-1" rule="{rule}"><link>{links}</link>
  <planView><geometry s="0" x="{x}" y="0" hdg="{heading}" length="100"><line/></geometry></planView>
  <lanes><laneSection s="0">
    <left>{lanes[1]}</left><center><lane id="0" type="none" level="false"/></center><right>{lanes[-1]}</right>
  </laneSection></lanes>
</road>
"""
    with open(sys.argv[1], "w") as file:
        file.write(text + "</OpenDRIVE>\n")


def links(library):
    """Which lane of which road leads to which, for traffic to the east and to the west; where traffic runs that way at all."""
    found = {"east": [], "west": []}
    for road in library.road_objects.network.RoadNetwork(sys.argv[1]).get_roads():
        for lane in road.lane_sections[0].lanes:
            start, end = lane.traffic_flow_line[0], lane.traffic_flow_line[-1]
            way = "east" if end[0] > start[0] else "west"
            for after in lane.traffic_flow_successors:
                assert abs(after.traffic_flow_line[0][0] - end[0]) < 0.5, "linked lanes meet"
                found[way].append((road.id, after.road_id))
    return {way: sorted(pairs) for way, pairs in found.items()}


EAST, WEST = [("1", "2"), ("2", "3")], [("2", "1"), ("3", "2")]
expected = {
    ("all drawn to the east", "RHT"): (EAST, []),
    ("all drawn to the east", "LHT"): (EAST, []),
    ("the second one drawn to the west", "RHT"): ([("2", "3")], [("3", "2")]),
}
so = True
for (name, rule), left in expected.items():
    street(name, rule)
    before, after = links(pyxodr), links(pyxodr_omega_prime)
    so &= before == {"east": EAST, "west": WEST} and after == dict(zip(("east", "west"), left))
    print("%s, %s" % (name, rule))
    for library, seen in ("pyxodr 0.1.3", before), ("pyxodr-omega-prime 0.1.5", after):
        ways = ["to the %s: %s" % (way, " ".join(">".join(pair) for pair in pairs) or "none") for way, pairs in seen.items()]
        print("  %-25s %s" % (library, ", ".join(ways)))
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/street.xodr"
# Seen:
#   all drawn to the east, RHT
#     pyxodr 0.1.3              to the east: 1>2 2>3, to the west: 2>1 3>2
#     pyxodr-omega-prime 0.1.5  to the east: 1>2 2>3, to the west: none
#   all drawn to the east, LHT
#     pyxodr 0.1.3              to the east: 1>2 2>3, to the west: 2>1 3>2
#     pyxodr-omega-prime 0.1.5  to the east: 1>2 2>3, to the west: none
#   the second one drawn to the west, RHT
#     pyxodr 0.1.3              to the east: 1>2 2>3, to the west: 2>1 3>2
#     pyxodr-omega-prime 0.1.5  to the east: 2>3, to the west: 3>2
