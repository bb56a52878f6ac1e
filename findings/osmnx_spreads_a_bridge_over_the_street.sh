#!/bin/sh
# OSMnx 2.1.1: a bridge 70 m long makes 2.2 km of street a bridge, and a 30 km/h zone on it holds for all of them.
#
# One would guess: where ways are merged into one edge, their differing tags become a list, as `lanes` do; a way without the tag differs from
#   one with it, so that `bridge` is a list, or empty.
# What happens: `simplify_graph`, on by default in every `graph_from_…`, collects the values that are there and does not note that other parts
#   have none. One value is left, and it is put on the whole edge as if all of it had it: `bridge`, `layer`, `access=no`, `maxspeed`. For
#   `add_edge_speeds` and travel times the whole street is 30 km/h. `edge_attr_aggs` does not see the missing value either.
#   A way out: `edge_attrs_differ=["bridge", "maxspeed"]` keeps the parts apart, for it does count a missing tag as different.
# Source: osmnx/simplification.py (simplify_graph), release 2.1.1, and its help: "unique attribute values are stored as a list".
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.11 or newer.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check osmnx==2.1.1
cat >"$place/run.py" <<'END'
import sys
import osmnx

with open(sys.argv[1], "w") as file:
    file.write("""<?xml version="1.0"?>
<osm version="0.6" generator="by hand">
  <node id="1" version="1" lat="48" lon="9.000"/><node id="2" version="1" lat="48" lon="9.014"/>
  <node id="3" version="1" lat="48" lon="9.015"/><node id="4" version="1" lat="48" lon="9.030"/>
  <way id="11" version="1"><nd ref="1"/><nd ref="2"/><tag k="highway" v="primary"/><tag k="lanes" v="2"/></way>
  <way id="12" version="1"><nd ref="2"/><nd ref="3"/><tag k="highway" v="primary"/><tag k="lanes" v="3"/>
    <tag k="bridge" v="yes"/><tag k="maxspeed" v="30"/></way>
  <way id="13" version="1"><nd ref="3"/><nd ref="4"/><tag k="highway" v="primary"/><tag k="lanes" v="2"/></way>
</osm>""")


def edges(graph):
    return [(round(d["length"]), d.get("bridge"), d.get("maxspeed"), sorted(d["lanes"]))
            for u, v, d in sorted(graph.edges(data=True), key=lambda edge: edge[:2]) if u < v]


merged = edges(osmnx.graph_from_xml(sys.argv[1]))
parts = osmnx.graph_from_xml(sys.argv[1], simplify=False)
kept = edges(osmnx.simplify_graph(parts, edge_attrs_differ=["bridge"]))
print("merged (metres, bridge, maxspeed, lanes):", merged)
print("kept apart by bridge:", kept)
apart = [(1042, None, None), (74, "yes", "30"), (1116, None, None)]
good = merged == [(2232, "yes", "30", ["2", "3"])]
raise SystemExit(0 if good and [each[:3] for each in kept] == apart else 1)
END
"$place/env/bin/python" "$place/run.py" "$place/street.osm"
# Seen:
#   merged (metres, bridge, maxspeed, lanes): [(2232, 'yes', '30', ['2', '3'])]
#   kept apart by bridge: [(1042, None, None, ['2']), (74, 'yes', '30', ['3']), (1116, None, None, ['2'])]
