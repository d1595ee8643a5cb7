#!/bin/sh
# SPDX-License-Identifier: MIT
# Shows that the suite can fail. It builds the renderer with one mistake at a time. Each mistake must make the
# row fail that was written against it, and the same row must pass without it.
#   tests/property/mutants.sh BUILD [NAME…]      only these mutants
#   tests/property/mutants.sh BUILD --edits      builds nothing: does each edit still fit the source?
# A mistake is an edit that must change exactly as many lines as the list at the end states. An edit that no
# longer fits the source, or does not compile, is an error, not a kill. Writes BUILD/stability/mutants.json;
# exit 1 if a mutant survives or could not be judged. The environment may set MUTANTS_KEPT, a folder for this
# tree alone. Results of mutants are kept there and used again.
set -u
build=$1
shift
edits=
[ "${1:-}" != --edits ] || { edits=1 && shift; }
only=" $* "
cd "$(dirname "$0")/../.." || exit 2
dir=$build/mutants${edits:+-edits}
facts=$dir/facts
stability=build/tests/property/stability
films=build/tests/property/films
make="${MAKE:-make} BUILD=build"
unset MAKEFLAGS MAKELEVEL
survived=0 errors=0 killed=0 fit=0
mkdir -p "$dir/control" "$build/stability"
: >"$facts"

# What the renderer and the suite are made of; objects of an earlier run are of use.
for entry in "$dir"/* "$dir"/control/*; do
    case $entry in "$dir/control" | "$dir/control/build" | "$facts") ;; *) rm -rf "$entry" ;; esac
done
cp -a Makefile src "$dir/control"
[ -n "$edits" ] || {
    cp -a include scenes api deploy "$dir/control"
    mkdir "$dir/control/tests"
    cp -a tests/tests.mk tests/bench tests/property tests/support tests/golden tests/accel tests/geom tests/shade tests/scene tests/math \
        tests/render tests/io tests/study "$dir/control/tests"
    (cd "$dir/control" && $make -s -j"${JOBS:-$(nproc)}" $stability $films) >"$dir/control.log" 2>&1 || {
        tail -n 20 "$dir/control.log"
        echo "mutants: the source as it is does not build" >&2
        exit 2
    }
}

wrong() { # WHAT
    echo "ERROR    $name: $1"
    fact error "$1"
    errors=$((errors + 1))
    skip=1
}

fact() { # OUTCOME FIGURES
    [ -z "$edits" ] || return
    jq -nc --arg name "$name" --arg what "$what" --arg row "$row" --argjson cases "$cases" \
        --arg outcome "$1" --arg figures "$2" \
        '{id: "mutant", name: ("mutant_" + $name), what: $what, row: $row, outcome: $outcome,
          oracle: "\($row) must fail; \($outcome): \($figures)", cases: 1,
          failures: (if $outcome == "killed" then 0 else 1 end), why: "\($outcome): \($figures)",
          row_cases: $cases}' >>"$facts"
}

# mutant NAME ROW CASES WHAT: a copy of the built tree, to be edited; with --edits only of what is edited.
mutant() {
    name=$1 row=$2 cases=$3 what=$4
    case $only in "  " | *" $name "*) skip= ;; *) skip=1 ;; esac
    known=${MUTANTS_KEPT:+$MUTANTS_KEPT/$name}
    [ -z "$skip$edits" ] && [ -n "$known" ] && [ -s "$known" ] && {
        sed 's/^/(before) killed   /' "$known"
        fact killed "$(cat "$known")"
        killed=$((killed + 1)) skip=1
    }
    [ -n "$skip$edits" ] || cp -a "$dir/control" "$dir/$name"
}

# edit FILE LINES SED-SCRIPT
edit() {
    [ -z "$skip" ] || return
    file=$dir/$name/$1
    [ -f "$file" ] || {
        mkdir -p "$(dirname "$file")"
        cp "$dir/control/$1" "$file"
    }
    sed -E "$3" "$file" >"$dir/edited"
    changed=$(diff "$file" "$dir/edited" | grep -c '^>')
    [ "$changed" -eq "$2" ] || {
        wrong "the edit of $1 changes $changed lines, not $2"
        return
    }
    cat "$dir/edited" >"$file"
}

# run_row TREE CASES ROW: what the row found there, with the stored cases, which are the rarest, as JSON;
# nothing if it found nothing.
run_row() {
    rm -f "$dir/$1/build/$3/report.json"
    (cd "$dir/$1" && timeout 300 $stability --rows "$3" --cases "$2" --jobs 1 --no-price \
        --corpus tests/property/corpus/worst.txt --out "build/$3") >"$dir/$1.out" 2>&1
    jq -c --arg row "$3" '.rows[] | select(.test == $row and .verdict != "not run") |
        {cases, failures, crashed, why: (.failed[0].why // "")}' "$dir/$1/build/$3/report.json" 2>>"$dir/$1.out"
}

# Builds the targets, with the variables of make that are given among them.
build_mutant() {
    [ -z "$skip" ] || return
    [ -z "$edits" ] || {
        rm -rf "${dir:?}/$name"
        skip=1 fit=$((fit + 1))
        return
    }
    (cd "$dir/$name" && $make -s -j"${JOBS:-$(nproc)}" "$@") >"$dir/$name.log" 2>&1 ||
        wrong "does not compile: $(grep -m1 -E 'error|Error' "$dir/$name.log")"
}

verdict() { # KILLED FIGURES
    if [ "$1" = yes ]; then
        echo "killed   $name by $row: $2"
        fact killed "$2"
        killed=$((killed + 1))
        [ -z "$known" ] || echo "$name by $row: $2" >"$known"
    else
        echo "SURVIVED $name: $row: $2"
        fact survived "$2"
        survived=$((survived + 1))
    fi
    rm -rf "${dir:?}/$name"
}

# judge [VARIABLE=VALUE…]: builds the mutant and runs the row on it and on the control.
judge() {
    build_mutant $stability "$@"
    [ -z "$skip" ] || return
    control=$(run_row control "$cases" "$row")
    [ "$(printf '%s' "$control" | jq '.failures + .crashed == 0 and .cases > 0')" = true ] || {
        wrong "$row does not pass without it: ${control:-no result}"
        return
    }
    found=$(run_row "$name" "$cases" "$row")
    [ -n "$found" ] || {
        wrong "$row came to no end: $(tail -n 1 "$dir/$name.out")"
        return
    }
    verdict "$(printf '%s' "$found" | jq -r 'if .failures + .crashed > 0 then "yes" else "no" end')" \
        "$(printf '%s' "$found" | jq -r '"\(.failures) of \(.cases) cases" +
            (if .crashed > 0 then ", ended by a signal" else "" end) +
            (if .why != "" then ": " + .why else "" end)')"
}

# judge_test: the unit test that the row names must fail.
judge_test() {
    build_mutant "build/tests/$row"
    [ -z "$skip" ] || return
    (cd "$dir/control" && $make -s "build/tests/$row" && "build/tests/$row") >"$dir/control.out" 2>&1 || {
        wrong "$row does not pass without it"
        return
    }
    (cd "$dir/$name" && timeout 300 "build/tests/$row") >"$dir/$name.out" 2>&1
    status=$?
    if [ $status -eq 124 ]; then
        wrong "$row came to no end in five minutes"
    elif [ $status -eq 0 ]; then
        verdict no "passes"
    else
        verdict yes "$(grep -m1 -E '^[0-9]+%' "$dir/$name.out")"
    fi
}

# Compares the accumulators of all golden films, which a film of floats would hide, with ours.
judge_films() {
    build_mutant $films "$@"
    [ -z "$skip" ] || return
    for tree in control "$name"; do
        (cd "$dir/$tree" && $films) >"$dir/$tree.plain" 2>/dev/null
        [ -s "$dir/$tree.plain" ] || {
            wrong "the films cannot be rendered"
            return
        }
    done
    count=$(wc -l <"$dir/control.plain")
    beside=$(diff "$dir/control.plain" "$dir/$name.plain" | grep -c '^>')
    verdict "$([ "$beside" -gt 0 ] && echo yes || echo no)" \
        "$beside of $count films have other accumulators than ours"
}

# judge_libm: the accumulators of the golden films, beside the control's and without FMA and AVX2.
judge_libm() {
    build_mutant $films
    [ -z "$skip" ] || return
    for tree in control "$name"; do
        (cd "$dir/$tree" && $films) >"$dir/$tree.plain" 2>/dev/null
        (cd "$dir/$tree" && GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4 $films) \
            >"$dir/$tree.masked" 2>/dev/null
        [ -s "$dir/$tree.plain" ] && [ -s "$dir/$tree.masked" ] || {
            wrong "the films cannot be rendered"
            return
        }
    done
    cmp -s "$dir/control.plain" "$dir/control.masked" || {
        wrong "$row does not pass without it: films depend on glibc's choice"
        return
    }
    count=$(wc -l <"$dir/control.plain")
    beside=$(diff "$dir/control.plain" "$dir/$name.plain" | grep -c '^>')
    masked=$(diff "$dir/$name.plain" "$dir/$name.masked" | grep -c '^>')
    verdict "$([ $((beside + masked)) -gt 0 ] && echo yes || echo no)" \
        "$masked of $count films have other accumulators with glibc's FMA masked off, $beside than ours"
}

# The mutants.
mutant contraction h095_trees 20000 "products and sums are contracted (-ffp-contract=fast)"
[ -n "$skip" ] || rm -rf "$dir/$name/build/src"
judge PIXEL_FLAGS="-std=c11 -ffp-contract=fast -fno-math-errno"

mutant fused h104_libm 0 "every file has FMA, and products and sums are contracted"
[ -n "$skip" ] || rm -rf "$dir/$name/build/src"
judge_films PIXEL_FLAGS="-std=c11 -mfma -ffp-contract=fast -fno-math-errno"

mutant strict_edges h038_watertight 20000 "a triangle does not own its edges"
edit src/geom/triangle.h 1 \
    's/^    return pen_edge_counts\(a, b, w\).* != 0;$/    return (w > 0 \&\& u > 0 \&\& v > 0) || (w < 0 \&\& u < 0 \&\& v < 0);/'
edit src/accel/internal/blocks_avx2.h 1 \
    's/^    unsigned lanes = bits\(_mm256_xor_pd\(up, down\)\);$/& lanes \&= bits(_mm256_and_pd(LESS(zero, ew), _mm256_and_pd(LESS(zero, eu), LESS(zero, ev)))) | bits(_mm256_and_pd(LESS(ew, zero), _mm256_and_pd(LESS(eu, zero), LESS(ev, zero))));/'
judge

mutant tmin h063_thin_shell 20000 "intersections count from t = 1e-4 on"
edit src/accel/build.c 1 's/pen_after_start = \{0,/pen_after_start = {1e-4,/'
edit src/accel/internal/prim_test.h 1 's/if \(!\(t > 0 && t < query->tmax\)\)/if (!(t > 1e-4 \&\& t < query->tmax))/'
judge

mutant boxes_to_nearest h091_planes 2000 "boxes are rounded to the nearest float, not outward"
edit src/accel/tree_layout.c 2 's/pen_float_(down|up)\(/pen_float_near(/g'
judge

mutant strict_culling h097_copies 40 "a box is entered where its distance is < the best t, not <="
edit src/accel/internal/boxes_avx2.h 3 's/_CMP_LE_OQ/_CMP_LT_OQ/'
edit src/accel/internal/boxes_base.h 1 's/return t0 <= t1;/return t0 < t1;/'
edit src/accel/internal/traverse_wide.h 1 's/near > limit/near >= limit/'
judge

mutant origin_offset h063_thin_shell 20000 "secondary rays start 1e-4 off the surface, along its normal"
edit src/geom/prims.c 1 's/^(    struct pen_vec3 p = pen_along\(ray->o, ray->d, hit.t\));$/\1, n = pen_prim_normal(prims, hit, p); p = pen_along(p, n, 1e-4); return p;/'
judge

mutant tie_epsilon h063_thin_shell 20000 "intersections closer than 1e-9 are one, in document order"
edit src/geom/ray.h 1 's/if \(a\.t != b\.t\)/if (fabs(a.t - b.t) > 1e-9)/'
judge

mutant small_box h091_planes 2000 "the box of a sphere is too small by 1e-6 of its radius"
edit src/geom/sphere.c 1 's/pen_vec3\(s->r, s->r, s->r\)/pen_scale(pen_vec3(s->r, s->r, s->r), 1 - 1e-6)/'
judge

mutant shadow_at_0 h094_shadow_span 5000 "an intersection at t = 0 is a shadow"
edit src/accel/internal/prim_test.h 1 's/if \(!\(t > 0 && t < query->tmax\)\)/if (!(t >= 0 \&\& t < query->tmax))/'
judge

mutant no_origin_surface h059_leave_round 20000 "a ray does not know its origin surface"
edit src/geom/self_intersection.c 1 's/^    if \(prim == origin->prim\) \{$/    origin = \&pen_origin_none;\n&/'
judge

mutant one_way_back rooms_mixed 3000 "after a second mirror the side that the path came from is forgotten"
edit src/geom/prims.h 1 's/^            origin\.before = pen_add\(left->toward, back\);$/            origin.before = back;/'
judge

mutant line_decides h073_at_seams 1000 "at borders near its start the line of a ray decides what it hits"
edit src/geom/self_intersection.c 1 's/^        if \(passes_border\(/        if (0 \&\& passes_border(/'
judge

mutant plain_determinant h041_antisymmetry 20000 "ab - cd without fma"
edit src/math/exact.h 1 's/^    return f \+ e;$/    return (void)f, (void)e, a * b - w;/'
judge

mutant vanishing h091_vanishing 100000 "coordinates of vertices may be so small that products vanish"
edit src/geom/ray.h 1 's/^#define PEN_LEAST 0x1p-300/#define PEN_LEAST 0x1p-1074/'
judge

mutant corner_order h078_mirrored_triangle 20000 "a triangle's corners stay in the order they come in"
edit src/geom/triangle.c 1 's/^    int first = pen_triangle_first_corner\(v\);$/    int first = 0 * pen_triangle_first_corner(v);/'
judge

mutant rounded_normal h043_needle_thin 20000 "normals of needles stay as double-double gives them"
edit src/geom/internal/facet.h 1 's/^    if \(pen_largest3\(dd_round3\(\*normal\)\) > least\)$/    if (pen_largest3(dd_round3(*normal)) > 0 * least)/'
judge

mutant nearly_flat o1_transform 20000 "a map that nearly flattens space cannot be inverted"
edit src/math/transform.c 1 's/^    return all_finite\(f\) && pen_transform_orientation\(f\) != 0;$/    return all_finite(f) \&\& fabs(pen_dot2(column(f, 0), pen_cross(column(f, 1), column(f, 2)))) > 1e-12;/'
judge

mutant grid_centre h121_grid_points 20000 "a grid without a point in the disk has the centre"
edit src/shade/internal/light_points.h 1 's/^    if \(p->first >= .*cells\)$/    if (cells > 0)/'
judge

mutant axis_order h079_permuted 100000 "sums for spheres are taken in the order of the axes' names"
edit src/geom/sphere.h 1 \
    's/^    struct pen_vec3 o = ray->permuted_o, d = ray->permuted_d, c = .*$/    struct pen_vec3 o = ray->o, d = ray->d, c = s->c;/'
judge

mutant no_rim h073_round_rooms 3000 "an open cylinder ends where it was told to"
edit src/geom/cylinder.c 1 's/^    c->rim = c->caps .*$/    c->rim = 0;/'
judge

mutant rim_of_local h073_round_rooms 1000 "rims reach out by the rounding of local coordinates alone"
edit src/scene/freeze_prims.c 1 's/^    from\.rounding = rounding_of\(.*$/    from.rounding = 0 * rounding_of(\&f->frame, from.point);/'
judge

mutant rim_no_border h073_round_rooms 500 "passing a rim within rounding is decided by the line"
edit src/geom/self_intersection.c 1 's/^    if \(!fn->passes_rim \|\| !fn/    if (PEN_U > 0 || !fn->passes_rim || !fn/'
judge

mutant ends_at_origin floor_rooms 50 "a light on the floor is seen through it from the foot of a wall"
edit src/geom/self_intersection.c 1 's/^    if \(hit\.t <= PEN_LAST_LAYER_T\)$/    if (hit.t < 0)/'
judge

mutant along_caps rooms_round 30 "a disk packet knows where rays along a cap pass its plane"
edit src/accel/internal/disk_packet_classify.h 1 's/ = oblique & slanting & / = oblique \& /'
judge

mutant glass_order scenes_same 100 "a disk packet multiplies what glass lets pass in the reverse order"
edit src/accel/internal/disk_packet_order.h 1 's/sequence\[i\]\[k\] = /sequence[i][list->count - 1 - k] = /'
judge

mutant strange_arithmetic h105_mxcsr 60 "render threads keep the floating-point state they inherit"
edit src/base/thread_pool.c 1 's/^        fesetenv\(FE_DFL_ENV\);$//'
judge

mutant cone_digits o1_cone 20000 "a cone's side is never found in twice the precision"
edit src/geom/cone.c 1 's/^    if \(!\(4 \* \(k \* k\) < mm\)\)$/    if (!(k * k < mm))/'
edit src/geom/cone.c 1 's/^    if \(8 \* fabs\(wp\) < widest \|\| .*$/    if (0 * widest > 0 ||/'
edit src/geom/cone.c 1 's/^        fabs\(fabs\(tp\) - h\) < ray->near \* h\)$/        fabs(fabs(tp) - h) < 0)/'
judge

mutant cone_middle o1_cone 20000 "roots of a cone are found from the origin where they are close together"
edit src/geom/cone.c 1 's/^    if \(!\(4 \* discriminant.*$/    if (true)/'
judge

mutant cone_nappe o1_cone 20000 "a steep ray meets the nappe of a cone on which the radius is negative"
edit src/geom/cone.c 1 's/^    else if \(e->grows > 0\)$/    else if (e->grows < 0)/'
judge

mutant cone_inward cone_left 20000 "a ray that leaves a cone's side goes inward where it should go outward"
edit src/geom/cone.c 1 's/^    bool inward = apex \? e\.grows > 0 : e\.b\.hi < 0;$/    bool inward = apex ? e.grows > 0 : e.b.hi > 0;/'
judge

mutant cone_apex rooms_round 6000 "at a cone's apex, rays are mirrored and lit though no side is known"
edit src/shade/internal/surface.h 1 's/^    return lanes_less\(lanes_splat\(0\), s->unsure\) .*$/    return lane_mask_of(0);/'
judge

mutant cone_box cone_boxes 20000 "the box of a cone holds its base, not its top"
edit src/geom/cone.c 2 's/^    b = pen_box_add_point\(b, pen_along\(top, rim, -?top_radius\)\);$/    b = pen_box_add_point(b, pen_along(top, rim, -0.0 * top_radius));/'
judge

mutant tree_uncut h112_path_tree 300 "a tree of paths is cut 100 000 surfaces too late"
edit src/shade/internal/kernel_body.h 1 's/--scratch->surfaces_left == 0/--scratch->surfaces_left == -100000/'
judge

mutant tree_order h112_path_tree 300 "the path that has waited longest continues first"
edit src/shade/internal/kernel_body.h 1 \
    's/^(        )\*path = scratch->waiting\[--\*waiting\];$/\1*path = scratch->waiting[0], scratch->waiting[0] = scratch->waiting[--*waiting];/'
edit src/shade/scratch.c 1 's/scratch->waiting = calloc\(scratch->depth, /scratch->waiting = calloc(scratch->depth + 8192, /'
judge

mutant tree_uncounted h112_path_tree 300 "of the paths cut off only the transmitted one is counted"
edit src/shade/internal/kernel_body.h 1 's/uint64_t reflected = \(uint64_t\)waiting, /uint64_t reflected = 0, /'
judge

mutant light_beside horizon_walls 1000 "a floor contains a light in its plane that is beside it"
edit src/geom/self_intersection.c 1 \
    's/^    return pen_surface_contains\(s, s\.fn->normal\(s\.self, hit\.part, p\), p, b\);$/    return true;/'
judge

mutant plane_behind rooms_same 6000 "in vectors, a polygon that contains the origin is dropped if met behind it"
edit src/accel/internal/prim_test.h 1 's/ && !trace->reaches_origin\)\)\)$/)))/'
judge

mutant layers_swapped layers_gap 500 "a ray that stays on its side of a layer meets the later ones"
edit src/geom/contact.c 1 's/^    if \(earlier != \(q < p\)\)$/    if (earlier == (q < p))/'
judge

mutant layers_ascending layers_gap 2000 "layers at a ray's start are met in document order whichever way it goes"
edit src/geom/contact.c 1 's/^    return PEN_FIRST_T \* \(1\.0 \+ .*$/    return PEN_FIRST_T * (1.0 + q);/'
judge

mutant layers_of_seams layers_paid 2000 "neighbours in one plane are layers of one another at their seam"
edit src/geom/contact.c 1 's/^           pen_covers\(&pair\);$/           true;/'
judge

mutant layers_at_p rooms_thin 100 "whether two surfaces coincide is decided anew at each point"
edit src/geom/contact.c 1 \
    's/pen_prim_may_coincide\(c->prims, pair\.a, pair\.b\)/true/'
judge

mutant start_exact rooms_thin 200 "a path is taken to have begun exactly where it says"
edit src/geom/contact.c 1 's/^    return fabs\(wn\) <= rounding \? 0 : wn;$/    return rounding < 0 ? 0 : wn;/'
judge

mutant round_corner rooms_flat 100 "a path that comes round a corner is taken for one behind the wall"
edit src/geom/contact.c 1 's/^    bool round_corner = /    bool round_corner = 0 * /'
judge

mutant point_beside rooms_thin 100 "a hit point may lie beside its outline"
edit src/shade/internal/surface.h 1 's/^(    const lane_mask slanting = ).*$/\1lane_mask_of(0);/'
judge

mutant mirror_grazing rooms_crossing 3000 "a ray that grazes a mirror is reflected"
edit src/shade/internal/secondary_rays.h 1 's/lanes_less\(lanes_splat\(PEN_HORIZON_SINE\), -s->nv\)/lane_mask_of(LANES_ALL)/'
judge

mutant goes_back_grazing rooms_thin 100 "a ray goes back however low over a wall it is"
edit src/geom/contact.c 1 's/ \(!pen_grazes\(c->n, d\) && / (/'
judge

mutant border_in_plane rooms_thin 100 "borders in a plane that contains the start of the ray are not looked at"
edit src/geom/self_intersection.c 1 's/^        if \(\*t > 0 && \*t \* \*t <= end\)$/        if (false)/'
judge

mutant layers_by_t layers_first 500 "rounding decides which of two coincident surfaces a ray meets first"
edit src/shade/internal/kernel_body.h 1 's/^    if \(first && first\[/    if (0 \&\& first[/'
judge

mutant horizon_sine horizon_walls 1000 "light counts however low over the tangent plane it is"
edit src/geom/ray.h 1 's/^#define PEN_HORIZON_SINE \(2 \/ PEN_NEARBY\)/#define PEN_HORIZON_SINE (0 \/ PEN_NEARBY)/'
judge

mutant horizon_grazing horizon_disk 200 "a sample that grazes is taken for one above the horizon"
edit src/shade/internal/soft_shadow.h 1 's/^    if \(!\(lane_mask_bits\(side\.above .*$/    if (false)/'
judge

mutant tied_rays h079_permuted_tied 20000 "rays whose components are equal in size are not refined"
edit src/geom/ray_lanes.h 1 's/^        \.near = lanes_select\(untied, .*$/        .near = lanes_splat(PEN_NEAR),/'
judge

mutant not_cut bent_rooms 1000 "how far vertices are off the plane counts as rounding, however far"
edit src/geom/polygon.c 1 's/^    if \(p->facet\.grazing < INFINITY \|\| /&true || /'
judge

mutant cut_left bent_rooms 6000 "a ray that starts on a polygon never meets it again, though it is cut"
edit src/geom/self_intersection.c 1 's/^    if \(prim == origin->prim && origin->through\)$/    if (prim == origin->prim)/'
judge

mutant hardly_left rooms_flat 100 "a point in a corner brings light although no rule tells where it is"
edit src/shade/internal/surface.h 1 's/^    if \(path\[0\]->depth > 0\) \{$/    if (false) {/'
judge

mutant corner_blocks corner_blocks 2000 "blocks render samples that meet a corner themselves"
edit src/shade/internal/block_wave.h 1 's/^            finite &= ~lane_mask_bits\(b->surface\[g\]\.corner\);$/            (void)0;/'
judge

mutant corner_moves corners 2000 "no ray is moved out of a corner"
edit src/shade/internal/corners.h 1 's/CORNER_MOVES = 28/CORNER_MOVES = 1/'
judge

mutant corner_turn corners 2000 "a ray is moved in one direction only"
edit src/shade/corners.c 1 's/^        x = turned;$/        x = turned, y = x;/'
judge

mutant corner_step corners 2000 "a ray is moved by some bounds only"
edit src/shade/corners.c 1 's/STEP = 16/STEP = -4/'
judge

mutant corner_bounds corner_chains 40000 "a corner ends where one rounding may bring a path"
edit src/shade/internal/corners.h 1 's/CORNER_BOUNDS 0x1p12/CORNER_BOUNDS 0x1p4/'
judge

mutant corner_along corner_chains 40000 "a path along a face is in no corner"
edit src/shade/internal/surface.h 1 's/lanes_at_most\(-s->nv, lanes_splat\(PEN_HORIZON_SINE\)\);/lane_mask_of(0);/'
judge

mutant corner_wall corner_rooms 40000 "an eye may be moved through a wall"
edit src/shade/corners.c 1 's/hit\.t <= 2\)\)/hit.t <= 0))/'
judge

mutant corner_rays shade/test_corners 0 "rays of all attempts count"
edit src/shade/internal/kernel_body.h 1 's/^        \*counts = before;$/        (void)before;/'
judge_test

mutant height_of_vertex floor_foot 20000 "heights over a plane are taken from a vertex, however far that is"
edit src/geom/internal/contact.h 1 \
    's/^    return pen_dot\(n, pen_sub\(p, s\.fn->project\(.*$/    return pen_dot(n, pen_sub(p, pen_surface_outline(s).count ? pen_surface_outline(s).v[0] : s.fn->project(s.self, PEN_PART_SIDE, p)));/'
judge

mutant seen_at_seam floor_foot 20000 "a ray that starts in a facet's plane is met where it is seen to enter"
edit src/geom/self_intersection.c 1 's/^ *\(hit\.t > 0 && fabs\(pen_height_above.*$/false);/'
edit src/accel/internal/prim_test.h 1 's/^    if \(!off && trace->from_surface && t > 0\)$/    if (false)/'
judge

mutant open_end h066_round_lid 2000 "a point in the plane of an open end, off the side, counts as on it"
edit src/geom/cone.c 1 's/^    if \(on == 0 && !c->hull\.caps\)$/    if (false)/'
judge

mutant cap_rim h073_round_rooms 90 "the line decides whether a ray enters a closed cone at the rim of its cap"
edit src/geom/cone.c 1 's/^    if \(c->hull\.caps && passes_cap_rim.*$/    if (false)/'
judge

mutant far_corner convex_lit 200 "a face that rises only far away, by rounding, is met at its border"
edit src/geom/self_intersection.c 1 's/ : pen_contact_rises_nearby\(&c, ray->d\);$/ : pen_contact_rises(\&c, ray->d);/'
judge

mutant joint convex_lit 200 "at the joint of a column, a ray meets the next cylinder within the rim of its cap"
edit src/geom/self_intersection.c 1 's/^    return !pen_contact_rises\(&c, ray->d\);$/    return false \&\& !pen_contact_rises(\&c, ray->d);/'
judge

mutant beam_margin rooms_same 20000 "rays of a packet are enclosed without a margin"
edit src/accel/internal/ray_group_begin.h 1 's/ margin = 0x1p-18 \* most \+ / margin = 0 * most + /'
judge

mutant packet_border rooms_same 20000 "in a packet, the line decides whether a ray passes a border near its start"
edit src/accel/internal/ray_group_outline.h 1 's/^    const unsigned fallback = unsure & \(w\.ties \| w\.border\);$/    const unsigned fallback = unsure \& w.ties;/'
judge

mutant packet_light accel/test_ray_packet 0 "a packet counts the surface that contains the light"
edit src/accel/internal/ray_packet_query.h 1 's/^    if \(!g->to_point \|\| !group_light_on\(g, prim\)\) \{$/    if (true) {/'
judge_test

mutant outline_distance accel/test_ray_packet 0 "the sides of edges that rays pass are computed exactly"
edit src/accel/internal/ray_group_begin.h 1 's/0x1p-44 \* x \+/0x1p-80 * x +/'
judge_test

mutant outline_concurrent accel/test_ray_packet 0 "rays to a light pass exactly through it"
edit src/accel/internal/ray_group_begin.h 1 's/\(g->concurrent \? 3 \* moved : 0\)/0/'
judge_test

mutant outline_convex accel/test_ray_packet 0 "an outline is convex exactly, or not at all"
edit src/accel/internal/ray_group_outline.h 1 's/0x1p-35 \* outline->extent/0/'
judge_test

mutant outline_reflex accel/test_ray_packet 0 "all outlines are convex"
edit src/accel/pack_boxes.c 1 's/^            if \(!\(left >= -tolerance .*$/            if (false)/'
judge_test

mutant outline_border accel/test_ray_packet 0 "the line decides whether a ray that starts near a border passes outside"
edit src/accel/internal/ray_group_outline.h 1 's/\(near \? 32 \* g->most_slack : 0\)/0/'
judge_test

mutant round_roots accel/test_ray_packet 0 "the roots at hand are those that the scalar test refines to"
edit src/accel/internal/ray_group_round.h 1 's/lanes_splat\(0x1p-42\) \* size/lanes_splat(0x1p-90) * size/'
judge_test

mutant round_touching accel/test_ray_packet 0 "a ray that may touch a round primitive meets it nowhere else than at its middle"
edit src/accel/internal/ray_group_round.h 1 's/lanes_splat\(0x1p-20\) \*/lanes_splat(0) */'
judge_test

mutant cylinder_beyond accel/test_ray_packet 0 "rays just inside a cylinder pass it"
edit src/accel/internal/ray_group_round.h 1 's/lanes_splat\(1\.0625 \*/lanes_splat(0.99 */'
judge_test

mutant cylinder_thin accel/test_ray_packet 0 "how far a ray passes an axis is computed exactly"
edit src/accel/internal/ray_group_round.h 1 's/lanes_splat\(0x1p-42 \* g->extent\)/lanes_splat(0)/'
judge_test

mutant cylinder_slab accel/test_ray_packet 0 "the ends of a slab at hand are those that the scalar test refines to"
edit src/accel/internal/ray_group_round.h 1 's/lanes_splat\(0x1p-40\) \* \(f_size/lanes_splat(0) * (f_size/'
judge_test

mutant rim_packets accel/test_ray_packet 0 "a packet knows where rays along a rim pass the plane of its cap"
edit src/accel/internal/ray_group_round.h 1 's/^    const lanes before = x->hi - x->pad;$/    const lanes before = x->hi;/'
edit src/accel/internal/ray_group_round.h 1 's/lanes_less\(x->lo \+ x->pad, x->side\.t0\) & last/lanes_less(x->lo, x->side.t0) \& last/'
judge_test

mutant rim_blocks accel/test_ray_packet 0 "in vectors, a ray along a rim knows where it passes the plane of the cap"
edit src/accel/internal/blocks_avx2.h 1 's/~ends_on_side4\(trace, &side, &slab, pad, /~ends_on_side4(trace, \&side, \&slab, zero, /'
judge_test

mutant lens_wide golden/test_blur 0 "a lens is 3 % wider"
edit src/scene/camera.c 1 's/^    const double radius = (pen_scale2\(v->camera\.aperture_radius.*);$/    const double radius = 1.03 * \1;/'
judge_test

mutant cone_wide golden/test_blur 0 "the cone of blurred rays is 3 % wider"
edit src/scene/freeze.c 1 's/pen_sincos_deg\(0\.5 \* degrees/pen_sincos_deg(0.515 * degrees/'
judge_test

mutant snell_sine shade/test_snell 0 "the refracted cosine comes from the sine alone"
edit src/shade/internal/snell.h 1 's/= c \* c - difference \* \(s \* s\);/= (one - e * s) * (one + e * s);/'
judge_test

mutant media_stays shade/test_media 0 "a path stays in the solids that it has left"
edit src/shade/internal/media.h 1 's/^(    m->count = )kept;$/\1m->count + 0 * kept;/'
judge_test

mutant faces_unturned scene/test_solids 0 "the faces of a solid that is inside out are not turned"
edit src/scene/solid_faces.c 1 's/volume\[face\[i\]\.solid\] < 0/volume[face[i].solid] < -1e300/'
judge_test

mutant pattern_lower shade/test_patterns 0 "the cell of a point is decided by rounding"
edit src/shade/patterns.c 1 's/p->at\[i\] \+ p->off\[i\]/p->at[i]/'
judge_test

