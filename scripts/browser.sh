#!/bin/sh
# Chromium for the tests of the report: installed where that is allowed. Without it each of these tests notes that it is skipped.
set -eu
cd "$(dirname "$0")"
. ./apt.sh
if [ ! -x /usr/bin/chromium ] || [ ! -x /usr/bin/chromedriver ]; then
    apt_install chromium chromium-driver ||
        echo "no browser for the tests of the report; install Debian's packages chromium and chromium-driver" >&2
fi
