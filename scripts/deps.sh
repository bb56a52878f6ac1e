#!/bin/sh
# Sees that what the build needs is there, and installs what is missing through apt where it may: else it says what to install.
#
# PROJ comes from the system where a package has it: then `.cargo/config.toml` tells Cargo to link it in place of building it from
# source, which takes CMake, C++17, SQLite and minutes. Any PROJ from 9.1 on will do; `proj-sys` by itself asks for 9.6.2.
set -eu
. "$(dirname "$0")/apt.sh"
cd "$(dirname "$0")/.."
config=.cargo/config.toml
ours="Written by scripts/deps.sh"

if ! command -v "${CARGO:-cargo}" >/dev/null 2>&1; then
    echo "error: no Rust toolchain (cargo) here; install one: https://rustup.rs" >&2
    exit 2
fi

# The version of the PROJ that the compiler finds, as one number: 90101 for 9.1.1.
system_proj() {
    printf '#include <proj.h>\nPROJ_VERSION_MAJOR PROJ_VERSION_MINOR PROJ_VERSION_PATCH\n' | cc -E -P - 2>/dev/null |
        awk 'NF == 3 { version = $1 * 10000 + $2 * 100 + $3 } END { print version + 0 }'
}

# A PROJ that is there already needs no C++ compiler.
link_system_proj() {
    if [ -f "$config" ] && ! head -n 1 "$config" | grep -q "$ours"; then
        echo "$config is not ours: it says how PROJ is linked" >&2
        return
    fi
    host=$(rustc -vV | sed -n 's/^host: //p')
    mkdir -p "$(dirname "$config")"
    cat >"$config.new" <<END
# $ours: PROJ is that of the system. Without this file it is built from source.
[target.$host.proj]
rustc-link-lib = ["proj"]

[target.$host.cplusplus]
END
    if cmp -s "$config" "$config.new"; then rm "$config.new"; else mv "$config.new" "$config"; fi
}

list_missing() {
    command -v cmake >/dev/null 2>&1 || echo cmake
    echo 'int main() { return 0; }' | c++ -std=c++17 -x c++ -fsyntax-only - >/dev/null 2>&1 || echo g++
    command -v sqlite3 >/dev/null 2>&1 || echo sqlite3
    echo '#include <sqlite3.h>' | cc -E - >/dev/null 2>&1 || echo libsqlite3-dev
    command -v pkg-config >/dev/null 2>&1 || echo pkg-config
}

install_or_say() {
    [ $# -gt 0 ] || return 0
    if ! apt_install "$@"; then
        echo "error: the build needs packages that are not here and that could not be installed. Run:" >&2
        echo "    sudo apt-get install $*" >&2
        exit 2
    fi
}

oldest=90100
if [ "$(system_proj)" -lt $oldest ]; then
    apt_install libproj-dev || true
fi
if [ "$(system_proj)" -ge $oldest ]; then
    link_system_proj
    exit 0
fi

echo "no PROJ of $oldest or newer (9.1.0) here: it is built from source, which takes minutes" >&2
[ ! -f "$config" ] || ! head -n 1 "$config" | grep -q "$ours" || rm "$config"
# shellcheck disable=SC2046  # one word per package
install_or_say $(list_missing)
missing=$(list_missing | xargs)
if [ -n "$missing" ]; then
    echo "error: still missing after installation: $missing" >&2
    exit 2
fi
