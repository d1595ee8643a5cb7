#!/bin/sh
# SPDX-License-Identifier: MIT
# Errors requested with target_error, against errors reached.
#   calibration.sh [BUILD [FOLDER]]     FOLDER is BUILD/calibration by default
# Writes into FOLDER the renders of each scene (tests/bench/calibration.c), a table and a chart. A row that
# breaks the promise is marked. The promise has two parts. Of all renders with targets of 0.005 or more, at
# least 95 % must reach theirs. The mean of a scene's errors must not be below a quarter of the target, unless
# the pilot alone met it. Exit status 1 if the promise is broken. The environment may set SCENES (names of the
# table below), SEEDS and TARGETS.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/calibration}
seeds=${SEEDS:-16}
targets=${TARGETS:-0.02 0.01 0.005 0.0025}
. "$root/tests/bench/lib.sh"
mkdir -p "$folder"
rm -f "$folder"/*.tsv

# Scene, width, height, samples of the references: with these, their errors are at most a fifth of the
# smallest target.
table='soft-shadow 120 75 1024
spheres 120 90 1024
glass 80 60 1024
gloss 80 60 2048
lens 80 60 16384
patterns 100 75 1024
forest 120 80 2048
teapot 120 80 1024
room 70 98 1024
room-soft 70 98 1024'

echo "$table" | while read -r scene width height samples; do
    case " ${SCENES:-$scene} " in *" $scene "*) ;; *) continue ;; esac
    make_scene "builtin:$scene" "$folder/scene.json" "$width" "$height"
    # shellcheck disable=SC2086 # a list
    "$build/tests/bench/calibration" "$samples" "$seeds" $targets <"$folder/scene.json" |
        sed "s/^/$scene	/" >"$folder/$scene.tsv"
    echo "$scene: $(wc -l <"$folder/$scene.tsv") renders" >&2
done

# One row for each scene and target.
# shellcheck disable=SC2046 # names without spaces
(cd "$folder" && cat $(echo "$table" | while read -r scene _; do
    [ -f "$scene.tsv" ] && echo "$scene.tsv"
done)) >"$folder/all.tsv"
awk -F '\t' '
    BEGIN {
        print "| scene | asked | reached, mean | reached / asked, least to most | estimated / reached | above the target | samples per pixel | reference |"
        print "|---|---:|---:|---:|---:|---:|---:|---:|"
    }
    function row() {
        mean = sum / n
        mark = (mean < asked / 4 && pilots < n) ? " (!)" : ""
        low = low || mark != ""
        printf "| %s | %g | %.5f%s | %.2f: %.2f to %.2f | %.2f | %d of %d%s | %.1f%s | %.5f |\n", scene, asked,
            mean, mark, mean / asked, least, most, estimates / sum, above, n, capped ? ", " capped " capped" : "",
            samples / n, pilots == n ? ", pilot" : "", reference
    }
    $1 != scene || $2 != asked {
        if (n) row()
        scene = $1; asked = $2; n = sum = estimates = above = samples = pilots = capped = most = 0; least = 1e9
    }
    {
        n++; sum += $4; estimates += $5; above += $4 > $2; samples += $11; pilots += $9 == 1; capped += $8 == 0
        if ($4 / $2 > most) most = $4 / $2
        if ($4 / $2 < least) least = $4 / $2
        reference = $13
        if ($2 >= 0.005) { promised++; kept += $4 <= $2 }
        renders++; reached += $4 <= $2; in_interval += $4 >= $6 && $4 <= $7
    }
    END {
        row()
        printf "\n%d of %d renders (%.1f %%) reach their target; of those with targets of 0.005 or more %d of %d (%.1f %%).\n",
            reached, renders, 100 * reached / renders, kept, promised, promised ? 100 * kept / promised : 100
        exit promised && (kept < 0.95 * promised || low)
    }' "$folder/all.tsv" >"$folder/calibration.md" && ok=0 || ok=1
cat "$folder/calibration.md"

# A column of dots for each scene and target: the ratio of the errors reached to that asked for.
awk -F '\t' '
    BEGIN { LEFT = 44; TOP = 16; HEIGHT = 260; STEP = 20; GAP = 12; MOST = 1.25 }
    function y(ratio) { return TOP + HEIGHT * (1 - (ratio < MOST ? ratio : MOST) / MOST) }
    $1 != scene || $2 != asked {
        if ($1 != scene) {
            x += GAP
            names = names sprintf("<text x=\"%g\" y=\"%g\">%s</text>\n", LEFT + x + 4, TOP + HEIGHT + 30, $1)
        }
        x += STEP; scene = $1; asked = $2
        names = names sprintf("<text x=\"%g\" y=\"%g\" class=\"target\">%g</text>\n", LEFT + x - STEP / 2, TOP + HEIGHT + 14, 1000 * asked)
    }
    {
        dots = dots sprintf("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2\"%s/>\n", LEFT + x - STEP / 2 + ($3 % 5 - 2) * 1.6,
            y($4 / $2), $4 > $2 ? " class=\"miss\"" : "")
    }
    END {
        width = LEFT + x + GAP
        printf "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" height=\"%d\">\n", width, TOP + HEIGHT + 44, width, TOP + HEIGHT + 44
        print "<style>svg{background:#fff}text{font:11px sans-serif;fill:#333}.target,.axis{fill:#666;font-size:9px}.target{text-anchor:middle}.axis{text-anchor:end}circle{fill:#26a;fill-opacity:.6}.miss{fill:#c22;fill-opacity:1}path{stroke:#ddd}.one{stroke:#333}</style>"
        for (r = 0; r <= MOST; r += 0.25)
            printf "<path d=\"M%d %.1fH%d\"%s/><text x=\"%d\" y=\"%.1f\" class=\"axis\">%.2f</text>\n", LEFT, y(r), width - GAP,
                r == 1 ? " class=\"one\"" : "", LEFT - 4, y(r) + 3, r
        printf "%s%s<text x=\"4\" y=\"11\">error reached / asked, each dot a render; below: asked, in thousandths</text>\n</svg>\n", dots, names
    }' "$folder/all.tsv" >"$folder/calibration.svg"
[ $ok = 0 ] || echo 'The promise is broken.' >&2
exit $ok
