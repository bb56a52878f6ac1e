#!/bin/sh
# Holds a built map against programs that read OpenStreetMap files and Lanelet2 maps without Lanelet2's own library: GDAL, which QGIS
# opens maps with, osmium, and simple-lanelet2. A part of `make soak`.
set -eu
cd "$(dirname "$0")/.."
. scripts/apt.sh
CARGO=${CARGO:-cargo}
target=${CARGO_TARGET_DIR:-target}
venv=$target/clients

missing() {
    echo "skipped: $1" >&2
    [ -z "${LANEWRIGHT_SKIPPED:-}" ] || printf 'clients\t%s\n' "$1" >>"$LANEWRIGHT_SKIPPED"
    exit 0
}

command -v ogr2ogr >/dev/null 2>&1 && command -v osmium >/dev/null 2>&1 ||
    apt_install gdal-bin osmium-tool || missing "no ogr2ogr and osmium; apt-get install gdal-bin osmium-tool"
if [ ! -f "$venv/ready" ]; then
    rm -rf "$venv"
    python3 -m venv "$venv" || missing "no python3 with venv; apt-get install python3-venv"
    # Beside the real library it would take its name.
    "$venv/bin/pip" install --quiet --disable-pip-version-check simple-lanelet2==1.2.3 || missing "pip cannot install simple-lanelet2"
    touch "$venv/ready"
fi
$CARGO build --locked
made=$(mktemp -d)
trap 'rm -rf "$made"' EXIT
for input in sample_maps/*.osm; do
    name=$(basename "$input" .osm)
    "$target/debug/lanewright" build "$input" -o "$made/$name" --quiet
    "$venv/bin/python" scripts/clients.py "$made/$name/lanelet2_map.osm"
    echo "$name: read alike by GDAL, osmium and simple-lanelet2"
done
