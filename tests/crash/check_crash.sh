#!/bin/sh
# SPDX-License-Identifier: MIT
# A short run of the crash test; `make crash ROUNDS=200` is the long one.
build=${1:-build}
exec "$build/tests/crash/crash" "$build" 10
