#!/bin/sh
# lanelet2-parser 0.1.8: in an oncoming lane the next lanelet is the one behind it, unless somebody drew its kerb along the traffic; of three
# traffic lights, and of three lanes that must yield, only the last one in the file is left.
#
# One would guess: a lanelet runs the way that its left and right bounds say, whichever way these lines were drawn; Lanelet2 turns
#   them around when it reads the file, and its documentation promises that. A role that is given several times has several members.
# What happens: lanelets are linked by the first and last node of one bound as it is drawn: the left one in left-hand traffic (the default), the
#   right one otherwise. A street whose lines are all drawn along the reference line, as converters write them, has its oncoming lanes
#   linked backwards: `next_ids` are the lanelets behind, `prev_ids` those ahead. Where one kerb of a lane changes its direction of
#   drawing, the link is gone. And each role of a regulatory element keeps one member, the last. Positions, and neighbours on the
#   left and right, are right. There is no warning.
# Source: lanelet2_parser/lanelet2/network.py (create_lanelet_network) and converter.py (get_regulatory_element), release 0.1.8; Lanelet2,
#   LaneletPrimitives.md ("the library will do the alignment for you"), RegulatoryElementTagging.md (right of way, traffic light). Lanelet2 1.2.3
#   reads the same files.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.9 to 3.13 on Linux. schematics is a patch level above the one that the parser names,
# since that one needs CPython 3.9 or older.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --no-deps lanelet2-parser==0.1.8 schematics==2.1.1
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile lanelet2==1.2.3
cat >"$place/run.py" <<'END'
import pathlib
import sys

import lanelet2
from lanelet2.projection import UtmProjector
from lanelet2_parser.parser import Lanelet2Parser

path = pathlib.Path(sys.argv[1]) / "street.osm"
EAST, WEST = (101, 102, 103), (201, 202, 203)  # lanelets, in the order of their traffic


def tags(**given):
    return "".join('<tag k="%s" v="%s"/>' % pair for pair in {"location": "urban", **given}.items())


def street(north_drawn, south_drawn, driving):
    """A street to the east of three pieces with a lane each way. Its two kerbs are drawn to the east or west, a letter for each piece."""
    nodes, ways, lanelets = [], [], []
    for row, lat in ((0, 49.0), (1, 49.00003), (2, 49.00006)):  # south kerb, middle, north kerb
        for column in range(4):
            nodes.append('<node id="%d" lat="%.5f" lon="%.3f"/>' % (10 * row + column + 1, lat, 8 + column / 1000))
        for column in range(3):
            ends = [10 * row + column + 1, 10 * row + column + 2]
            if (south_drawn, "eee", north_drawn)[row][column] == "w":
                ends.reverse()
            ways.append('<way id="%d">%s%s</way>' % (50 + 10 * row + column, "".join('<nd ref="%d"/>' % end for end in ends),
                                                      tags(type="line_thin", subtype="dashed" if row == 1 else "solid")))
    for column in range(3):
        south, middle, north = (50 + 10 * row + column for row in range(3))
        sides = {"right": ((EAST[column], middle, south), (WEST[2 - column], middle, north)),
                 "left": ((EAST[column], north, middle), (WEST[2 - column], south, middle))}[driving]
        for number, left, right in sides:
            lanelets.append('<relation id="%d"><member type="way" ref="%d" role="left"/><member type="way" ref="%d" role="right"/>%s</relation>' % (
                number, left, right, tags(type="lanelet", subtype="road", one_way="yes")))
    return nodes + ways + lanelets


def links(parts, driving):
    """What follows each lanelet: for the parser, and for Lanelet2."""
    path.write_text('<?xml version="1.0"?>\n<osm version="0.6">%s</osm>\n' % "\n".join(parts))
    parser = Lanelet2Parser()
    found = parser.convert_to_lanelet2(parser.parse(str(path)), left_hand_traffic=driving == "left").lanelet_relations
    town = lanelet2.io.load(str(path), UtmProjector(lanelet2.io.Origin(49, 8)))
    rules = lanelet2.traffic_rules.create(lanelet2.traffic_rules.Locations.Germany, lanelet2.traffic_rules.Participants.Vehicle)
    graph = lanelet2.routing.RoutingGraph(town, rules)
    return [{number: sorted(following(number)) for number in EAST + WEST}
            for following in (lambda number: found[number].next_ids, lambda number: [one.id for one in graph.following(town.laneletLayer[number])])]


