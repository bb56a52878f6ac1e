#!/bin/sh
# Draws every intersection of the corpus beside the project, or of the sample maps where there is none, stage by stage,
# and writes pages to look through. GALLERY_STAGES and GALLERY_INPUTS choose others.
set -eu
cd "$(dirname "$0")/.."

program="${LANEWRIGHT:-${CARGO_TARGET_DIR:-target}/debug/lanewright}"
stages="${GALLERY_STAGES:-consolidate,outline,movements}"
out="${CARGO_TARGET_DIR:-target}/gallery"
inputs="${GALLERY_INPUTS:-}"
if [ -z "$inputs" ]; then
    inputs="sample_maps/*.osm"
    for input in ../shared/corpus/osm/*.osm; do
        [ -e "$input" ] && inputs="../shared/corpus/osm/*.osm"
    done
fi

mkdir -p "$out"
page="$out/index.html"
echo '<!doctype html><meta charset="utf-8"><title>lanewright: gallery</title><h1>Gallery</h1><ul>' > "$page.new"
# Unquoted, so that patterns are spelt out.
for input in $inputs; do
    name="$(basename "$input" .osm)"
    "$program" draw "$input" --stage "$stages" --each -o "$out/$name"
    "$program" draw "$input" --stage outline -o "$out/$name/whole.png"
    echo "<li><a href=\"$name/index.html\">$name</a> (<a href=\"$name/whole.png\">whole</a>)" >> "$page.new"
done
echo '</ul>' >> "$page.new"
mv "$page.new" "$page"
echo "$page"
