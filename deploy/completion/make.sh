#!/bin/sh
# SPDX-License-Identifier: MIT
# Makes a completion script from its template: make.sh TABLE TEMPLATE, with the table from table.sh.
set -eu
table=$1 template=$2
case $template in
*.bash)
    awk -F '\t' '
    FNR == NR {
        if ($1 == "option") {
            row = $2 " " $3 " " $5 " " $6 " " $7
            if ($4 != "-") row = row "\n" $2 " " $3 " " $4 " " $5
        } else if ($1 == "command") row = $2 " " $3 " : " $4
        else row = $1 " " $2 ($1 == "setting" ? " " $3 : "")
        rows = rows (rows == "" ? "" : "\n") row
        next
    }
    { at = index($0, "@TABLE@") }
    at { $0 = substr($0, 1, at - 1) rows substr($0, at + 7) }
    { print }' "$table" "$template"
    ;;
*.zsh)
    awk -F '\t' '
    # A text within quotes, in a place where brackets and colons have a meaning.
    function quoted(text) {
        gsub(/\[|\]|:|\\/, "\\\\&", text)
        gsub(/\047/, "\047\\\047\047", text)
        return text
    }
    function action(name, value, choices) {
        if (choices != "-") {
            gsub(/\|/, " ", choices)
            return "(" choices ")"
        }
        if (name == "--set") return "_penumbra_setting"
        if (name == "--matrix") return "_penumbra_matrix"
        if (name == "--baseline") return "_penumbra_row"
        if (name == "--view") return "_penumbra_view"
        if (value == "FILE" || value == "OUT") return "_files"
        return " "
    }
    function argument(word,    many, kind) {
        many = sub(/…$/, "", word)
        kind = word ~ /^SCENE/ ? "_penumbra_scene" : word == "[NAME]" && $2 == "penumbra" ? "_penumbra_builtin" : \
            word == "ID" || word == "[NAME]" ? " " : "_files"
        if (word ~ /\|/) {
            kind = word
            gsub(/\|/, " ", kind)
            kind = "(" kind ")"
        }
        gsub(/[][]/, "", word)
        return " \\\n        \047" (many ? "*" : ++count) ":" word ":" kind "\047"
    }
    function end() { if (functions != "") functions = functions "\n}\n" }
    FNR == NR && $1 == "scene" { scenes = scenes (scenes == "" ? "" : " ") $2 }
    FNR == NR && $1 == "setting" { settings = settings (settings == "" ? "" : " ") $2 " \047" $3 "\047" }
    FNR == NR && $1 == "command" {
        end()
        name = $2 == "penumbrad" ? "daemon" ($3 == "-" ? "" : "_" $3) : "command_" $3
        functions = functions "_penumbra_" name "() {\n    _arguments -s -S \"$@\""
        if ($2 == "penumbra") commands = commands "\n    \047" $3 ":" quoted($5) "\047"
        count = 0
        n = $4 == "-" ? 0 : split($4, word, " ")
        for (i = 1; i <= n; i++) functions = functions argument(word[i])
    }
    FNR == NR && $1 == "option" {
        takes = $6 == "-" ? "" : "="
        names = $4 == "-" ? "\047" ($8 == "*" ? "*" : "") $5 takes : \
            "\047" ($8 == "*" ? "*" : "(" $4 " " $5 ")") "\047{" $4 (takes ? "+" : "") "," $5 takes "}\047"
        functions = functions " \\\n        " names "[" quoted($9) "]" \
            (takes ? ":" quoted($6) ":" action($5, $6, $7) : "") "\047"
    }
    FNR == NR { next }
    FNR == 1 { end() }
    function fill(word, text,    at) {
        at = index($0, word)
        if (at) $0 = substr($0, 1, at - 1) text substr($0, at + length(word))
    }
    {
        fill("@SCENES@", scenes)
        fill("@SETTINGS@", settings)
        fill("@COMMANDS@", commands)
        fill("@FUNCTIONS@", functions)
        print
    }' "$table" "$template"
    ;;
esac
