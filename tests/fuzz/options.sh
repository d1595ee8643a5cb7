# SPDX-License-Identifier: MIT
# Prints what libFuzzer needs for a target: options.sh TARGET
[ ! -e "tests/fuzz/$1.dict" ] || echo "-dict=tests/fuzz/$1.dict"
