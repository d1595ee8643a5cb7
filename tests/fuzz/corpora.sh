# SPDX-License-Identifier: MIT
# Prints the folders with the initial inputs of a fuzz target: corpora.sh TARGET
case $1 in
json) echo tests/fuzz/corpus/json tests/io/corpus/good tests/io/corpus/good-marked tests/io/corpus/bad tests/golden/scenes ;;
xml) echo tests/fuzz/corpus/xml tests/io/corpus/xml-good tests/io/corpus/xml-bad tests/io/corpus/xml-spellings tests/golden/xml ;;
*) echo "tests/fuzz/corpus/$1" ;;
esac