mutant libm_pow h104_libm 0 "highlights are glibc's pow"
edit src/math/lanes_fn.h 7 \
    's/^    const lane_mask nothing = lanes_at_most\(x, .*$/    double p[LANES], q[LANES];\n    lanes_store(p, x);\n    lanes_store(q, y);\n    for (int i = 0; i < LANES; i++)\n        p[i] = pow(p[i], q[i]);\n    if (1)\n        return lanes_load(p);\n&/'
judge_libm

# Adaptive rendering: estimates, decisions and rounds.
mutant adaptive_own render/test_adaptive 0 "what is refined is chosen by a pixel's own estimate, not by its neighbours'"
edit src/render/decide.c 1 's/^            const double around = error_around\(a, pass, x, y\);$/            const double around = (double)a->errors[at] + 0 * error_around(a, pass, x, y);/'
judge_test

mutant adaptive_unseen render/test_decide 0 "an edge that no sample has seen does not exist"
edit src/render/decide.c 1 's/^(static const double UNSEEN = ).*$/\10;/'
judge_test

mutant beam_weights render/test_beams 0 "samples that look for things count as much as others"
edit src/render/beam_samples.c 1 's/return within \? 1 \/ density : 0;/return within ? density \/ density : 0;/'
judge_test

mutant beam_part render/test_beams 0 "what samples may not have seen of things does not count"
edit src/render/beam_samples.c 1 's/^(    const double part = )view->times/\10 * view->times/'
judge_test

