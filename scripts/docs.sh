#!/bin/sh
# Builds the documentation site into target/book/html with mdBook, which is installed under target/ where it is missing.
# A warning of mdBook's is a failure.
set -eu
cd "$(dirname "$0")/.."
CARGO=${CARGO:-cargo}
MDBOOK_VERSION=0.5.4
target=${CARGO_TARGET_DIR:-target}
mdbook=$target/tools/bin/mdbook

if ! "$mdbook" --version 2>/dev/null | grep -qF "v$MDBOOK_VERSION"; then
    $CARGO install --quiet --locked --no-default-features --root "$target/tools" "mdbook@$MDBOOK_VERSION"
fi
$CARGO run --quiet --locked --example book -- "$target/book"
log=$target/book/mdbook.log
"$mdbook" build "$target/book" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
if grep -E 'WARN|ERROR' "$log" >&2; then
    echo "error: mdBook warns; see above" >&2
    exit 1
fi
echo "The site: $(cd "$target/book" && pwd)/html/index.html"
