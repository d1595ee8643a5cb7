#!/bin/sh
# SPDX-License-Identifier: MIT
# The museum: its values are right, and its page and pictures are what `make museum` writes.
. "$(dirname "$0")/../e2e/lib.sh"
expect "museum: values, page and pictures" "$(python3 -B "$(dirname "$0")/museum.py" "$build" --check 2>&1)" ""
finish
