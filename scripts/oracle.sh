#!/bin/sh
# Prints the path of a Python that has the real Lanelet2 library, for the tests that hold our maps against it.
# Makes a virtual environment under target/ when the acceptance tools lie in ../shared; prints nothing if it cannot, and each of
# these tests notes that it is skipped.
set -eu
. "$(dirname "$0")/apt.sh"
root=$(cd "$(dirname "$0")/.." && pwd)
shared=${LANEWRIGHT_SHARED:-$root/../shared}
requirements=$shared/tools/requirements.txt
venv=${CARGO_TARGET_DIR:-$root/target}/oracle

give_up() {
    echo "no Python with the real Lanelet2 library: $1" >&2
    exit 0
}

if [ -n "${LANEWRIGHT_ORACLE:-}" ]; then
    echo "$LANEWRIGHT_ORACLE"
    exit 0
fi
[ -f "$requirements" ] || give_up "$shared is not here"
if [ -f "$venv/ready" ] && cmp -s "$requirements" "$venv/ready"; then
    echo "$venv/bin/python"
    exit 0
fi
if ! python3 -c 'import venv, ensurepip' >/dev/null 2>&1; then
    apt_install python3 python3-venv >&2 || give_up "no python3 with venv; sudo apt-get install python3 python3-venv"
fi
mkdir -p "$(dirname "$venv")"
rm -rf "$venv"
python3 -m venv "$venv" >&2 || give_up "python3 -m venv failed"
"$venv/bin/pip" install --quiet --disable-pip-version-check -r "$requirements" >&2 || give_up "pip install failed"
cp "$requirements" "$venv/ready"
echo "$venv/bin/python"
