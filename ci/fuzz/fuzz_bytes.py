"""Bytes made wrong: bits, words, lines and numbers of a good input changed, by a seed."""

import random
import re
from collections.abc import Callable, Sequence

NASTY = [
    b"",
    b"0",
    b"-0.0",
    b"-1",
    b"99",
    b"1e999",
    b"-1e308",
    b"1e-400",
    b"1d3",
    b"nan",
    b"inf",
    b"1_000",
    b"0x10",
    b"18446744073709551616",
    b"9" * 400,
    b"true",
    b"null",
    b"{}",
    b"[]",
    b"[" * 5000,
    b'{"a":' * 3000,
    b'"',
    b"'",
    b"\\",
    b"\n",
    b"\r",
    b"\t",
    b",",
    b"=",
    b"/",
    b"**",
    b"../../../etc/passwd",
    b"x" * 5000,
    b"\x00",
    b"\xff\xfe",
    b"\xc3\x28",
    b"\xed\xa0\x80",
    "\u202e\u2028\u00a0".encode(),
    "\u0663".encode(),
    b"\\ud800",
    b"\x1b[31m",
    b"::error::",
    b"##[error]",
    b"=HYPERLINK(1)",
    b"@name",
]
"""What stands where something else should: numbers beyond binary64, brackets without end, bytes
that are no text, what terminals and services read as commands.
"""
NUMBER = re.compile(rb"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
WORD = re.compile(rb"[A-Za-z_][A-Za-z_0-9-]*")
MOST = 200_000
"""Bytes of an input; more of them are no other kind of wrong."""

Change = Callable[[bytes, random.Random], bytes]


def flipped(data: bytes, draw: random.Random) -> bytes:
    """One bit is another."""
    if not data:
        return data
    at = draw.randrange(len(data))
    changed = data[at] ^ (1 << draw.randrange(8))
    return data[:at] + bytes([changed]) + data[at + 1 :]


def span(data: bytes, draw: random.Random) -> tuple[int, int]:
    """Two places in order, mostly near each other."""
    begin = draw.randrange(len(data) + 1)
    length = min(len(data) - begin, int(2 ** draw.uniform(0, 8)))
    return begin, begin + length


def cut(data: bytes, draw: random.Random) -> bytes:
    """A part is missing."""
    begin, end = span(data, draw)
    return data[:begin] + data[end:]


def shortened(data: bytes, draw: random.Random) -> bytes:
    """The end is missing, as where a disk was full."""
    return data[: draw.randrange(len(data) + 1)]


def repeated(data: bytes, draw: random.Random) -> bytes:
    """A part is there twice."""
    begin, end = span(data, draw)
    return data[:end] + data[begin:]


def inserted(data: bytes, draw: random.Random) -> bytes:
    """Something nasty stands between."""
    at = draw.randrange(len(data) + 1)
    return data[:at] + draw.choice(NASTY) + data[at:]


def replaced(data: bytes, draw: random.Random, pattern: re.Pattern[bytes]) -> bytes:
    """One match of a pattern is something nasty, or another match."""
    found = list(pattern.finditer(data))
    if not found:
        return inserted(data, draw)
    place = draw.choice(found)
    if draw.random() < 0.5:
        others = [other[0] for other in found]
    else:
        others = NASTY
    return data[: place.start()] + draw.choice(others) + data[place.end() :]


def other_number(data: bytes, draw: random.Random) -> bytes:
    """One number is another."""
    return replaced(data, draw, NUMBER)


def other_word(data: bytes, draw: random.Random) -> bytes:
    """One word is another, or nasty."""
    return replaced(data, draw, WORD)


def misspelt(data: bytes, draw: random.Random) -> bytes:
    """One word lacks a letter."""
    found = [place for place in WORD.finditer(data) if len(place[0]) > 1]
    if not found:
        return cut(data, draw)
    place = draw.choice(found)
    at = draw.randrange(place.start(), place.end())
    return data[:at] + data[at + 1 :]


def swapped_lines(data: bytes, draw: random.Random) -> bytes:
    """Two lines have changed places, or one is there twice."""
    lines = data.splitlines(keepends=True)
    if len(lines) < 2:
        return repeated(data, draw)
    first = draw.randrange(len(lines))
    second = draw.randrange(len(lines))
    kept = lines[first]
    lines[first] = lines[second]
    if draw.random() < 0.5:
        lines[second] = kept
    return b"".join(lines)


def in_another_code(data: bytes, draw: random.Random) -> bytes:
    """The text in another encoding, with other ends of lines, or with a mark of byte order."""
    text = data.decode("latin-1")
    ways = [
        lambda: text.encode("utf-16"),
        lambda: b"\xef\xbb\xbf" + data,
        lambda: data.replace(b"\n", b"\r\n"),
        lambda: data.replace(b"\n", b"\r"),
    ]
    return draw.choice(ways)()


CHANGES: list[Change] = [
    flipped,
    cut,
    shortened,
    repeated,
    inserted,
    other_number,
    other_number,
    other_word,
    misspelt,
    swapped_lines,
    in_another_code,
]


def mutated(inputs: Sequence[bytes], draw: random.Random) -> bytes:
    """One of the inputs with one to four changes, or the begin of one and the end of another."""
    data = draw.choice(inputs)
    if draw.random() < 0.05:
        other = draw.choice(inputs)
        return data[: span(data, draw)[0]] + other[span(other, draw)[0] :]
    for _ in range(draw.choice((1, 1, 1, 2, 4))):
        data = draw.choice(CHANGES)(data, draw)
    return data[:MOST]
