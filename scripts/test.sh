#!/bin/sh
# Formatting, lints, documentation tests, the Python module, then all tests; the tests that were skipped are named in the end.
# Where ../shared is, a skipped test is a failure.
set -eu
cd "$(dirname "$0")/.."
CARGO=${CARGO:-cargo}
start=$(date +%s)
step() { printf '\n== %s (%s s)\n' "$1" "$(($(date +%s) - start))"; }

LANEWRIGHT_SKIPPED=$(mktemp)
export LANEWRIGHT_SKIPPED

# Runs however the tests end.
finish() {
    code=$?
    count=$(cut -f 1 "$LANEWRIGHT_SKIPPED" | sort -u | wc -l)
    if [ "$count" -gt 0 ]; then
        printf '\n%s tests were skipped, whole or in part:\n' "$count"
        sort -u "$LANEWRIGHT_SKIPPED" | awk -F '\t' '{ print "  " $1 ": " $2 }'
        if [ -d "${LANEWRIGHT_SHARED:-../shared}" ]; then
            echo "error: where ../shared is, no test may be skipped" >&2
            [ "$code" -ne 0 ] || code=1
        fi
    fi
    rm -f "$LANEWRIGHT_SKIPPED"
    [ "$code" -ne 0 ] || printf '\nall passed in %s s, %s skipped\n' "$(($(date +%s) - start))" "$count"
    exit "$code"
}
trap finish EXIT

step "formatting"
$CARGO fmt --all --check
step "lints"
$CARGO clippy --locked --workspace --all-targets -- -D warnings
step "documentation tests"
$CARGO test --locked --doc
step "the Python module"
scripts/python.sh
step "tests"
scripts/browser.sh
LANEWRIGHT_ORACLE=$(scripts/oracle.sh)
export LANEWRIGHT_ORACLE
if $CARGO nextest --version >/dev/null 2>&1; then
    $CARGO nextest run --locked --no-fail-fast
else
    $CARGO test --locked --no-fail-fast --lib --bins --tests
fi
if [ -n "${LANEWRIGHT_SOAK:-}" ]; then
    step "programs of others that read our maps"
    CARGO="$CARGO" scripts/clients.sh
fi
