#!/bin/sh
# SPDX-License-Identifier: MIT
# Reads real models: models.sh BUILD [FOLDER]
# The files come from Debian packages, which are unpacked and not installed. FOLDER keeps them. Only
# `make check-all` runs this.
set -eu
build=${1:-build}
cd "$(dirname "$0")/../.."
folder=${2:-$build/models}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
chmod 755 "$work"
for package in glmark2-data:bunny.obj cura:UltimakerRobot_support.stl,farm2_platform.obj \
    assimp-testmodels:Wuson.ply,spider.obj,spider.mtl,Spider_ascii.stl,Spider_binary.stl,pond.0.ply; do
    names=$(echo "${package#*:}" | tr , ' ')
    for name in $names; do
        [ -e "$folder/$name" ] || break
    done
    [ ! -e "$folder/$name" ] || continue
    (cd "$work" && apt-get -qq download "${package%%:*}" && dpkg -x "${package%%:*}"_*.deb unpacked)
    for name in $names; do
        find "$work/unpacked" -type f -name "$name" -exec cp {} "$folder" \;
    done
done
PEN_MODELS=$folder "$build/tests/io/test_model_files"