mutant beam_evidence render/test_beams 0 "samples that agree are evidence"
edit src/render/adaptive.c 1 's/^    return (\(double\)a->estimates\[pixel\]\.error <= apart)/    return a->settings->seed + 1 == 0 \&\& \1/'
judge_test

mutant beam_hidden render/test_beams 0 "samples look for things that are hidden"
edit src/render/beam_hidden.c 1 's/^            b->share = 0;/            b->share *= 1;/'
judge_test

mutant beam_triangles render/test_beams 0 "small triangles are all taken for facets of a surface"
edit src/render/beams.c 1 's/if \(i != prim && share_a_corner/if (share_a_corner/'
judge_test

mutant beam_glass render/test_beams 0 "glass hides what is behind it"
edit src/render/beam_hidden.c 1 's/if \(pen_scene_see_through\(scene, prim\)\)/if (pen_scene_see_through(scene, prim) \&\& prim > 1u << 30)/'
judge_test

mutant beam_highlights render/test_beams 0 "highlights are nowhere looked for"
edit src/render/internal/beam_bounds.h 1 's/^(#define PEN_BEAM_NARROW )100$/\11e99/'
judge_test

mutant beam_round render/test_beams 0 "round mirrors show no lamps"
edit src/render/beam_images.c 1 's/^        for \(uint32_t k = 0; k < scene->prims\.count; k\+\+\)$/        for (uint32_t k = 0; k < 0 * scene->prims.count; k++)/'
judge_test

mutant adaptive_unseen_rate render/test_decide 0 "an unseen edge is as uncertain as independent samples leave it"
edit src/render/decide.c 1 's/UNSEEN \/ 3 \* pen_pow\(4, -i\)/UNSEEN \/ 3 * pen_pow(2, -i)/'
judge_test

mutant adaptive_variance render/test_decide 0 "halves tell half of what they should"
edit src/render/adaptive.c 1 's/return apart \* apart \+/return apart * apart \/ 2 +/'
judge_test

mutant adaptive_one render/test_decide 0 "the variance of one half is taken for that of the mean"
edit src/render/adaptive.c 1 's/return apart \* apart \+/return 2 * apart * apart +/'
judge_test

mutant adaptive_curve render/test_decide 0 "what the curve of the transfer function adds to an error is left out"
edit src/render/adaptive.c 1 's/ \+ curved \* curved;/ + 0 * curved;/'
judge_test

mutant adaptive_linear render/test_decide 0 "errors are those of linear values"
edit src/render/adaptive.c 1 's/^(    const enum pen_transfer transfer = )pen_settings_transfer.*$/\1PEN_TRANSFER_LINEAR;/'
judge_test

mutant adaptive_clamp render/test_decide 0 "values that are estimated are not clamped"
edit src/render/adaptive.c 2 's/pen_encode_unit_near\((.*), transfer\)/(transfer == PEN_TRANSFER_LINEAR ? (\1) : pen_encode_unit_near(\1, transfer))/'
judge_test

mutant adaptive_narrow render/test_decide 0 "the interval of an error has 68 %"
edit src/render/decide.c 1 's/^(static const double SPREAD = ).*$/\11;/'
judge_test

mutant adaptive_below render/test_decide 0 "the interval of an error has no upper side"
edit src/render/decide.c 1 's/ high = mean \+ off / high = mean + 0 * off /'
judge_test

mutant adaptive_lucky render/test_decide 0 "the target is met when the estimate meets it"
edit src/render/decide.c 1 's/\.met = high <= goal/.met = mean <= goal/'
judge_test

mutant adaptive_capped render/test_decide 0 "pixels that may have no more samples are not counted"
edit src/render/decide.c 1 's/^( *slice->capped \+= )around > 0;/\10;/'
judge_test

mutant adaptive_left render/test_decide 0 "the error that capped pixels leave is forgotten"
edit src/render/decide.c 1 's/^( *slice->capped_error \+= )around;/\10;/'
judge_test

mutant adaptive_most render/test_adaptive 0 "pixels may have twice max_samples"
edit src/render/decide.c 1 's/return 2\.0 \* a->sums/return 1.0 * a->sums/'
judge_test

mutant adaptive_half render/test_adaptive 0 "pixels may have half of max_samples"
edit src/render/decide.c 1 's/return 2\.0 \* a->sums/return 4.0 * a->sums/'
judge_test

mutant adaptive_order render/test_decide 0 "each thread adds up the slices that it takes, and the order is that of threads"
edit src/render/decide.c 7 's/^        pass->visit\(pass->adaptive, pass, &pass->slices\[i\]\);$/    {\n        struct slice *mine = \&pass->slices[thread];\n        const int height = pass->adaptive->settings->height;\n        mine->first_row = (int)((int64_t)height * i \/ pass->slice_count);\n        mine->end_row = (int)((int64_t)height * (i + 1) \/ pass->slice_count);\n        pass->visit(pass->adaptive, pass, mine);\n    }/'
judge_test

