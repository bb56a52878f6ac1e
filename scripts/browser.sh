#!/bin/sh
# Chromium for the tests of the report: installed where that is allowed; else says that they are skipped.
set -eu
cd "$(dirname "$0")"
. ./apt.sh
if [ ! -x /usr/bin/chromium ] || [ ! -x /usr/bin/chromedriver ]; then
    apt_install chromium chromium-driver ||
        echo "skipped: the tests of the report in a browser; install Debian's packages chromium and chromium-driver"
fi
