#!/bin/sh
# SPDX-License-Identifier: MIT
# Judges the skipped tests, for .ci/run: needs.sh BUILD
# reads the lines `skipped: NEED: WHY` in BUILD/tests/log, and finds out whether this machine has what each
# needs. Exit 1 if a test was skipped that could run, or if a need is not in this list.
set -u
log=$1/tests/log
has() { # NEED: whether this machine has it
    case $1 in
    mount) # mounting in a mount namespace of its own
        folder=$(mktemp -d)
        unshare -m mount -t tmpfs none "$folder" 2>/dev/null
        code=$?
        rmdir "$folder"
        return "$code"
        ;;
    setuid) setpriv --reuid=65534 true 2>/dev/null ;;
    terminal) python3 -c 'import os; os.openpty()' 2>/dev/null ;;
    postgresql) ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 ;;
    avx2) grep -qw "$1" /proc/cpuinfo ;;
    models) [ -d "${PEN_MODELS:-}" ] ;;
    plain-build) case $log in *asan* | *tsan*) return 1 ;; esac ;;
    command-*) command -v "${1#command-}" >/dev/null ;;
    *) echo "tests/needs.sh does not know the need \"$1\"" ;;
    esac
}
grep -ah '^skipped: ' "$log"/tests/*/*.out | sort -u >"$log/skipped"
wrong=0
while IFS=: read -r _ need why; do
    if has "${need# }"; then
        echo "skipped, but it could run:$need:$why"
        wrong=1
    fi
done <"$log/skipped"
exit "$wrong"
