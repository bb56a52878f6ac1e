# Notes what a script leaves out. Sourced; defines `skipped`.
# shellcheck shell=sh

# skipped WHAT WHY: says so, also in the list that test.sh prints in the end.
skipped() {
    echo "skipped: $1 ($2)" >&2
    [ -z "${LANEWRIGHT_SKIPPED:-}" ] || printf '%s\t%s\n' "$1" "$2" >>"$LANEWRIGHT_SKIPPED"
}
