#!/bin/sh
# SPDX-License-Identifier: MIT
# Installs what building and testing Penumbra needs and the machine lacks: Debian packages only.
# Running it again changes nothing. Needs root or sudo only when something is missing.
#
#   install-deps.sh           to build, run and test
#   install-deps.sh --lint    also what `make lint` and the clang build use
#   install-deps.sh --bench   also what the comparisons in tests/bench use
#   install-deps.sh --page    also what the tests of the page use: Chromium, Node.js, npm
#   install-deps.sh --promtool   also Prometheus, whose promtool then checks /metrics; where the machine
#                             has systemd, its server is started, too
#   install-deps.sh --all     all of these, and what tests skip without: PostgreSQL (where the machine has
#                             systemd, its server is started, too), PgBouncer, nginx, valgrind, groff, mandoc,
#                             zsh, faketime
set -eu

packages="gcc g++ make libc6-dev pkg-config libjansson-dev libpng-dev zlib1g-dev libsqlite3-dev
    libzstd-dev libsodium-dev libmicrohttpd-dev libpq-dev libgnutls28-dev libcurl4-openssl-dev libexpat1-dev check curl ca-certificates openssl jq procps
    python3-minimal python3-yaml python3-jsonschema"
lint="clang clang-format libclang-rt-14-dev binutils"
bench=povray
page=chromium
command -v npm >/dev/null || page="$page nodejs npm"
promtool=prometheus
tests="postgresql postgresql-client pgbouncer nginx valgrind groff mandoc zsh faketime"
for option in "$@"; do
    case $option in
    --lint) packages="$packages $lint" ;;
    --bench) packages="$packages $bench" ;;
    --page) packages="$packages $page" ;;
    --promtool) packages="$packages $promtool" ;;
    --all) packages="$packages $lint $bench $promtool $tests" ;;
    *)
        echo "install-deps.sh: unknown option '$option' (allowed: --lint, --bench, --page, --promtool, --all)" >&2
        exit 2
        ;;
    esac
done

if ! command -v dpkg-query >/dev/null 2>&1; then
    echo "install-deps.sh: this is no Debian system; install the equivalents of:" $packages >&2
    exit 1
fi

missing=
for package in $packages; do
    status=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || :)
    [ "$status" = "install ok installed" ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

echo "installing:$missing"
as_root=
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 || {
        echo "install-deps.sh: run as root, or install sudo, or install these packages:$missing" >&2
        exit 1
    }
    as_root=sudo
fi
$as_root apt-get update -qq
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing
