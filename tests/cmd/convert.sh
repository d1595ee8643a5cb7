#!/bin/sh
# SPDX-License-Identifier: MIT
# Scenes in XML on the command line: render, validate, bench's reader and `penumbra convert`; no
# daemon.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
corpus=$root/tests/io/corpus
golden=$root/tests/golden

# Golden scenes, written in both dialects, are the same pictures, bit for bit
for xml in "$golden"/xml/*.xml; do
    name=$(basename "$xml" .xml)
    json=$golden/scenes/$name.json
    [ -e "$json" ] || json=$root/scenes/$name.json
    set -- --set width=61 --set height=43
    "$penumbra" render "$xml" -o x.pfm "$@" && "$penumbra" render "$json" -o j.pfm "$@"
    check "$name in XML is $name in JSON" cmp x.pfm j.pfm
done

# What convert writes renders to the same bytes, every view, at the scene's own settings
for xml in "$golden"/xml/*.xml "$corpus"/xml-good/*.xml; do
    name=$(basename "$xml" .xml)
    ends "convert $name" 0 "$penumbra" convert "$xml" converted.json
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

# Ways to say it
classroom=$corpus/xml-good/classroom.xml
"$penumbra" convert "$classroom" want.json
ends "-o" 0 "$penumbra" convert "$classroom" -o o.json
check "is the same" cmp o.json want.json
"$penumbra" convert - - <"$classroom" >pipe.json
check "standard input to standard output" cmp pipe.json want.json
cp "$classroom" scene
"$penumbra" convert scene other.json
check "a name without an ending" cmp other.json want.json
echo old >o.json
ends "an old file" 0 "$penumbra" convert "$classroom" o.json
check "is replaced whole" cmp o.json want.json
"$penumbra" convert builtin:spheres s.json
"$penumbra" render s.json -o a.png --set width=40 --set height=30
"$penumbra" render builtin:spheres -o b.png --set width=40 --set height=30
check "a built-in scene" cmp a.png b.png
"$penumbra" render - -o a.png --set width=40 --set height=30 <"$classroom"
"$penumbra" render "$classroom" -o b.png --set width=40 --set height=30
check "render from standard input" cmp a.png b.png
expect "the classroom's picture is encoded linearly" "$(jq -c .render want.json)" \
    '{"width":1000,"height":1000,"transfer":"linear"}'

sed -n '/^```xml$/,/^```$/p' "$root/README.md" | sed '1d;$d' >readme.xml
ends "the README's scene" 0 "$penumbra" validate readme.xml

# What is refused, and that nothing is written then
ends "no output" 2 "$penumbra" convert "$classroom"
says "says what is missing" stderr "missing OUT"
ends "two outputs" 2 "$penumbra" convert "$classroom" a.json -o b.json
says "says so" stderr '"a.json"'
ends "output in XML" 2 "$penumbra" convert "$classroom" out.xml
says "says that the output is JSON" stderr "the output is JSON"
ends "output that cannot be" 8 "$penumbra" convert "$classroom" none/out.json
ends "no such file" 4 "$penumbra" convert none.xml out.json
printf '<scene>\n  <geometries>\n    <sphere center="0 0 -9" radius="-1"/>\n  </geometries>\n</scene>\n' >bad.xml
ends "a bad scene" 3 "$penumbra" convert bad.xml bad.json
says "is placed" stderr \
    'penumbra: bad.xml:3:29: attribute "radius" of <sphere>: must be a number greater than 0, found -1'
check "and nothing is written" test ! -e bad.json
ends "a bad scene to render" 3 "$penumbra" render bad.xml -o bad.png
says "is placed" stderr "penumbra: bad.xml:3:29: "
ends "a bad scene to bench" 3 "$penumbra" bench bad.xml --matrix threads=1
says "is placed" stderr "penumbra: bad.xml:3:29: "
ends "a bad scene as JSON" 3 "$penumbra" validate bad.xml --json
expect "has lines in its problem" "$(jq -c '.errors[0] | [.line, .column, has("pointer")]' stdout)" \
    '[3,29,false]'
ends "notes on a scene" 0 "$penumbra" validate "$corpus/xml-good/notes.xml"
says "are placed" stderr 'notes.xml:4:29: warning: attribute "color" of <point>: '
ends "a bad view" 4 "$penumbra" render "$corpus/xml-good/views.xml" -o a.png --view lift
says "names the nearest" stderr 'nearest is "left"'
ends "too many pixels" 3 "$penumbra" render "$corpus/xml-good/views.xml" -o a.png --set width=100000 --set height=9999
cat >far.xml <<'SCENE'
<scene>
  <geometries>
    <sphere center="0 0 -9" radius="1"/>
    <sphere center="1e99 0 0" radius="1e-99"/>
  </geometries>
</scene>
SCENE
ends "what only freezing refuses" 3 "$penumbra" render far.xml -o a.png
says "is placed, too" stderr "penumbra: far.xml:4:5: <sphere>: "
echo '<scene/>' >xml.json
ends "XML in a .json" 3 "$penumbra" validate xml.json
says "is no JSON" stderr "is not JSON"
echo '{}' >json.xml
ends "JSON in a .xml" 3 "$penumbra" validate json.xml
says "is no XML" stderr "a scene in XML begins with <scene>"
head -c 17000000 /dev/zero | tr '\0' ' ' >big.xml
ends "a file over the limit" 3 "$penumbra" validate big.xml
finish
