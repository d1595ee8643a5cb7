#!/bin/sh
# SPDX-License-Identifier: MIT
# Scenes in XML without a daemon: render, validate, bench and convert.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
corpus=$root/tests/io/corpus
golden=$root/tests/golden

# Golden scenes that exist in XML and JSON give the same pictures, bit for bit
for xml in "$golden"/xml/*.xml; do
    name=$(basename "$xml" .xml)
    json=$golden/scenes/$name.json
    [ -e "$json" ] || json=$root/scenes/$name.json
    set -- --set width=61 --set height=43
    "$penumbra" render "$xml" -o x.pfm "$@" && "$penumbra" render "$json" -o j.pfm "$@"
    check "$name gives the same picture in XML and JSON" cmp x.pfm j.pfm
done

# Other people's words for a scene give the picture of ours, bit for bit
for ours in "$corpus"/xml-spellings/*.ours.xml; do
    set -- --set width=61 --set height=43
    "$penumbra" render "$ours" -o ours.pfm "$@" && "$penumbra" render "${ours%.ours.xml}.xml" -o theirs.pfm "$@"
    check "$(basename "$ours" .ours.xml) gives the picture of our words" cmp ours.pfm theirs.pfm
done

# The output of convert renders to the same bytes, in every view, with the scene's own settings
for xml in "$golden"/xml/*.xml "$corpus"/xml-good/*.xml; do
    name=$(basename "$xml" .xml)
    exits "convert $name" 0 "$penumbra" convert "$xml" converted.json
    expect "$name: prints nothing" "$(cat stdout stderr)" ""
    views=$(jq -r '.views[]?.name' converted.json)
    for view in ${views:-main}; do
        "$penumbra" render "$xml" -o x.png --view "$view"
        "$penumbra" render converted.json -o c.png --view "$view"
        check "$name, $view: converted, the same picture" cmp x.png c.png
    done
    "$penumbra" convert converted.json again.json
    check "$name: converted again, the same text" cmp converted.json again.json
done

# Comments are kept
"$penumbra" convert "$corpus/xml-good/comments.xml" converted.json
expect "all comments of XML are there" "$(jq -c '[.. | objects | .comment? | strings] | sort' converted.json)" \
    '["all","c","g","k","l","m","n","o","r","s","t","v","w"]'
"$penumbra" convert "$corpus/good/comments.json" converted.json
expect "all comments of JSON are there" "$(jq '[.. | objects | .comment? | strings] | length' converted.json)" \
    "$(jq '[.. | objects | .comment? | strings] | length' "$corpus/good/comments.json")"
expect "and the schema" "$(jq -r '."$schema"' converted.json)" "https://example.org/scene.schema.json"

# Ways to name input and output
classroom=$corpus/xml-good/classroom.xml
"$penumbra" convert "$classroom" want.json
exits "convert -o" 0 "$penumbra" convert "$classroom" -o o.json
check "-o OUT equals the argument OUT" cmp o.json want.json
"$penumbra" convert - - <"$classroom" >pipe.json
check "convert from standard input to standard output" cmp pipe.json want.json
cp "$classroom" scene
"$penumbra" convert scene other.json
check "XML in a file without an ending" cmp other.json want.json
echo old >o.json
exits "convert over an existing file" 0 "$penumbra" convert "$classroom" o.json
check "the file is replaced as a whole" cmp o.json want.json
"$penumbra" convert builtin:spheres s.json
"$penumbra" render s.json -o a.png --set width=40 --set height=30
"$penumbra" render builtin:spheres -o b.png --set width=40 --set height=30
check "a built-in scene converted, the same picture" cmp a.png b.png
"$penumbra" render - -o a.png --set width=40 --set height=30 <"$classroom"
"$penumbra" render "$classroom" -o b.png --set width=40 --set height=30
check "render from standard input" cmp a.png b.png
expect "the classroom's colours are a screen's" "$(jq -c .render want.json)" \
    '{"width":1000,"height":1000,"transfer":"display"}'

sed -n '/^```xml$/,/^```$/p' "$root/scenes/README.md" | sed '1d;$d' >readme.xml
exits "the scene of scenes/README.md" 0 "$penumbra" validate readme.xml

# Errors, after which no output is written
exits "convert without an output" 2 "$penumbra" convert "$classroom"
prints "the error says that OUT is missing" stderr "missing OUT"
exits "convert with two outputs" 2 "$penumbra" convert "$classroom" a.json -o b.json
prints "the error names one of them" stderr '"a.json"'
exits "convert to XML" 2 "$penumbra" convert "$classroom" out.xml
prints "the error says that the output is JSON" stderr "the output is JSON"
exits "convert to a missing folder" 8 "$penumbra" convert "$classroom" none/out.json
exits "convert a missing file" 4 "$penumbra" convert none.xml out.json
printf '<scene>\n  <geometries>\n    <sphere center="0 0 -9" radius="-1"/>\n  </geometries>\n</scene>\n' >bad.xml
exits "convert an invalid scene" 3 "$penumbra" convert bad.xml bad.json
prints "the error has file, line and column" stderr \
    'penumbra: bad.xml:3:29: attribute "radius" of <sphere>: must be a number greater than 0, found -1'
check "no output is written" test ! -e bad.json
exits "render an invalid scene" 3 "$penumbra" render bad.xml -o bad.png
prints "the error has file, line and column" stderr "penumbra: bad.xml:3:29: "
exits "bench an invalid scene" 3 "$penumbra" bench bad.xml --matrix threads=1
prints "the error has file, line and column" stderr "penumbra: bad.xml:3:29: "
exits "validate an invalid scene with --json" 3 "$penumbra" validate bad.xml --json
expect "the problem document has line and column" "$(jq -c '.errors[0] | [.line, .column, has("pointer")]' stdout)" \
    '[3,29,false]'
exits "validate a scene with warnings" 0 "$penumbra" validate "$corpus/xml-good/notes.xml"
prints "the warnings have file, line and column" stderr 'notes.xml:4:29: warning: attribute "color" of <point>: '
exits "render an unknown view" 4 "$penumbra" render "$corpus/xml-good/views.xml" -o a.png --view lift
prints "the error names the nearest view" stderr 'nearest is "left"'
exits "render too many pixels" 3 "$penumbra" render "$corpus/xml-good/views.xml" -o a.png --set width=100000 --set height=9999
cat >far.xml <<'SCENE'
<scene>
  <geometries>
    <sphere center="0 0 -9" radius="1"/>
    <sphere center="1e99 0 0" radius="1e-99"/>
  </geometries>
</scene>
SCENE
exits "render a scene that only freezing refuses" 3 "$penumbra" render far.xml -o a.png
prints "the error has file, line and column, too" stderr "penumbra: far.xml:4:5: <sphere>: "
echo '<scene/>' >xml.json
exits "validate XML in a .json file" 3 "$penumbra" validate xml.json
prints "the error says that it is not JSON" stderr "is not JSON"
echo '{}' >json.xml
exits "validate JSON in a .xml file" 3 "$penumbra" validate json.xml
prints "the error says how XML begins" stderr "a scene in XML begins with <scene>"
head -c 17000000 /dev/zero | tr '\0' ' ' >big.xml
exits "validate a file over the size limit" 3 "$penumbra" validate big.xml
finish
