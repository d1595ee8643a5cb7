#compdef penumbra penumbrad
# SPDX-License-Identifier: MIT
# zsh completion for penumbra and penumbrad.

local -a builtin_scenes=(@SCENES@) subcommands=(@COMMANDS@)
local -A choices=(@SETTINGS@)

_penumbra_scene() {
    local ret=1
    compadd -- builtin:$^builtin_scenes && ret=0
    _files && ret=0
    return ret
}

_penumbra_builtin() {
    compadd -- $builtin_scenes
}

# KEY=VALUE of a render setting.
_penumbra_setting() {
    if [[ $PREFIX == *=* ]]; then
        local key=${PREFIX%%=*}
        compset -P '*='
        compadd -- ${(s:|:)choices[$key]:#-}
    else
        compadd -S = -- ${(k)choices}
    fi
}

# KEY=VALUE,VALUE…
_penumbra_matrix() {
    if [[ $PREFIX == *=*,* ]]; then
        local key=${PREFIX%%=*}
        compset -P '*,'
        compadd -- ${(s:|:)choices[$key]:#-}
    else
        _penumbra_setting
    fi
}

# KEY=VALUE,KEY=VALUE…
_penumbra_row() {
    compset -P '*,'
    _penumbra_setting
}

# The views of the scene on the line.
_penumbra_view() {
    local word
    for word in ${words[2,-1]:#-*}; do
        compadd -- $($service convert ${~word} - 2>/dev/null |
            sed -n '/^  "views": \[/,/^  \]/s/^[ {]*"name": "\([A-Za-z0-9_-]*\)".*/\1/p') && return
    done
    return 1
}

# The options and arguments of each command.
@FUNCTIONS@

local curcontext=$curcontext state line ret=1
if [[ $service == penumbrad ]]; then
    if [[ $words[2] == (backup|check|token) && CURRENT -gt 2 ]]; then
        shift words
        (( CURRENT-- ))
        _penumbra_daemon_$words[1]
    else
        _penumbra_daemon '1:command:(backup check token)'
    fi
    return
fi
_arguments -C '(- *)'{-h,--help}'[print the help]' '(- *)--version[print the version]' \
    '1:command:->command' '*::argument:->argument' && ret=0
case $state in
command) _describe -t commands command subcommands && ret=0 ;;
argument) (( $+functions[_penumbra_command_$words[1]] )) && _penumbra_command_$words[1] && ret=0 ;;
esac
return ret
