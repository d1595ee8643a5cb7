#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The museum: numeric bugs that other renderers had in public, and what Penumbra does in the same place.

    museum.py BUILD            renders, judges, writes museum.md and the pictures
    museum.py BUILD --check    renders, judges, and compares with museum.md and the pictures

museum/exhibits.txt has the words, museum/NAME.json the scene of an exhibit, and museum_values.py the
right values. Ends with 1 if a value is wrong, or if the page is not what this program writes."""

import functools
import json
import math
import os
import re
import struct
import subprocess
import sys
import textwrap
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))
FOLDER = os.path.join(HERE, "museum")
PAGE = os.path.join(HERE, "museum.md")
INTRODUCTION = """\
Other renderers had these bugs in public. Each exhibit tells one of them in our own words, with a
link to its report. A report describes its renderer on the day of the report; many of these bugs
are fixed. Beside it are a small scene of ours that asks for the same numbers, our picture of it,
and the right value. The right value follows from mathematics.

`make museum` renders the scenes, measures, and writes this page. `make check` fails if a value is
wrong, if a picture holds a number that is not finite, or if this page is not what `make museum`
writes.

u is 2⁻²⁴, the largest relative error of rounding a number to binary32, as a film holds it.
"""
FIELDS = ("title", "kind", "report", "bug", "scene", "right")


class Picture:
    """Pixels by row from the top: floats of a film, or bytes as a screen gets them."""

    def __init__(self, width, height, rows):
        self.width, self.height, self.rows = width, height, rows

    def __eq__(self, other):
        return self.rows == other.rows

    def at(self, x, y):
        return self.rows[y][3 * x : 3 * x + 3]

    def pixels(self):
        return ((x, y, row[3 * x : 3 * x + 3]) for y, row in enumerate(self.rows) for x in range(self.width))

    def unlike(self, other):
        """How many pixels differ."""
        rows = [(a, b) for a, b in zip(self.rows, other.rows) if a != b]
        return sum(a[i : i + 3] != b[i : i + 3] for a, b in rows for i in range(0, len(a), 3))

    def values(self):
        return [value for row in self.rows for value in row]


def pfm(data):
    """A PFM by its definition: the sign of the third line is the byte order, the bottom row is first."""
    _, size, scale, body = data.split(b"\n", 3)
    width, height = map(int, size.split())
    order = "<" if float(scale) < 0 else ">"
    rows = [struct.unpack_from(f"{order}{3 * width}f", body, 12 * width * y) for y in range(height)]
    return Picture(width, height, rows[::-1])


def png(data):
    """A PNG of 8 bits, RGB, not interlaced."""
    at, body = 8, b""
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        chunk = data[at + 8 : at + 8 + length]
        at += 12 + length
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack_from(">IIBB", chunk)
            assert (depth, colour) == (8, 2), "not a PNG of 8 bits and RGB"
        elif kind == b"IDAT":
            body += chunk
    body, stride, rows = zlib.decompress(body), 3 * width + 1, []
    above = bytes(3 * width)
    for y in range(height):
        line = body[y * stride : (y + 1) * stride]
        above = unfiltered(line[0], line[1:], above)
        rows.append(tuple(above))
    return Picture(width, height, rows)


def unfiltered(kind, line, above):
    row = bytearray(line)
    for i, up in enumerate(above):
        left, corner = (row[i - 3], above[i - 3]) if i >= 3 else (0, 0)
        if kind == 4:
            a, b, c = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
            row[i] = row[i] + (left if a <= b and a <= c else up if b <= c else corner) & 255
        else:
            row[i] = row[i] + (0, left, up, left + up >> 1)[kind] & 255
    return bytes(row)


class Exhibit:
    """A scene, and renders of it and of what is made of it."""

    def __init__(self, build, name, text):
        self.name, self.text = name, text
        self.program = os.path.join(build, "penumbra")
        self.rows = []  # of the table: what, right, ours, allowed, why
        with open(os.path.join(FOLDER, name + ".json"), encoding="utf-8") as file:
            self.scene = json.load(file)
        self.image = self.rendered(self.scene, "png")

    @functools.cached_property
    def film(self):
        return self.render()

    def rendered(self, scene, kind):
        command = [self.program, "render", "-", "-q", "-o", "-", "--format", kind]
        done = subprocess.run(command, input=json.dumps(scene).encode(), capture_output=True)
        if done.returncode:
            sys.exit(f"museum: {self.name}: {done.stderr.decode()}")
        return done.stdout

    def changed(self, **changes):
        """The scene with other values at its top level; `render` is merged."""
        scene = {**self.scene, **changes}
        scene["render"] = {**self.scene["render"], **changes.get("render", {})}
        return scene

    def render(self, **changes):
        film = pfm(self.rendered(self.changed(**changes), "pfm"))
        if not math.isfinite(sum(film.values())):
            sys.exit(f"museum: {self.name}: a value is not finite")
        return film

    def value(self, what, right, ours, allowed=0, why="exact"):
        self.rows.append((what, right, ours, allowed, why))

    def wrong(self):
        # "not <=", so that a NaN is wrong
        return [row for row in self.rows if not abs(row[2] - row[1]) <= row[3]]


def read_texts():
    """exhibits.txt: `= NAME` opens an exhibit, `FIELD: text` a field, other lines go on with it."""
    texts = {}
    with open(os.path.join(FOLDER, "exhibits.txt"), encoding="utf-8") as file:
        for line in file:
            if line.startswith("= "):
                text = texts[line[2:].strip()] = {}
                continue
            field, colon, rest = line.partition(": ")
            if colon and field in FIELDS:
                text[field] = rest.strip()
            elif line.strip() and not line.startswith("#"):
                text[field_before] += " " + line.strip()
                continue
            field_before = field if colon else None
    for name, text in texts.items():
        assert tuple(text) == FIELDS, f"exhibits.txt: {name}: has {tuple(text)}"
    return texts


def number(value):
    return f"{value:.9g}"


def anchor(heading):
    return re.sub(r"[^a-z0-9 -]", "", heading.lower()).replace(" ", "-")


def link(report):
    label, address = report.rsplit(" ", 1)
    return f"[{label}]({address})"


def wrapped(text):
    return textwrap.fill(text, 100, break_long_words=False, break_on_hyphens=False)


def section(heading, exhibit):
    name, text = exhibit.name, exhibit.text
    lines = [f"## {heading}", "", wrapped(f"{link(text['report'])}. {text['bug']}"), ""]
    lines += [f"![our picture of {name}](museum/{name}.png)", ""]
    lines += [wrapped(f"**Scene** ([{name}.json](museum/{name}.json)). {text['scene']}"), ""]
    lines += [wrapped(f"**Right value.** {text['right']}"), ""]
    lines += ["| measured | right | ours | allowed difference |", "|---|---|---|---|"]
    for what, right, ours, allowed, why in exhibit.rows:
        tolerance = f"{allowed:.3g}: {why}" if allowed else "none"
        lines.append(f"| {what} | {number(right)} | {number(ours)} | {tolerance} |")
    return lines + [""]


def page(exhibits):
    headings = [f"{i}. {e.text['title']}" for i, e in enumerate(exhibits, 1)]
    lines = ["# Museum of numeric bugs", "", INTRODUCTION, "| exhibit | kind | report |", "|---|---|---|"]
    for heading, e in zip(headings, exhibits):
        lines.append(f"| [{heading}](#{anchor(heading)}) | {e.text['kind']} | {link(e.text['report'])} |")
    lines.append("")
    for heading, e in zip(headings, exhibits):
        lines += section(heading, e)
    return "\n".join(lines)


def read(path):
    with open(path, "rb") as file:
        return file.read()


def stale(exhibits):
    """What the files say that this program would not write. Pictures count by their pixels."""
    found = [] if read(PAGE).decode() == page(exhibits) else ["museum.md"]
    for e in exhibits:
        written = read(os.path.join(FOLDER, e.name + ".png"))
        if written != e.image and png(written) != png(e.image):  # another zlib may pack them otherwise
            found.append(f"museum/{e.name}.png")
    return found


def write(exhibits):
    for e in exhibits:
        with open(os.path.join(FOLDER, e.name + ".png"), "wb") as file:
            file.write(e.image)
    with open(PAGE, "w", encoding="utf-8") as file:
        file.write(page(exhibits))


def main(build, *options):
    from museum_values import VALUES

    texts = read_texts()
    assert set(texts) == set(VALUES), f"texts and values differ: {set(texts) ^ set(VALUES)}"
    exhibits = [Exhibit(build, name, text) for name, text in texts.items()]
    failed = False
    for e in exhibits:
        VALUES[e.name](e)
        for what, right, ours, allowed, _ in e.wrong():
            failed = True
            print(f"museum: {e.name}: {what}: right is {right!r}, ours {ours!r}, may differ by {allowed!r}")
    if failed:
        return 1
    if "--check" not in options:
        write(exhibits)
        return 0
    for name in stale(exhibits):
        failed = True
        print(f"museum: {name} is not what `make museum` writes")
    return failed


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
