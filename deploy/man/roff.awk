# SPDX-License-Identifier: MIT
# Shared by the scripts beside this one.

# Text as troff source: backslashes and dashes stand for themselves, and no line is a request.
function roff(text) {
    gsub(/\\/, "\\e", text)
    gsub(/-/, "\\-", text)
    if (text ~ /^[.']/) text = "\\&" text
    return text
}
