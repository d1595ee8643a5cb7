# SPDX-License-Identifier: MIT
# bash completion for penumbra and penumbrad.

# What the programs take, a line each: "scene NAME", "setting KEY CHOICES", "PROGRAM COMMAND : ARGUMENTS"
# and "PROGRAM COMMAND OPTION VALUE CHOICES". COMMAND is - for the program itself; an empty field is -.
_penumbra_table='@TABLE@'

# The rest of the table's lines that begin with these fields.
_penumbra_rows() {
    local row
    while IFS= read -r row; do
        [[ $row == "$* "* ]] && printf '%s\n' "${row#"$* "}"
    done <<<"$_penumbra_table"
}

_penumbra_commands() { # PROGRAM
    _penumbra_rows "$1" | sed -n 's/ : .*//p' | grep -vx -e -
}

# Render settings: KEY=, or KEY=VALUE for each value if the key is there.
_penumbra_settings() { # WORD
    local key choices
    _penumbra_rows setting | while read -r key choices; do
        if [[ $1 != *=* ]]; then
            printf '%s=\n' "$key"
        elif [[ $1 == "$key="* && $choices != - ]]; then
            printf "$key=%s\n" ${choices//|/ }
        fi
    done
}

# The views of a scene, which is a file or built in.
_penumbra_views() { # PROGRAM SCENE
    [[ -n $2 ]] && "${1/#\~/$HOME}" convert "${2/#\~/$HOME}" - 2>/dev/null |
        sed -n '/^  "views": \[/,/^  \]/s/^[ {]*"name": "\([A-Za-z0-9_-]*\)".*/\1/p'
}

_penumbra_files() { # WORD
    local file
    compgen -f -- "$1" | while IFS= read -r file; do
        [[ -d $file ]] && file=$file/
        printf '%q\n' "$file"
    done
}

# Words for the value of an option. Where there are none, bash completes file names.
_penumbra_value() { # PROGRAM OPTION VALUE CHOICES SCENE WORD
    local head=${6%"${6##*,}"}
    if [[ $4 != - ]]; then
        printf '%s\n' ${4//|/ }
    elif [[ $2 == --view ]]; then
        _penumbra_views "$1" "$5"
    elif [[ $2 == --matrix && $head == *=* ]]; then
        _penumbra_settings "${head%%=*}=" | sed "s/^[^=]*=/$head/"
    elif [[ $2 == --set || $2 == --matrix || $2 == --baseline ]]; then
        _penumbra_settings "${6##*,}" | sed "s/^/$head/"
    fi
}

# Words for an argument, of which `count` others come before it, as in "SCENE OUT" or "SCENE…".
_penumbra_argument() { # PROGRAM COMMAND COUNT WORD
    local names name
    read -ra names <<<"$(_penumbra_rows "$1" "$2" :)"
    name=${names[$3]}
    [[ -z $name && ${names[${#names[@]} - 1]} == *… ]] && name=${names[${#names[@]} - 1]}
    case $name in
    SCENE*)
        printf 'builtin:%s\n' $(_penumbra_rows scene)
        _penumbra_files "$4"
        ;;
    *'|'*) printf '%s\n' ${name//|/ } ;;
    '[NAME]') [[ $1 == penumbra ]] && _penumbra_rows scene ;;
    esac
}

# The long name of an option that takes a value, nothing for others.
_penumbra_option() { # PROGRAM COMMAND WORD
    local long value
    read -r long value <<<"$(_penumbra_rows "$1" "$2" "$3")"
    case $long in
    -) ;;
    --*) _penumbra_option "$1" "$2" "$long" ;;
    ?*) printf '%s\n' "$3" ;;
    esac
}

# Reads the words before the one to complete into variables of the caller.
_penumbra_read() { # WORD…
    local word
    for word; do
        if [[ -n $option ]]; then
            option=
        elif [[ $word == -* ]]; then
            option=$(_penumbra_option "$program" "$command" "$word")
        else
            [[ $((++count)) -eq 1 ]] && scene=$word
        fi
    done
}

_penumbra_list() { # PATH WORD…: the words before; uses variables of the caller
    local path=$1 option= scene= count=0 command=- row
    shift
    if [[ $# -eq 0 && $word != -* ]]; then
        _penumbra_commands "$program"
        return
    fi
    if [[ $# -gt 0 && ($program == penumbra || $1 == backup || $1 == check || $1 == token) ]]; then
        command=$1
        shift
    fi
    _penumbra_read "$@"
    if [[ -z $option && $word == --*=* ]]; then
        prefix=${word%%=*}=
        option=$(_penumbra_option "$program" "$command" "${word%%=*}")
    fi
    if [[ -n $option ]]; then
        read -ra row <<<"$(_penumbra_rows "$program" "$command" "$option")"
        _penumbra_value "$path" "$option" "${row[0]}" "${row[1]}" "$scene" "${word#"$prefix"}" |
            sed "s/^/$prefix/"
    elif [[ $word == -* ]]; then
        printf '%s\n' --help --version
        _penumbra_rows "$program" "$command" | sed -n 's/^\(--[a-z-]*\) .*/\1/p'
    else
        _penumbra_argument "$program" "$command" "$count" "$word"
    fi
}

_penumbra() {
    local words word= prefix= program reply cut=
    read -ra words <<<"${COMP_LINE:0:COMP_POINT}"
    if [[ ${COMP_LINE:0:COMP_POINT} != *[[:space:]] ]]; then
        word=${words[${#words[@]} - 1]}
        unset "words[${#words[@]}-1]"
    fi
    program=${words[0]##*/}
    # readline replaces only what follows the last : or =.
    [[ $word == *[:=]* ]] && cut=${word%"${word##*[:=]}"}
    COMPREPLY=()
    while IFS= read -r reply; do
        [[ $reply == "$word"* ]] && COMPREPLY+=("${reply#"$cut"}")
    done < <(_penumbra_list "${words[@]}" | sort -u)
    if [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *[=:/] ]]; then
        compopt -o nospace 2>/dev/null || :
    fi
}

complete -o bashdefault -o default -F _penumbra penumbra penumbrad
