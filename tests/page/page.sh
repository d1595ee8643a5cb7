#!/bin/sh
# SPDX-License-Identifier: MIT
# Tests the page at / and the reports in headless Chromium: page.sh BUILD [PART…] runs the tests whose names
# contain one of the parts. Needs nodejs, npm and chromium (deploy/install-deps.sh --page); playwright-core
# and axe-core come from npm, once.
set -eu
build=$(cd "$1" && pwd)
shift
cd "$(dirname "$0")"
modules=$build/page
if [ ! -d "$modules/node_modules/axe-core" ]; then
    mkdir -p "$modules"
    npm install --prefix "$modules" --no-save --no-audit --no-fund --silent playwright-core@1.49.1 axe-core@4.10.2
fi
PEN_BUILD=$build PEN_MODULES=$modules exec node run.mjs "$@"
