# SPDX-License-Identifier: MIT
"""Compares api/scene.schema.json with the reader on the same documents.

check_schema.py corpus        the files of tests/io/corpus and scenes/
check_schema.py verdicts FILE one JSON object per line: {"errors": [messages], "document": ...}

A document that the schema refuses must be refused by the reader. One that the reader refuses must
be refused by the schema, unless every error is of a kind that no schema can express. The corpus
marks such files `schema-blind:`; the mark is wrong, too, if the schema refuses the file.
Prints the documents on which they disagree, and exits with 1 if there are any.
"""
import glob
import json
import os
import sys

import jsonschema

# Errors that only the reader can find, by a part of the message.
BLIND = (
    "unknown material",
    "is the same point as position",
    "parallel to the view direction",
    "found a triangle of zero area",
    "meets itself",
    "repeats vertex",  # equal within rounding, seen along the normal
    "is not in the plane",
    "area is zero",
    "must be invertible",
    "takes only similarities",
    "beyond 1e100",
    "must be unique",
    "must have the index of refraction (ior) 1",
    "must be another point",
    "one for each position",
    "must be the number of a position",
    "has no triangle with an area",
    "which a camera with",  # a view has some of the keys, the camera others
)


def load_validator():
    with open("api/scene.schema.json", encoding="utf-8") as file:
        schema = json.load(file)
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def expectation(path):
    """Whether the file is not JSON, and whether no schema can express its error."""
    with open(os.path.splitext(path)[0] + ".expect", encoding="utf-8") as file:
        lines = file.read().splitlines()
    return lines[0].startswith(("syntax ", "not-json: ")), lines[0].startswith("schema-blind: ")


def check_corpus(validator):
    wrong = checked = 0
    good = glob.glob("tests/io/corpus/good/*.json") + glob.glob("scenes/*.json")
    bad = glob.glob("tests/io/corpus/bad/*.json")
    for path in sorted(good + bad):
        syntax, blind = expectation(path) if path in bad else (False, False)
        if syntax:
            continue
        with open(path, encoding="utf-8") as file:
            document = json.load(file)
        checked += 1
        valid = validator.is_valid(document)
        if valid != (path in good or blind):
            wrong += 1
            print(f"{path}: the schema {'accepts' if valid else 'refuses'} it")
            for error in validator.iter_errors(document):
                print(f"  /{'/'.join(map(str, error.absolute_path))}: {error.message[:200]}")
    return wrong, checked


def check_verdicts(validator, path):
    wrong = checked = 0
    with open(path, encoding="utf-8") as file:
        for line in file:
            case = json.loads(line)
            errors = case["errors"]
            blind = all(any(part in error for part in BLIND) for error in errors)
            valid = validator.is_valid(case["document"])
            checked += 1
            if valid if (errors and not blind) else (not valid and not errors):
                wrong += 1
                print(f"reader: {errors}; the schema {'accepts' if valid else 'refuses'}")
                print("  " + json.dumps(case["document"]))
    return wrong, checked


def main():
    sys.setrecursionlimit(100000)  # a scene nests 64 deep, and each level takes many calls
    validator = load_validator()
    if sys.argv[1] == "corpus":
        wrong, checked = check_corpus(validator)
    else:
        wrong, checked = check_verdicts(validator, sys.argv[2])
    print(f"{checked} documents, {wrong} disagreements")
    sys.exit(1 if wrong or not checked else 0)


main()
