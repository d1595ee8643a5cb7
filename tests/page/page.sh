#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs a program of this folder with what it needs from npm: page.sh BUILD PROGRAM [WORD…]. run.mjs tests the
# page at / and the reports in headless Chromium; its words are parts of the names of tests. Needs nodejs,
# npm and chromium (deploy/install-deps.sh --page); npm is asked once.
set -eu
build=$(cd "$1" && pwd)
program=$2
shift 2
cd "$(dirname "$0")"
modules=$build/page
if [ ! -d "$modules/node_modules/axe-core" ]; then
    mkdir -p "$modules"
    npm install --prefix "$modules" --no-save --no-audit --no-fund --silent playwright-core@1.49.1 axe-core@4.10.2
fi
PEN_BUILD=$build PEN_MODULES=$modules exec node "$program" "$@"
