#!/bin/sh
# SPDX-License-Identifier: MIT
# A short run of the crash test; `make crash ROUNDS=200` is the long one.
build=${1:-build}
rounds=6
[ -z "${PEN_FEWER:-}" ] || rounds=4 # see tests/support/random.h
exec "$build/tests/crash/crash" "$build" "$rounds"