mutant adaptive_uniform render/test_decide 0 "all pixels get the same number of samples"
edit src/render/decide.c 1 's/(a->wanted\[at\] = a->priority\[at\] > )level;/\1 0 * level;/'
judge_test

mutant adaptive_least render/test_decide 0 "rounds have no least size"
edit src/render/decide.c 1 's/^(static const double LEAST_ROUND = )1\.0 \/ 32;/\10;/'
judge_test

mutant adaptive_pilot io/test_limits 0 "fine pictures begin with as few samples as coarse ones"
edit src/scene/settings.c 1 's/return settings->target_error < fine \? 4 : 2;/return settings->target_error < fine ? 2 : 2;/'
judge_test

mutant adaptive_all render/test_adaptive 0 "a round refines every pixel"
edit src/render/refine.c 1 's/!task->adaptive->wanted\[at\]\)/false)/'
judge_test

mutant adaptive_level render/test_adaptive 0 "a round refines pixels whatever their priority"
edit src/render/rounds.c 1 's/(\.level = repeat .*) : d->level\};/\1 : 0 * d->level};/'
judge_test

mutant adaptive_again render/test_adaptive 0 "a doubling takes the samples again that were taken"
edit src/render/refine.c 1 's/r->replicate, index, NULL\};/r->replicate, index - r->first, NULL};/'
judge_test

mutant adaptive_lights render/test_adaptive 0 "each camera ray takes the same points on a light"
edit src/shade/internal/block_body.h 1 's/b->ray\[i\] = samples\[i\]\.index;/b->ray[i] = 0 * samples[i].index;/'
judge_test

mutant adaptive_shared render/test_audit 0 "the sequences of an audit share their scrambling"
edit src/shade/internal/pixel_sample.h 1 's/PEN_SAMPLE_REPLICATE \+ sample->replicate,/PEN_SAMPLE_REPLICATE,/'
edit src/shade/internal/block_body.h 1 's/PEN_SAMPLE_REPLICATE \+ samples\[i\]\.replicate;/PEN_SAMPLE_REPLICATE;/'
judge_test

mutant adaptive_triple render/test_adaptive 0 "a round triples the samples"
edit src/render/adaptive.c 1 's/^    return sums->samples;$/    return 2 * sums->samples;/'
judge_test

mutant adaptive_halves render/test_adaptive 0 "samples belong to the second half from the first quarter on"
edit src/render/refine.c 1 's/ = index >= r->end \/ 2;/ = index >= r->end \/ 4;/'
judge_test

mutant adaptive_told render/test_decide 0 "what halves tell is never too much"
edit src/render/decide.c 1 's/return ratio < 2 \? 1 : 1 - /return ratio < 1e9 ? 1 : 1 - /'
judge_test

mutant adaptive_smooth render/test_decide 0 "errors fall faster than those of edges"
edit src/render/decide.c 1 's/\(ratio < most \? ratio : most\)/(ratio + 0 * most)/'
judge_test

mutant adaptive_worse render/test_decide 0 "samples are worse than independent ones"
edit src/render/decide.c 1 's/return ratio < 2 \? 1 : 1 - /return ratio < 0 ? 1 : 1 - /'
judge_test

mutant adaptive_surely render/test_decide 0 "the ratio of two doublings has no interval"
edit src/render/decide.c 1 's/before \/ after \* \(1 - off\),/before \/ after * (1 + 0 * off),/'
judge_test

mutant adaptive_curved render/test_decide 0 "all pixels are taken to fall by the same factor"
edit src/render/decide.c 1 's/return ratio < 2 \? 1 : 1 - .*$/return ratio < 2 ? 1 : 1 \/ ((ratio < most ? ratio : most) - 1);/'
judge_test

mutant adaptive_forgets render/test_adaptive 0 "the error before a doubling is not noted"
edit src/render/adaptive.c 1 's/^    sums->before = a->estimates\[pixel\]\.error;$//'
judge_test

mutant adaptive_rays render/test_adaptive 0 "the statistics have the rays of the last round only"
edit src/render/rounds.c 1 's/^    pen_ray_counts_add\(&sum->rays, &more->rays\);$/    sum->rays = more->rays;/'
judge_test

mutant adaptive_spread render/test_decide 0 "95 % of the pixels is what half of them is"
edit src/render/adaptive.c 1 's/if \(20 \* seen < 19 \* pixels\)/if (20 * seen < 10 * pixels)/'
judge_test

# Audits.
mutant audit_undecided render/test_audit 0 "undecided pixels count as right"
edit src/render/audit.c 1 's/not_right = audit->wrong \+ audit->undecided;/not_right = audit->wrong;/'
judge_test

mutant audit_two_sided render/test_audit 0 "the bound is two-sided"
edit src/render/audit.c 1 's/chance = 0\.05,/chance = 0.025,/'
judge_test

mutant audit_share render/test_audit 0 "the bound is the share that was found"
edit src/render/audit.c 1 's/^    audit->bound = job\.count == pixels \? /    audit->bound = true ? /'
judge_test

mutant audit_narrow render/test_audit 0 "the interval of a pixel has 95 %"
edit src/render/audit.c 1 's/^(static const double STUDENT = ).*$/\12.3646;/'
judge_test

mutant audit_wide render/test_audit 0 "the interval is that of one replicate, not of their mean"
edit src/render/audit.c 1 's/ \/ \(PEN_AUDIT_REPLICATES - 1\) \/ PEN_AUDIT_REPLICATES\);/ \/ (PEN_AUDIT_REPLICATES - 1));/'
judge_test

mutant audit_linear render/test_audit 0 "linear values are compared"
edit src/render/audit.c 1 's/^(    const enum pen_transfer transfer = )pen_settings_transfer.*$/\1PEN_TRANSFER_LINEAR;/'
judge_test

mutant audit_replaced render/test_audit 0 "pixels are drawn again"
edit src/render/audit.c 1 's/^        if \(!taken\[at\]\)$/        if (true)/'
judge_test

mutant audit_same render/test_audit 0 "the same pixels are drawn, whatever the seed"
edit src/render/audit.c 1 's/first = pen_mix64\(job->task->seed\);/first = pen_mix64(0);/'
judge_test

mutant audit_few render/test_audit 0 "pixels are rendered again with their own number of samples"
edit src/render/audit.h 1 's/PEN_AUDIT_TIMES = 64,/PEN_AUDIT_TIMES = 1,/'
judge_test

