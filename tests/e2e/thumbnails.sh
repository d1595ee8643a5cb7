#!/bin/sh
# SPDX-License-Identifier: MIT
# A picture's small copies: their size, their light, their place in caches, and what they are refused for.
. "$(dirname "$0")/lib.sh"
daemon_start
look() { # prints the size and the light of the last answer
    python3 "$(dirname "$0")/png_mean.py" "$work/body"
}

submit '{"scene": "builtin:room", "layers": ["beauty", "depth"], "render": {"width": 75, "height": 105}}'
room=$job
submit '{"scene": "builtin:spheres", "render": {"width": 400, "height": 5}}'
flat=$job
call "$room?wait=60"
call "$flat?wait=60"
call "$room/image"
cp "$work/body" "$work/whole"
light=$(look | cut -d' ' -f3)

while read -r edge width height; do
    call "$room/image?max_edge=$edge"
    tag=$(header etag)
    expect "max-edge-$edge" "$status $(header content-type) $(header cache-control)" \
        "200 image/png private, max-age=86400, immutable"
    look >"$work/look"
    read -r is_width is_height is_light <"$work/look"
    expect "max-edge-$edge-size" "$is_width $is_height" "$width $height"
    expect "max-edge-$edge-has-the-light of $light" "$((is_light - light >= -2 && is_light - light <= 2))" 1
    cp "$work/body" "$work/first"
    call "$room/image?max_edge=$edge"
    expect "max-edge-$edge-again" "$(header etag) $(cmp "$work/body" "$work/first" && echo same)" "$tag same"
    call "$room/image?max_edge=$edge" -H "If-None-Match: $tag"
    expect "max-edge-$edge-not-modified" "$status" 304
done <<END
64 46 64
80 57 80
104 74 104
END
for edge in 105 512; do
    call "$room/image?max_edge=$edge"
    expect "max-edge-$edge-does-not-enlarge" "$status $(cmp "$work/body" "$work/whole" && echo same)" "200 same"
done
call "$flat/image?max_edge=64"
expect one-row-stays "$status $(look | cut -d' ' -f1,2)" "200 64 1"
call "$room/image?max_edge=64&view=all&format=png"
expect of-all-views "$status $(look | cut -d' ' -f1,2)" "200 46 64"
cp "$work/body" "$work/first"
call "$room/image?max_edge=64&layer=depth"
expect of-a-layer "$status $(look | cut -d' ' -f1,2) $(cmp -s "$work/body" "$work/first" || echo other)" \
    "200 46 64 other"
call "$room/image?max_edge=64" -H 'Range: bytes=0-7'
expect part "$status $(od -An -tx1 "$work/body" | tr -d ' \n')" "206 89504e470d0a1a0a"

for format in png16 pfm; do
    call "$room/image?max_edge=64&format=$format"
    expect_problem "no-small-$format" 400 '*max_edge*png*'
done
for edge in 63 513 0 -1 x 100.5 ''; do
    call "$room/image?max_edge=$edge"
    expect_problem "max_edge-$edge" 400 '*64 to 512*'
done
call "$room/image?max_edge=64&view=nowhere"
expect_problem no-such-view 404
call "$room/image?max_edge=64&layer=albedo"
expect_problem no-such-layer 404
submit "$long"
call "$job/image?max_edge=64"
expect_problem unfinished 409
expect unfinished-comes-later "$(header retry-after)" 1
call "$room" -X DELETE
call "$room/image?max_edge=64"
expect_problem removed 410
finish
