#!/bin/sh
# Runs every fuzzer of fuzz/ for FUZZ_SECONDS (300), or those that are named. Seeds are the maps of the tests; what is
# found lies in fuzz/artifacts. More seeds, such as maps of one's own, may lie in fuzz/seeds/TARGET, which git passes over.
set -eu
cd "$(dirname "$0")/.."
CARGO=${CARGO:-cargo}
seconds=${FUZZ_SECONDS:-300}
# libFuzzer needs flags of rustc that are not stable yet; they do not change what is compiled.
export RUSTC_BOOTSTRAP=1
$CARGO fuzz --version >/dev/null 2>&1 || $CARGO install --locked cargo-fuzz

seed() { # target, largest size in kB, folders: copies their maps as seeds
    mkdir -p "fuzz/corpus/$1" "fuzz/seeds/$1"
    target=$1 size=$2
    shift 2
    find "$@" -name '*.osm' -size "-${size}k" | while read -r map; do
        cp "$map" "fuzz/corpus/$target/$(echo "$map" | tr / _)"
    done
}
seed osm_xml 12 tests/rules sample_maps
# The targets that damage sound maps themselves start from nothing but a byte that chooses the map.
for target in check build_map osm_pbf settings opendrive; do
    mkdir -p "fuzz/corpus/$target" "fuzz/seeds/$target"
done
for byte in 0 1 2 3 4 5 6 7 8 9; do
    # shellcheck disable=SC2059
    printf "\\00$byte abcdefghijklmnopqrstuvwxyz" | tee "fuzz/corpus/check/$byte" "fuzz/corpus/opendrive/$byte" >"fuzz/corpus/build_map/$byte"
done
awk '/^```toml/ { on = 1; next } /^```/ { on = 0 } on' docs/configuration.md >fuzz/corpus/settings/all.toml
find tests/rules -name '*.toml' | while read -r file; do
    cp "$file" "fuzz/corpus/settings/$(echo "$file" | tr / _)"
done

[ $# -gt 0 ] || set -- osm_xml osm_pbf check settings build_map opendrive
for target in "$@"; do
    echo "== $target, $seconds s"
    dictionary=
    [ -f "fuzz/$target.dict" ] && dictionary="-dict=fuzz/$target.dict"
    # shellcheck disable=SC2086
    $CARGO fuzz run -s none "$target" "fuzz/corpus/$target" "fuzz/seeds/$target" -- \
        -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 -max_len=65536 -print_final_stats=1 $dictionary
done