mutant audit_seed study/test_hash 0 "the seed is that of a part of the picture"
edit src/study/hash.c 1 's/\(const unsigned char \*\)film->rgb, values \* sizeof \*film->rgb\)/(const unsigned char *)film->rgb, values)/'
judge_test

mutant audit_seed_fixed study/test_hash 0 "the seed is that of no picture"
edit src/study/hash.c 1 's/\(const unsigned char \*\)film->rgb, values \* sizeof \*film->rgb\)/(const unsigned char *)film->rgb, 0 * values)/'
judge_test

# Verdicts on times.
mutant verdict_rank study/test_verdict 0 "the interval of a median is one rank too narrow"
edit src/study/verdict.c 1 's/2 \* \(below \+ term\) <= alpha/2 * below <= alpha/'
judge_test

mutant verdict_wide study/test_verdict 0 "the interval of a median is one rank too wide"
edit src/study/verdict.c 1 's/^(    const int k = pen_median_rank\(count, alpha\) - spoiled);/\1 - 1;/'
judge_test

mutant verdict_high study/test_verdict 0 "the upper end of the interval is one rank off"
edit src/study/verdict.c 1 's/out\.high = values\[count - k\];/out.high = values[count - k - 1];/'
judge_test

mutant verdict_side study/test_verdict 0 "the interval may err on either side as often as on both"
edit src/study/verdict.c 1 's/2 \* \(below \+ term\) <= alpha/below + term <= alpha/'
judge_test

mutant verdict_looks study/test_verdict 0 "each look may err as often as all together"
edit src/study/verdict.c 1 's/return ldexp\(0\.05, -\(look \+ 1\)\);/return 0.05 + 0 * look;/'
judge_test

mutant verdict_doublings study/test_verdict 0 "looks are at every ten values"
edit src/study/verdict.c 1 's/pairs < count; pairs \*= 2\)/pairs < count; pairs += PEN_PAIRS_MIN)/'
judge_test

mutant verdict_spoiled study/test_verdict 0 "spoiled values move no ranks"
edit src/study/verdict.c 1 's/pen_median_rank\(count, alpha\) - spoiled;/pen_median_rank(count, alpha);/'
judge_test

mutant verdict_effect study/test_verdict 0 "half of the least effect is enough"
edit src/study/verdict.c 1 's/above = 1 \+ least_effect,/above = 1 + least_effect \/ 2,/'
judge_test

mutant equal_volumes h147_equal_solids 4000 "volumes are compared to the last bit"
edit src/scene/freeze_solids.c 1 's/SAME_VOLUME = 1e-12/SAME_VOLUME = 0/'
judge

mutant cap_closed h148_joints 4000 "lines along a cap meet nothing there"
edit src/geom/cylinder.c 1 's/return \(up \? above >= -c->joint : above > 0\) && \(up \? below > 0 : below >= -c->joint\);/return above > 0 \&\& below > 0;/'
judge

mutant cap_apart h148_joints 4000 "caps that rounding sets apart are not joined"
edit src/geom/cylinder.c 1 's/c->joint = c->caps \? .*;/c->joint = 0;/'
judge

mutant eye_on_glass shade/test_eyes 0 "an eye on glass stays there"
edit src/scene/freeze_eyes.c 1 's/^    leave_surfaces\(f, view\);$//'
judge_test

mutant eye_in_gaps shade/test_eyes 0 "what does not close contains nothing"
edit src/scene/solid.c 1 's/return surrounds\(prims, solids, s, p\);/return false;/'
judge_test

mutant tube_around shade/test_media 0 "a ball that touches its tube from inside is not met through it"
edit src/geom/contact.c 1 's/lies == 0 \|\| \(lies < 0 && side > 0 && is_curved\(c\)\) \? side : lies/lies == 0 ? side : lies/'
judge_test

mutant verdict_quotient study/test_verdict 0 "a quotient of intervals is that of their ends"
edit src/study/verdict.c 1 's/out\.low = a->low \/ b->high;/out.low = a->low \/ b->low;/'
judge_test

mutant bench_looks study/test_bench 0 "a benchmark ends whenever its interval is narrow enough"
edit src/study/bench.c 1 's/pairs <= PEN_PAIRS_MAX; pairs \*= 2\)/pairs <= PEN_PAIRS_MAX; pairs += PEN_PAIRS_MIN)/'
judge_test

mutant calibrated_ratio study/test_comparison 0 "times of a slower host are multiplied by its slowness"
edit src/study/comparison.c 1 's/return before > 0 && after > 0 \? after \/ before : 0;/return before > 0 \&\& after > 0 ? before \/ after : 0;/'
judge_test

mutant calibrated_verdict study/test_comparison 0 "a verdict stands though the host itself has become slower"
edit src/study/comparison.c 1 's/if \(pen_verdict_of\(&calibrated, least\) == verdict\)/if (true)/'
judge_test

mutant calibration_part study/test_bench 0 "a calibration takes no rays"
edit src/study/calibration.c 1 's/i < RAYS; i\+\+/i < 0 * RAYS; i++/'
judge_test

mutant mesh_outside mesh_closed 4000 "boxes of meshes hold facets that are grazed from far away"
edit src/accel/internal/mesh_box.h 1 's/: 0x1p-38f \* distance/: 0x1p-50f * distance/'
judge

mutant mesh_beside accel/test_mesh_bounds 0 "a lane that is passed within rounding is unsure"
edit src/accel/internal/mesh_ray.h 1 's/56 \* 0x1p-24f/0 * 0x1p-24f/'
judge_test

mutant mesh_depth accel/test_mesh_bounds 0 "the depth of a lane has a bound"
edit src/accel/internal/mesh_ray.h 1 's/48 \* 0x1p-24f/0 * 0x1p-24f/'
judge_test

mutant mesh_distance accel/test_mesh_bounds 0 "rays from far away are less certain"
edit src/accel/internal/mesh_ray.h 1 's/0x1p-48f \* \(box->distance/0x0p-48f * (box->distance/'
judge_test

mutant mesh_planes accel/test_mesh_bounds 0 "planes of boxes have a margin"
edit src/accel/internal/mesh_box.h 1 's/0x1p-20f \* \(far/0x0p-20f * (far/'
judge_test

[ -z "$edits" ] || {
    echo "$fit mutants fit the source, $errors do not"
    [ "$errors" -eq 0 ] && [ "$fit" -gt 0 ]
    exit
}
jq -s '{killed: map(select(.outcome == "killed")) | length, total: length, rows: .}' "$facts" \
    >"$build/stability/mutants.json"
echo "$killed killed, $survived survived, $errors could not be judged"
[ $((survived + errors)) -eq 0 ] && [ "$killed" -gt 0 ]