def text(following):
    return ", ".join("%d to %d" % (number, one) for number, some in following.items() for one in some)


forwards = {101: [102], 102: [103], 103: [], 201: [202], 202: [203], 203: []}
backwards = {**forwards, 201: [], 202: [201], 203: [202]}
torn = {**forwards, 201: [], 202: [203]}
so = True
for name, north, south, driving, expected in (
    ("right-hand traffic, kerbs drawn along the traffic", "www", "eee", "right", forwards),
    ("right-hand traffic, all lines drawn to the east", "eee", "eee", "right", backwards),
    ("right-hand traffic, one piece of kerb to the east", "wwe", "eee", "right", torn),
    ("left-hand traffic, kerbs drawn along the traffic", "eee", "www", "left", forwards),
    ("left-hand traffic, all lines drawn to the east", "eee", "eee", "left", backwards),
):
    found, meant = links(street(north, south, driving), driving)
    so &= (found, meant) == (expected, forwards)
    print("%s:\n  Lanelet2: %s\n  parser:   %s" % (name, text(meant), text(found)))

parts = street("www", "eee", "right")
light = tags(type="traffic_light", subtype="red_yellow_green")
parts.insert(0, "".join('<node id="%d" lat="49.00007" lon="8.00%d"/>' % (number, number) for number in range(41, 47)))
signs = "".join('<way id="%d"><nd ref="%d"/><nd ref="%d"/>%s</way>' % (90 + place, 41 + 2 * place, 42 + 2 * place, light) for place in range(3))
several = "".join('<member type="way" ref="%d" role="refers"/>' % number for number in (90, 91, 92))
lights = '<relation id="300">%s%s</relation>' % (several, tags(type="regulatory_element", subtype="traffic_light"))
several = "".join('<member type="relation" ref="%d" role="%s"/>' % one for one in ((101, "right_of_way"), (201, "yield"), (202, "yield"), (203, "yield")))
priority = '<relation id="301">%s%s</relation>' % (several, tags(type="regulatory_element", subtype="right_of_way"))
path.write_text('<?xml version="1.0"?>\n<osm version="0.6">%s%s%s%s</osm>\n' % ("\n".join(parts), signs, lights, priority))
parser = Lanelet2Parser()
elements = parser.convert_to_lanelet2(parser.parse(str(path)), left_hand_traffic=False).regulatory_elements
layer = lanelet2.io.load(str(path), UtmProjector(lanelet2.io.Origin(49, 8))).regulatoryElementLayer
kept = [elements[300].parameters.refers.id, elements[301].parameters.param_yield.id]
meant = [[one.id for one in layer[300].parameters["refers"]], [one.id for one in layer[301].parameters["yield"]]]
so &= kept == [92, 203] and meant == [[90, 91, 92], [201, 202, 203]]
print("traffic lights: Lanelet2: %s; parser: %d\nlanes that yield: Lanelet2: %s; parser: %d" % (meant[0], kept[0], meant[1], kept[1]))
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" -W ignore "$place/run.py" "$place"
# Seen:
#   right-hand traffic, kerbs drawn along the traffic:
#     Lanelet2: 101 to 102, 102 to 103, 201 to 202, 202 to 203
#     parser:   101 to 102, 102 to 103, 201 to 202, 202 to 203
#   right-hand traffic, all lines drawn to the east:
#     Lanelet2: 101 to 102, 102 to 103, 201 to 202, 202 to 203
#     parser:   101 to 102, 102 to 103, 202 to 201, 203 to 202
#   right-hand traffic, one piece of kerb to the east:
#     Lanelet2: 101 to 102, 102 to 103, 201 to 202, 202 to 203
#     parser:   101 to 102, 102 to 103, 202 to 203
#   left-hand traffic, kerbs drawn along the traffic:
#     Lanelet2: 101 to 102, 102 to 103, 201 to 202, 202 to 203
#     parser:   101 to 102, 102 to 103, 201 to 202, 202 to 203
#   left-hand traffic, all lines drawn to the east:
#     Lanelet2: 101 to 102, 102 to 103, 201 to 202, 202 to 203
#     parser:   101 to 102, 102 to 103, 202 to 201, 203 to 202
#   traffic lights: Lanelet2: [90, 91, 92]; parser: 92
#   lanes that yield: Lanelet2: [201, 202, 203]; parser: 203
