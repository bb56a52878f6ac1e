#!/bin/sh
# osm-chordify 0.2.4: a bridge for 45 short tons carries 286 kg, and is closed to all lorries, since `st` is read as the stone by which
# people are weighed; a road for lorries up to 25 m long is closed to lorries of any length.
#
# One would guess: `maxweight=45 st` is what OpenStreetMap says it is, 45 tons of the United States, 90,000 pounds; for the United
#   States and the lorries there the tool is made (its classes are those of the FHWA). The same limit in pounds or in tonnes comes to the same.
# What happens: the table of units has stones of 14 pounds under `st`, and short tons nowhere. The limit comes out 143 times too low,
#   below every lorry's weight, so `mdv` and `hgv` (medium and heavy duty) become False for the road. Pounds, kilograms, tonnes and numbers
#   without a unit are right. `maxlength`, whatever its value, sets `hgv` to False too. There is no warning.
# Source: osm_chordify/osm/tags.py (standardize_weight) and graph.py (process_tags), release 0.2.4; OSM wiki, Map features/Units (st: short ton,
#   0.9071847 t), Key:maxweight (United States). The graph is made by OSMnx 2.1.1.
# Exits 0 while it is so, 1 if that changes. Needs CPython 3.11 or newer.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/env"
"$place/env/bin/pip" install --quiet --disable-pip-version-check --no-compile --only-binary :all: osm-chordify==0.2.4 osmnx==2.1.1 \
  networkx==3.6.1 geopandas==1.2.0 pandas==3.1.1 shapely==2.2.0 pyproj==3.7.2 numpy==2.4.6 pyarrow==26.0.1 pyogrio==0.13.0 osmium==4.3.2 \
  census==0.8.27 pygris==0.2.1 requests==2.34.2
cat >"$place/run.py" <<'END'
import logging
import pathlib
import sys

import osmnx
from osm_chordify.osm.graph import process_tags

logging.disable(logging.CRITICAL)
path = pathlib.Path(sys.argv[1]) / "bridges.osm"
# By law a lorry may weigh 80,000 pounds in the United States, and a medium-duty one 26,000; a road for more than that is open to them.
CONFIG = {"weight_limits": {"unit": "lbs", "mdv_max": 26000, "hdv_max": 80000}}
cases = [  # tag: limit in pounds, open to medium and to heavy lorries: what is meant, and what comes out
    ({}, (None, True, True), (None, True, True)),
    ({"maxweight": "90000 lbs"}, (90000, True, True), (90000, True, True)),
    ({"maxweight": "40.8 t"}, (89949, True, True), (89948, True, True)),
    ({"maxweight": "40.8"}, (89949, True, True), (89948, True, True)),
    ({"maxweight": "45 st"}, (90000, True, True), (630, False, False)),
    ({"maxweight": "15 st"}, (30000, True, False), (210, False, False)),
    ({"maxlength": "25"}, (None, True, True), (None, True, False)),
]
nodes, ways = [], []
for number, (tags, _, _) in enumerate(cases, 1):
    for end in (1, 2):
        nodes.append('<node id="%d%d" version="1" lat="40.%02d" lon="-100.%d"/>' % (number, end, number, end))
    ways.append('<way id="%d" version="1"><nd ref="%d1"/><nd ref="%d2"/>%s</way>' % (number, number, number, "".join(
        '<tag k="%s" v="%s"/>' % pair for pair in {"highway": "primary", "bridge": "yes", **tags}.items())))
path.write_text('<?xml version="1.0"?>\n<osm version="0.6">\n%s\n</osm>\n' % "\n".join(nodes + ways))

osmnx.settings.useful_tags_way = [*osmnx.settings.useful_tags_way, "maxweight", "maxlength"]
graph = process_tags(osmnx.graph_from_xml(path, simplify=False, retain_all=True), CONFIG)
found = {}
for _, _, edge in graph.edges(data=True):
    limit = edge.get("maxweight")
    found[edge["osmid"]] = None if limit is None or limit != limit else round(limit), edge["mdv"], edge["hgv"]


def text(limit, medium, heavy):
    weight = "no limit" if limit is None else "%d lb" % limit
    return "%s, %s" % (weight, {(True, True): "open", (True, False): "closed to heavy lorries", (False, False): "closed to lorries"}[medium, heavy])


so = True
for number, (tags, meant, expected) in enumerate(cases, 1):
    so &= found[number] == expected
    print("%-22s meant: %-35s found: %s" % ("=".join(*tags.items()) if tags else "no tag", text(*meant) + ";", text(*found[number])))
raise SystemExit(0 if so else 1)
END
"$place/env/bin/python" -W ignore "$place/run.py" "$place"
# Seen:
#   no tag                 meant: no limit, open;                     found: no limit, open
#   maxweight=90000 lbs    meant: 90000 lb, open;                     found: 90000 lb, open
#   maxweight=40.8 t       meant: 89949 lb, open;                     found: 89948 lb, open
#   maxweight=40.8         meant: 89949 lb, open;                     found: 89948 lb, open
#   maxweight=45 st        meant: 90000 lb, open;                     found: 630 lb, closed to lorries
#   maxweight=15 st        meant: 30000 lb, closed to heavy lorries;  found: 210 lb, closed to lorries
#   maxlength=25           meant: no limit, open;                     found: no limit, closed to heavy lorries
