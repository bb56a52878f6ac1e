#!/bin/sh
# Says which version of lanewright the GitHub Action installs, as a key for its cache: of a wheel that is given its hash, or its address;
# else the version, and a hash of what it is built from.
# Usage: action_version.sh SOURCE, the action's own files. WHEEL is the wheel.
set -eu
source=$1
wheel=${WHEEL:-}
# macOS has the second.
hash() { if command -v sha256sum >/dev/null 2>&1; then sha256sum; else shasum -a 256; fi | cut -c 1-32; }

version=$(sed -n 's/^version = "\(.*\)"/\1/p' "$source/Cargo.toml" | head -n 1)
if [ -n "$wheel" ] && [ -f "$wheel" ]; then
    echo "$version-wheel-$(hash <"$wheel")"
elif [ -n "$wheel" ]; then
    echo "$version-wheel-$(printf %s "$wheel" | hash)"
else
    cd "$source"
    built_from=$(find Cargo.toml Cargo.lock pyproject.toml src python rules -type f | LC_ALL=C sort | while IFS= read -r file; do
        printf '%s\n' "$file"
        cat "$file"
    done | hash)
    echo "$version-$built_from"
fi
