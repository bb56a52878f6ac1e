#!/bin/sh
# Formatting, lints, documentation tests, the Python module, then all tests; the runner's closing line comes last.
set -eu
cd "$(dirname "$0")/.."
CARGO=${CARGO:-cargo}
start=$(date +%s)
step() { printf '\n== %s (%s s)\n' "$1" "$(($(date +%s) - start))"; }

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
oracle=$(scripts/oracle.sh)
export LANEWRIGHT_ORACLE="$oracle"
if $CARGO nextest --version >/dev/null 2>&1; then
    $CARGO nextest run --locked --no-fail-fast
else
    $CARGO test --locked --no-fail-fast --lib --bins --tests
fi
printf '\nall passed in %s s\n' "$(($(date +%s) - start))"
