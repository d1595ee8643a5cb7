#!/bin/sh
# SPDX-License-Identifier: MIT
# Model files as scenes and in scenes: rendered, converted, refused.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
mkdir -p models/sub other
cat >models/tetra.ply <<'END'
ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 4
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
0 0 1
3 0 2 1
3 0 1 3
3 0 3 2
3 1 2 3
END
cp models/tetra.ply models/sub/inner.ply
cp models/tetra.ply other/outside.ply
ln -s ../other/outside.ply models/link.ply
ln -s tetra.ply models/inside.ply
small="--set width=40 --set height=30"

# A model is a scene.
# shellcheck disable=SC2086
exits "render a model" 0 "$penumbra" render models/tetra.ply $small -o model.pfm -q
exits "convert it" 0 "$penumbra" convert models/tetra.ply models/scene.json
expect "the scene names the file" "$(jq -r '.objects[0].file' models/scene.json)" tetra.ply
# shellcheck disable=SC2086
exits "render the scene" 0 "$penumbra" render models/scene.json $small -o scene.pfm -q
check "to the same bytes" cmp model.pfm scene.pfm
check "the picture is not empty" test "$(tail -c +15 model.pfm | od -An -v -tx4 -w12 | sort -u | wc -l)" -gt 2
# Also if OUT is in a folder above; not if it is in another folder, where no file may be named.
mkdir -p up/sub other/sub
cp models/tetra.ply up/sub
jq '.objects = [{type: "group", objects: [.objects[0] | .file = "sub/inner.ply"]}]' models/scene.json >models/group.json
for out in 'up/sub/tetra.ply up/above.json' 'models/group.json ./above.json' 'models/tetra.ply -'; do
    rm -f stdout scene.pfm
    # shellcheck disable=SC2086
    exits "convert $out" 0 "$penumbra" convert $out
    [ "${out#* }" = - ] || cp "${out#* }" stdout
    cp stdout "$(dirname "${out#* }")/copy.json"
    # shellcheck disable=SC2086
    exits "render ${out#* }" 0 "$penumbra" render "$(dirname "${out#* }")/copy.json" $small -o scene.pfm -q
    check "to the same bytes" cmp model.pfm scene.pfm
done
for out in 'models/tetra.ply other/out.json' 'models/group.json other/out.json' 'models/tetra.ply model/out.json'; do
    mkdir -p model
    # shellcheck disable=SC2086
    exits "convert $out" 2 "$penumbra" convert $out
    prints "says where OUT may be" stderr "write OUT to the folder of SCENE"
    check "and writes nothing" test ! -e other/out.json
done
exits "a scene without files goes anywhere" 0 "$penumbra" convert builtin:spheres other/out.json
strange=models/$(printf 'a\377.ply')
cp models/tetra.ply "$strange"
exits "a name that is not UTF-8" 3 "$penumbra" render "$strange" -o x.png -q
prints "is told" stderr "the file's name is not UTF-8; rename it"
exits "a format that is not read" 3 "$penumbra" render models/tetra.fbx -o x.png -q
prints "names those that are" stderr "PLY, OBJ and STL, not as .fbx"
exits "validate it" 0 "$penumbra" validate models/tetra.ply
prints "is valid, and counts" stdout "models/tetra.ply: valid, meshes: 1, triangles: 4"
exits "validate it as JSON" 0 "$penumbra" validate models/tetra.ply --json
expect "counts meshes" "$(jq -c .meshes stdout)" '{"count":1,"triangles":4}'
# shellcheck disable=SC2086
exits "statistics of a model" 0 "$penumbra" render models/tetra.ply $small --stats stats.json -o x.png -q
expect "have bytes per triangle" "$(jq -c '.meshes | [.count, .triangles, .bytes_per_triangle > .tree_bytes_per_triangle,
    .tree_bytes_per_triangle > 11]' stats.json)" '[1,4,true,true]'
# shellcheck disable=SC2086
exits "statistics of another scene" 0 "$penumbra" render builtin:spheres $small --stats stats.json -o x.png -q
expect "have no meshes" "$(jq -c .meshes stats.json)" null

# The same triangles in the document are the same picture.
jq '.objects[0] = {type: "mesh", material: .objects[0].material,
    positions: [[0,0,0],[1,0,0],[0,1,0],[0,0,1]], faces: [[0,2,1],[0,1,3],[0,3,2],[1,2,3]]}' models/scene.json >inline.json
jq '.objects = [.objects[0] as $m | $m.faces[] | {type: "triangle", material: $m.material, vertices: map($m.positions[.])}]' \
    inline.json >triangles.json
for form in inline triangles; do
    # shellcheck disable=SC2086
    exits "render $form" 0 "$penumbra" render $form.json $small -o $form.pfm -q
    check "$form has the same bytes" cmp model.pfm $form.pfm
done
# Also of glass: the triangles of a closed mesh are one solid.
for form in inline triangles; do
    jq '.objects[].material = {kt: 0.9, ior: 1.5} | .background = {sky: {zenith: [1, 0, 0], horizon: [0, 1, 0]}}' $form.json >glass-$form.json
    # shellcheck disable=SC2086
    exits "render glass, $form" 0 "$penumbra" render glass-$form.json $small --stats $form-stats.json -o glass-$form.pfm -q
    expect "it refracts, $form" "$(jq -c '[(.effects | index("refraction") != null), .rays.transmission > 100, .unmatched_exits]' \
        $form-stats.json)" '[true,true,0]'
done
check "glass has the same bytes" cmp glass-inline.pfm glass-triangles.pfm
for accelerator in none cbr manual median; do
    # shellcheck disable=SC2086
    exits "render with $accelerator" 0 "$penumbra" render models/tetra.ply $small --set accelerator=$accelerator -o a.pfm -q
    check "$accelerator has the same bytes" cmp model.pfm a.pfm
