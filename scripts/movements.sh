#!/bin/sh
# Prints on how many movements we and netconvert agree: the last table of docs/benchmarks.md. Needs what lies in ../shared.
# Arguments are passed on: --list names every pair on which the two differ.
set -eu
cd "$(dirname "$0")/.."
CARGO=${CARGO:-cargo}

oracle=$(scripts/oracle.sh)
if [ -z "$oracle" ]; then
    echo "skipped: the comparison with netconvert needs ../shared" >&2
    exit 0
fi
$CARGO build --locked
for wheel in sumo:eclipse-sumo==1.28.0 shapely:shapely; do
    "$oracle" -c "import ${wheel%%:*}" 2>/dev/null || "$oracle" -m pip install --quiet --disable-pip-version-check "${wheel#*:}"
done
exec "$oracle" scripts/movements.py "${CARGO_TARGET_DIR:-target}/debug/lanewright" "${LANEWRIGHT_SHARED:-../shared}"/corpus/osm/*.osm "$@"
