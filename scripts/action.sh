#!/bin/sh
# What the GitHub Action runs: one check for the annotations and the page, one more for SARIF where it is asked for.
set -eu
set -f # the words of ARGUMENTS are arguments, not patterns

set -- --fail-on "${FAIL_ON:-error}"
[ -z "${BASELINE:-}" ] || set -- "$@" --baseline "$BASELINE"
# shellcheck disable=SC2086  # split at blanks, as action.yml says
set -- "$@" ${ARGUMENTS:-}

if [ -n "${SARIF:-}" ]; then
    code=0
    lanewright check "$@" --format sarif -- "$MAP" >"$SARIF" || code=$?
    [ "$code" -lt 2 ] || exit "$code"
fi
[ -z "${REPORT:-}" ] || set -- "$@" --report "$REPORT"
exec lanewright check "$@" --format github -- "$MAP"
