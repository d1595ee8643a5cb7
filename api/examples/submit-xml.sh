#!/bin/sh
# SPDX-License-Identifier: MIT
# Submits a scene in XML, a small one of its own without a file, and prints where the job is.
#   submit-xml.sh [SCENE.xml]
set -eu
url=${PENUMBRA_URL:-http://127.0.0.1:8080}

cat -- "${1:--}" <<'SCENE' |
<scene name="example" background-color="20 30 60">
  <ambient-light color="12 12 12"/>
  <camera position="0 2 9" look-at="0 1 0" fov-degrees="40" image="160 120"/>
  <lights><point color="255 230 200" position="4 7 5"/></lights>
  <geometries>
    <plane point="0 0 0" normal="0 1 0" kd="0.5"/>
    <sphere center="0 1 0" radius="1" kd="0.1" ks="0.8" shininess="150" kt="0.7"/>
  </geometries>
</scene>
SCENE
    curl -sS --fail-with-body -o /dev/null -w '%header{location}\n' "$url/v1/jobs" \
        -H 'Content-Type: application/xml' --data-binary @-
