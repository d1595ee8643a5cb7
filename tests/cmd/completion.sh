#!/bin/sh
# SPDX-License-Identifier: MIT
# What bash completes for penumbra and penumbrad, against what the programs print: commands, options, values,
# built-in scenes, settings, views.
if [ ! -e "${1:-build}/completion/penumbra.bash" ]; then
    echo "skipped: a build with sanitizers is not for installing and has no completion"
    exit 77
fi
. "$(dirname "$0")/lib.sh"
PATH=$build:$PATH
cat >"$work/complete.bash" <<END
. "$build/completion/penumbra.bash"
COMP_LINE=\$1 COMP_POINT=\${#1}
_penumbra
[ \${#COMPREPLY[@]} -eq 0 ] || printf '%s\n' "\${COMPREPLY[@]}"
END
complete() { # LINE: prints the completions, a line each
    bash "$work/complete.bash" "$1"
}
gives() { # LINE WORDS
    expect "completes: $1" "$(complete "$1" | tr '\n' ' ')" "$2 "
}
long_options() {
    sed -n 's/^  \(-., \|    \)\(--[a-z-]*\) .*/\2/p' | sort
}

sh "$root/deploy/completion/table.sh" "$build" >"$work/table"
check "the build's table is up to date" diff "$work/table" "$build/completion/table"
commands=$("$penumbra" --help | sed -n '/^Exit codes/q; s/^  \([a-z]*\) .*/\1/p' | sort)
expect "there are commands" "$(($(echo "$commands" | wc -l) > 10))" 1
expect "commands" "$(complete 'penumbra ')" "$commands"
for command in $commands; do
    expect "options of $command" "$(complete "penumbra $command --")" \
        "$("$penumbra" "$command" --help | long_options)"
done
expect "options of penumbrad" "$(complete 'penumbrad --')" "$("$build/penumbrad" --help | long_options)"
for command in backup token; do
    expect "options of penumbrad $command" "$(complete "penumbrad $command --")" \
        "$("$build/penumbrad" $command --help | long_options)"
done

scenes=$("$penumbra" scenes | sed 's/ .*//' | sort)
cd "$work" || exit 1
expect "built-in scenes" "$(complete 'penumbra render builtin:')" "$scenes"
expect "and their names alone" "$(complete 'penumbra scenes ')" "$scenes"
expect "settings" "$(complete 'penumbra render x --set ' | tr -d = | sort)" \
    "$(jq -r '."$defs".render.properties | keys[] | select(. != "comment")' "$root/api/scene.schema.json" | sort)"
expect "views" "$(complete 'penumbra render builtin:forest -o x.png --view ')" \
    "$(jq -r '.views[].name' "$root/scenes/forest.json" | sort)"
"$penumbra" scenes forest -o forest.json
gives 'penumbra bench forest.json --view=l' 'left'
gives 'penumbra render fores' 'forest.json'
gives 'penumbra render builtin:te' 'teapot'
gives 'penumbra render x --set accel' 'accelerator='
gives 'penumbra render x --set accelerator=' 'auto cbr manual median none'
gives 'penumbra render x --set=transfer=l' 'linear'
gives 'penumbra bench x -m accelerator=none,m' 'none,manual none,median'
gives 'penumbra bench x --baseline accelerator=none,thr' 'none,threads='
gives 'penumbra render x --format ' 'pfm png png16'
gives 'penumbra list --state=r' 'running'
gives 'penumbra validate a.json b.json builtin:tea' 'teapot'
gives 'penumbrad --log-level ' 'debug error info warn'
gives 'penumbrad b' 'backup'
gives 'penumbrad token ' 'add list remove'
gives 'penumbrad token add ci --scope ' 'admin read submit'
expect "a new token has any name" "$(complete 'penumbrad token add ')" ""
gives 'penumbra render --threads 2 --quiet -o out.png builtin:sp' 'spheres'
expect "files are left to the shell" "$(complete 'penumbra render x -o ')" ""
expect "a flag waits for no value" "$(complete 'penumbra render --json builtin:tea')" teapot
touch '$(touch evil)' 'two words'
expect "names of files stay names" "$(complete 'penumbra render tw')" 'two\ words'
complete 'penumbra render ' >/dev/null
expect "and are never run" "$(ls evil 2>/dev/null)" ""
if command -v zsh >/dev/null; then
    check "zsh reads its script" zsh -n "$build/completion/penumbra.zsh"
else
    skip command-zsh "whether zsh reads its script"
fi
finish