done
# The up axis.
exits "up is z" 0 "$penumbra" convert models/tetra.ply up.json --up z
expect "of the camera" "$(jq -c .camera.up up.json) $(jq -c .camera.up models/scene.json)" "[0,0,1] [0,1,0]"

# Smooth normals: of a PLY, of an OBJ, in the document; none, and not wanted.
sed -e 's/^property float z$/&\nproperty float nx\nproperty float ny\nproperty float nz/' -e 's/^0 0 0$/& -1 -1 -1/' \
    -e 's/^1 0 0$/& 2 0 0/' -e 's/^0 1 0$/& 0 1 0/' -e 's/^0 0 1$/& 0 0 0.5/' models/tetra.ply >models/smooth.ply
cat >models/smooth.obj <<'END'
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
vn 0 0 .5
vn 0 1 0
vn 2 0 0
vn -1 -1 -1
f 1//4 3//2 2//3
f 1//4 2//3 4//1
f 1//4 4//1 3//2
f 2//3 3//2 4//1
END
for model in smooth.ply smooth.obj; do
    # shellcheck disable=SC2086
    exits "render $model" 0 "$penumbra" render models/$model $small -o $model.pfm -q
done
check "a PLY and an OBJ have the same bytes" cmp smooth.ply.pfm smooth.obj.pfm
check "which are not those of the flat model" sh -c '! cmp -s smooth.ply.pfm model.pfm'
jq '.objects[0] += {file: "smooth.obj", smooth: false}' models/scene.json >models/not_smooth.json
jq '.objects[0].normals = [[-1,-1,-1],[2,0,0],[0,1,0],[0,0,0.5]]' inline.json >inline_smooth.json
jq '.objects[0].smooth = false' inline_smooth.json >inline_flat.json
for scene in models/not_smooth inline_smooth inline_flat; do
    # shellcheck disable=SC2086
    exits "render $scene" 0 "$penumbra" render $scene.json $small -o ${scene#models/}.pfm -q
done
check "normals that are not wanted have no effect" cmp not_smooth.pfm model.pfm
check "nor in the document" cmp inline_flat.pfm model.pfm
check "normals in the document are those of the file" cmp inline_smooth.pfm smooth.ply.pfm
# Of several materials, a triangle takes two bytes more than of one.
printf 'newmtl a\nnewmtl b\n' >models/many.mtl
for count in 1 2; do
    awk -v count=$count 'BEGIN { print "mtllib many.mtl"; for (i = 0; i < 30000; i++) print "v", i % 3, int(i / 3) % 2 + i / 1e5, i / 7
        for (i = 0; i < 10000; i++) print (i == 0 ? "usemtl a\n" : i == 1 && count == 2 ? "usemtl b\n" : "") "f", 3*i + 1, 3*i + 2, 3*i + 3 }' \
        >models/many.obj
    exits "render $count materials" 0 "$penumbra" render models/many.obj --set width=1 --set height=1 --stats many$count.json -o x.png -q
done
expect "two bytes a triangle" "$(jq -s 'map(.meshes.bytes_per_triangle) | .[1] - .[0] | . > 1.9 and . < 2.2' many1.json many2.json)" true
# Warnings have the place in the scene and the line in the model.
{ printf 'l 1 2\n' && cat models/smooth.obj; } >models/lines.obj
jq '.objects[0].file = "lines.obj"' models/scene.json >models/lines.json
exits "a warning" 0 "$penumbra" render models/lines.json --set width=8 --set height=8 -o x.png
prints "has both places" stderr "/objects/0/file: warning: lines.obj:1:1: 1 statements are not read"
exits "its effects" 0 "$penumbra" explain models/smooth.ply
prints "name them" stdout "object mesh 0 has normals, and kd or ks > 0"

# Where a file may be.
refuses() { # NAME FILE CODE WORDS
    jq --arg file "$2" '.objects[0].file = $file' models/scene.json >models/bad.json
    exits "$1" "$3" "$penumbra" render models/bad.json -o x.png -q
    prints "$1 says why" stderr "$4"
}
exits "a folder below" 0 sh -c 'jq ".objects[0].file = \"sub/inner.ply\"" models/scene.json >models/below.json &&
    "$1" render models/below.json --set width=8 --set height=8 -o x.png -q' sh "$penumbra"
exits "a link inside" 0 "$penumbra" render models/inside.ply --set width=8 --set height=8 -o x.png -q
refuses "a folder above" ../other/outside.ply 11 "leads out of the scene's folder"
refuses "an absolute path" "$work/other/outside.ply" 11 "leads out of the scene's folder"
refuses "a link outside" link.ply 11 "is a link that leads out of the folder"
refuses "no such file" none.ply 4 'cannot open "none.ply"'
refuses "no model" scene.json 3 "its name must end in .ply, .obj or .stl"
printf 'ply\nformat ascii 1.0\nelement vertex 1\n' >models/broken.ply
exits "a broken model" 3 "$penumbra" render models/broken.ply -o x.png -q
prints "names the file" stderr "models/broken.ply"
exits "too many triangles" 3 "$penumbra" render models/tetra.ply --max-triangles 3 -o x.png -q
prints "says how many" stderr "3"
exits "more than a tree holds" 2 "$penumbra" render models/tetra.ply --max-triangles 67108864 -o x.png -q
prints "names the limit" stderr 67108863
exits "a model for a daemon" 3 "$penumbra" submit models/tetra.ply
prints "is not supported yet" stderr "not supported yet: a model on a daemon"
finish
