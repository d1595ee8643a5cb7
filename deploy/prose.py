#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Checks the English of pages (*.md) and of header comments (*.h): `prose.py FILE…`. Prints one line for
# each sentence of more than 40 words, each page of more than 20 sentences whose median is above 18 words,
# and each phrase of words.txt. Exit code 1 if it prints anything. Code, tables and diagrams have no
# sentences; inline code is one word, and so are three or more short items of a list in a row.
import os
import re
import statistics
import sys

LONGEST, MEDIAN, PAGE = 40, 18, 20


def page_blocks(lines):
    """Yields (is_prose, [(line number, text)]): paragraphs, list items and rows of tables."""
    block, fenced, comment = [], False, False
    for number, line in enumerate(lines, 1):
        text = line.strip()
        fence, comment_before = text.startswith("```"), comment
        comment = "-->" not in text if comment or "<!--" in text else False
        skip = fenced or fence or comment_before or "<!--" in text
        fenced ^= fence
        indented = line.startswith("    ") and not block
        table, heading = text.startswith("|"), text.startswith("#")
        item = re.match(r"([-*+]|\d+\.)\s+", text)
        if block and (skip or not text or table or heading or item):
            yield True, block
            block = []
        if skip or not text or heading or indented or text.startswith("!["):
            continue
        if table:
            yield False, [(number, text)]
        else:
            block.append((number, text[item.end():] if item else text))
    if block:
        yield True, block


def header_blocks(lines):
    """The same for the comments of a C file; lines in columns, or indented by four spaces, have no sentences."""
    block, inside = [], False
    for number, line in enumerate(lines, 1):
        text = line
        if not inside:
            begin = re.search(r"/\*+", line)
            if begin is None:
                continue
            text, inside = line[begin.end():], True
        else:
            text = re.sub(r"^\s*\*(?!/) ?", "", text)
        ended = "*/" in text
        text = text.split("*/")[0].rstrip()
        words = text.strip()
        columns = re.search(r"\S {3}", words) or text.startswith("    ")
        if block and (not words or columns or re.match(r"([-*]|\d+\.)\s|[A-Z][a-z]+: ", words)):
            yield True, block
            block = []
        if words and not columns:
            block.append((number, words))
        inside = not ended
        if ended and block:
            yield True, block
            block = []


def plain(text, page):
    """Text without the marks of Markdown; each piece of inline code becomes one word of the same length."""
    text = re.sub(r"`[^`]+`", lambda code: "x" * len(code.group()), text)
    if page:
        text = re.sub(r"\]\([^)]*\)", lambda link: " " * len(link.group()), text)
    return re.sub(r"[\[\]*!]", " ", text)


def count(sentence):
    """Words of a sentence; three or more items of at most three words in a row count as one."""
    total, run = 0, []
    for part in re.split(r"[,;] ", sentence + ", ."):
        words = len(re.findall(r"[^\W_][^\s]*", part))
        if 0 < words <= 3:
            run.append(words)
            continue
        total += words + (1 if len(run) >= 3 else sum(run))
        run = []
    return total + (1 if len(run) >= 3 else sum(run))


def check(path, phrases):
    with open(path, encoding="utf-8") as file:
        lines = file.read().split("\n")
    page = path.endswith(".md")
    lengths, found = [], []
    for prose, block in page_blocks(lines) if page else header_blocks(lines):
        starts, text = [], ""
        for number, line in block:
            starts.append((len(text), number))
            text += line + " "
        raw, text = text, plain(text, page)
        where = lambda offset: max(number for start, number in starts if start <= offset)
        begin = 0
        for end in re.finditer(r"[.?!][\"')]*\s+(?=[\W\dA-Zx]|$)|$", text) if prose else ():
            sentence = text[begin:end.end()]
            words = count(sentence)
            if words > LONGEST:
                first = " ".join(raw[begin:].split()[:6])
                found.append((where(begin), f'sentence of {words} words: "{first}…"'))
            if words:
                lengths.append(words)
            begin = end.end()
        for phrase in phrases:
            for hit in phrase.finditer(text):
                found.append((where(hit.start()), f'phrase of deploy/words.txt: "{hit.group()}"'))
    if page and len(lengths) > PAGE and statistics.median(lengths) > MEDIAN:
        found.append((1, f"{len(lengths)} sentences with a median of {statistics.median(lengths):g} words"))
    return [f"{path}:{number}: {what}" for number, what in sorted(found)]


def main():
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "words.txt"), encoding="utf-8") as file:
        words = [line.split("#")[0].strip() for line in file]
    phrases = [re.compile(r"(?<![\w-])(?:" + word.replace(" ", r"\s+") + r")(?![\w-])", re.I)
               for word in words if word]
    found = [line for path in sys.argv[1:] for line in check(path, phrases)]
    print("\n".join(found), end="\n" if found else "")
    return 1 if found else 0


sys.exit(main())
