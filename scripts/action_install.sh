#!/bin/sh
# Installs lanewright for the GitHub Action: WHEEL, a path or an address, where one is given; else the wheel of the release that
# the action was taken from; else one built here, into DIRECTORY, which the action keeps in its cache.
# Usage: action_install.sh SOURCE DIRECTORY, the action's own files and where its environment is to be.
set -eu
source=$1
directory=$2
environment=$directory/environment

if [ -x "$environment/bin/lanewright" ] && "$environment/bin/lanewright" --version >/dev/null 2>&1; then
    exit 0
fi
wheel=${WHEEL:-}
if [ -z "$wheel" ] && [ -n "${GITHUB_ACTION_REF:-}" ] && command -v gh >/dev/null 2>&1; then
    machine=$(uname -m)
    if gh release download "$GITHUB_ACTION_REF" --repo "${GITHUB_ACTION_REPOSITORY:-}" --pattern "lanewright-*linux*$machine.whl" \
        --dir "$directory/release" 2>/dev/null; then
        wheel=$(ls "$directory"/release/*.whl)
    fi
fi
if [ -z "$wheel" ]; then
    echo "no wheel given and no release of this version: building one, which takes minutes"
    "$source/scripts/deps.sh"
    wheel=$source
fi
python3 -m venv "$environment"
"$environment/bin/pip" install --quiet --disable-pip-version-check "$wheel"
"$environment/bin/lanewright" --version
