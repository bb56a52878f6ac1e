#!/bin/sh
# Sees that what the build needs is there: PROJ is built from source, which takes CMake, C++17 and SQLite.
# Installs what is missing through apt where it may, else says exactly what to install.
set -eu
. "$(dirname "$0")/apt.sh"

list_missing() {
    command -v cmake >/dev/null 2>&1 || echo cmake
    echo 'int main() { return 0; }' | c++ -std=c++17 -x c++ -fsyntax-only - >/dev/null 2>&1 || echo g++
    command -v sqlite3 >/dev/null 2>&1 || echo sqlite3
    echo '#include <sqlite3.h>' | cc -E - >/dev/null 2>&1 || echo libsqlite3-dev
    command -v pkg-config >/dev/null 2>&1 || echo pkg-config
}

if ! command -v "${CARGO:-cargo}" >/dev/null 2>&1; then
    echo "error: no Rust toolchain (cargo) here; install one: https://rustup.rs" >&2
    exit 2
fi

missing=$(list_missing | xargs)
[ -n "$missing" ] || exit 0

# shellcheck disable=SC2086  # one word per package
if ! apt_install $missing; then
    echo "error: the build needs packages that are not here and that could not be installed. Run:" >&2
    echo "    sudo apt-get install $missing" >&2
    exit 2
fi
missing=$(list_missing | xargs)
if [ -n "$missing" ]; then
    echo "error: still missing after installation: $missing" >&2
    exit 2
fi
