#!/bin/sh
# SPDX-License-Identifier: MIT
# How the daemon serves clients that send bad requests, are refused early, or are slow; takes two minutes.
# `make load` runs it.
. "$(dirname "$0")/../e2e/lib.sh"
. "$(dirname "$0")/lib.sh"
load_start
run() { # PROGRAM ARGUMENT…
    echo "== $*"
    name=$1
    shift
    "$build/tests/load/$name" "$@"
    expect "$name" "$?" 0
}
run strict "$port" check
run early "$port"
run deadlines "$port" "$picture" check
finish
