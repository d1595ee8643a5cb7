#!/bin/sh
# SPDX-License-Identifier: MIT
# Two jobs compared: the figures and the map are those of `penumbra compare` on their PFM files.
. "$(dirname "$0")/lib.sh"
daemon_start
none=01890a5d-ac96-774b-bcce-b302099a8057

submit '{"scene": "builtin:room", "render": {"width": 40, "height": 56}}'
a=$job
submit '{"scene": "builtin:room", "render": {"width": 40, "height": 56, "samples_per_pixel": 4}}'
b=$job
submit '{"scene": "builtin:room", "render": {"width": 20, "height": 28}}'
tiny=$job
submit '{"scene": "builtin:spheres", "kind": "benchmark", "repeats": 1, "matrix": {"threads": [1]}, "render": {"width": 8, "height": 8}}'
report=$job
for job in "$a" "$b" "$tiny" "$report"; do
    call "$job?wait=60"
done
for job in a b; do
    eval "call \"\$$job/image?format=pfm\""
    cp "$work/body" "$work/$job.pfm"
done
id_of() {
    echo "${1##*/}"
}
"$build/penumbra" compare "$work/a.pfm" "$work/b.pfm" --json -o "$work/map.png" >"$work/figures"

call "$a/compare?with=$(id_of "$b")"
tag=$(header etag)
expect figures "$status $(header content-type) $(header cache-control) $(cmp "$work/body" "$work/figures" && echo same)" \
    "200 application/json private, max-age=86400, immutable same"
expect_match figures-differ "$(body '"\(.identical) \(.rmse) \(.flip) \(.ssim) \(.psnr)"')" 'false 0.0* 0.0* 0.* [23]*'
call "$a/compare?with=$(id_of "$b")" -H "If-None-Match: $tag"
expect not-modified "$status" 304
call "$a/compare?with=$(id_of "$b" | tr a-f A-F)&view=main&format=json"
expect upper-case "$status $(cmp "$work/body" "$work/figures" && echo same)" "200 same"
call "$a/compare?with=$(id_of "$b")&format=png"
expect map "$status $(header content-type) $(cmp "$work/body" "$work/map.png" && echo same)" "200 image/png same"
call "$b/compare?with=$(id_of "$a")"
"$build/penumbra" compare "$work/b.pfm" "$work/a.pfm" --json >"$work/figures"
expect other-way-round "$(cmp "$work/body" "$work/figures" && echo same)" same
call "$a/compare?with=$(id_of "$a")"
expect identical "$(body '"\(.identical) \(.rmse) \(.psnr) \(.ssim) \(.flip) \(.max_error) \(.differing) \(.pixels)"')" \
    "true 0 null 1 0 0 0 2240"

# Pictures of values for a screen are compared as shown.
submit '{"scene": "builtin:room", "render": {"width": 40, "height": 56, "transfer": "display"}}'
shown=$job
call "$shown?wait=60"
call "$shown/compare?with=$(id_of "$a")"
expect shown "$(body '"\(.identical) \(.tags_differ)"')" "true true"

call "$a/compare"
expect_problem without-with 400 '*with is missing*'
for with in x "$(id_of "$b")0" ''; do
    call "$a/compare?with=$with"
    expect_problem "with-$with" 400 '*the id of a job*'
done
call "$a/compare?with=$(id_of "$b")&format=pfm"
expect_problem format 400 '*json, png*'
call "$a/compare?with=$none"
expect_problem no-other-job 404 "*$none*"
call "/v1/jobs/$none/compare?with=$(id_of "$a")"
expect_problem no-job 404 "*$none*"
call "$a/compare?with=$(id_of "$b")&view=left"
expect_problem no-view 404 "*$(id_of "$a")*left*"
call "$a/compare?with=$(id_of "$b")&view=all"
expect_problem no-sheet 404
call "$a/compare?with=$(id_of "$report")"
expect_problem no-picture 404 "*$(id_of "$report")*benchmark*"
call "$a/compare?with=$(id_of "$tiny")"
expect_problem other-size 409 '*40 x 56*20 x 28*'
expect other-size-stays "$(header retry-after)" ''

submit "$long"
long=$job
for path in "$a/compare?with=$(id_of "$long")" "$long/compare?with=$(id_of "$a")" "$long/compare?with=$(id_of "$long")"; do
    call "$path"
    expect_problem unfinished 409 "*$(id_of "$long")*"
    expect unfinished-comes-later "$(header retry-after)" 1
done
call "$long/cancel" -X POST
call "$long?wait=60"
call "$a/compare?with=$(id_of "$long")"
expect_problem cancelled 409 '*cancelled*'
expect cancelled-never-comes "$(header retry-after)" ''
call "$b" -X DELETE
call "$a/compare?with=$(id_of "$b")"
expect_problem removed-other 410
call "$b/compare?with=$(id_of "$a")"
expect_problem removed 410
finish
