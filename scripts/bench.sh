#!/bin/sh
# Prints how fast we are: the tables of docs/benchmarks.md. Builds the release profile; needs what lies in ../shared for
# all but the cost of a road.
set -eu
cd "$(dirname "$0")/.."
CARGO=${CARGO:-cargo}
target=${CARGO_TARGET_DIR:-target}

$CARGO build --release --locked --features allocator
$CARGO bench --locked --features allocator --bench cost
$CARGO bench --locked --features allocator --bench lane_stitching
oracle=$(scripts/oracle.sh)
if [ -z "$oracle" ]; then
    echo "skipped: the comparison with netconvert and the Lanelet2 library, which needs ../shared" >&2
    exit 0
fi
"$oracle" -c 'import sumo' 2>/dev/null || "$oracle" -m pip install --quiet --disable-pip-version-check eclipse-sumo==1.28.0
"$oracle" scripts/bench.py "$target/release/lanewright" --oracle "$oracle" --shared "${LANEWRIGHT_SHARED:-../shared}" "$@"
