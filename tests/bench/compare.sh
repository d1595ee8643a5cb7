#!/bin/sh
# SPDX-License-Identifier: MIT
# Times this tree against another revision: whole programs by the clock, interleaved.
#   compare.sh BUILD REVISION [FOLDER]        FOLDER is BUILD/compare by default
# Builds the revision in a worktree below FOLDER, which stays for the next run. Writes FOLDER/compare.json and
# FOLDER/compare.md. Both revisions render the same scenes; `bytes` says whether the pictures are equal. The
# environment may set SCENES, SIZE, RUNS and THREADS as for frames.sh.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:?usage: compare.sh BUILD REVISION [FOLDER]}
base=${2:?usage: compare.sh BUILD REVISION [FOLDER]}
folder=${3:-$build/compare}
. "$root/tests/bench/lib.sh"
scenes=${SCENES-builtin:room builtin:forest builtin:teapot parlour balls rings teapot}
runs=${RUNS:-5}
threads=${THREADS:-$(printf '1\n%s\n' "$(nproc)" | sort -nu)}
revision=$(git -C "$root" rev-parse --short "$base^{commit}")
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
build=$(cd "$build" && pwd)

tree=$folder/$revision
git -C "$root" worktree prune
[ -d "$tree" ] || git -C "$root" worktree add --detach "$tree" "$revision" >/dev/null
echo "building $revision" >&2
make -C "$tree" -j"$(nproc)" BUILD=build build/penumbra >"$folder/build.log" 2>&1 || {
    tail -n 20 "$folder/build.log" >&2
    exit 1
}

for scene in $scenes; do
    file=$folder/$(echo "$scene" | tr : -)
    make_scene "$scene" "$file.json" $(timed_size "$scene")
    for n in $threads; do
        printf '%s %s this\t%s render %s.json -q --threads %s -o %s-this.png\n' "$scene" "$n" "$build/penumbra" "$file" "$n" "$file"
        printf '%s %s base\t%s render %s.json -q --threads %s -o %s-base.png\n' "$scene" "$n" "$tree/build/penumbra" "$file" "$n" "$file"
    done
done >"$folder/commands"
"$build/tests/bench/time_runs" "$runs" <"$folder/commands" >"$folder/times.json"
for scene in $scenes; do
    file=$folder/$(echo "$scene" | tr : -)
    same=true
    cmp -s "$file-this.png" "$file-base.png" || same=false
    printf '{"scene": "%s", "same_bytes": %s}\n' "$scene" "$same"
done >"$folder/same"

jq -n --slurpfile times "$folder/times.json" --slurpfile same "$folder/same" --arg machine "$(machine)" \
    --arg date "$(date -u +%F)" --arg base "$revision" --argjson runs "$runs" \
    --arg this "$(git -C "$root" describe --always --dirty --exclude='*')" '
    {date: $date, machine: $machine, runs: $runs, base: $base, this: $this,
     rows: [$times[0][] | (.name / " ") as [$scene, $threads, $program] |
            {scene: $scene, threads: ($threads | tonumber), program: $program,
             same_bytes: ($same[] | select(.scene == $scene) | .same_bytes)} + del(.name)]}' >"$folder/compare.json"
jq -r '
    def round2: . * 100 | round / 100;
    def ms: . * 10 | round / 10;
    .rows as $rows |
    "\(.this) against \(.base), whole programs, medians of \(.runs) interleaved runs; \(.date), \(.machine).", "",
    "| scene | threads | \(.base), ms | this, ms | gain by the clock | of processor time | bytes |",
    "|---|---:|---:|---:|---:|---:|---|",
    ($rows[] | select(.program == "this") as $t | select(.program == "this") |
        ($rows[] | select(.program == "base" and .scene == $t.scene and .threads == $t.threads)) as $b |
        "| `\($t.scene)` | \($t.threads) | \($b.wall_ms | ms) | \($t.wall_ms | ms) | \($b.wall_ms / $t.wall_ms | round2)× | \($b.cpu_ms / $t.cpu_ms | round2)× | \(if $t.same_bytes then "equal" else "DIFFERENT" end) |")
' "$folder/compare.json" >"$folder/compare.md"
cat "$folder/compare.md"
