"""Text from outside (a program's output, a file, a name) made safe to display.

Such text must not move a cursor, begin a line of its own, or act as a command in a service that
reads logs, so it is reduced to one printable line. Text in HTML, CSV or Markdown is in addition
escaped for that format.
"""

import os
import re
import stat
from pathlib import Path
from typing import BinaryIO

from refdem.errors import EngineError

MOST = 2000
"""Most characters of a line."""


def _printable_character(character: str, allowed: str = "") -> str:
    """The character itself if it prints or is one of those `allowed`, "?" otherwise."""
    if character.isprintable() or character in allowed:
        return character
    return "?"


def one_line(text: str, most: int = MOST) -> str:
    """The text as one printable line of at most `most` characters.

    Lines are joined by " / ", other characters that do not print become "?". The log of a GitHub
    workflow interprets `##[` anywhere, and `::` at the start of a line, as a command; a blank is
    inserted in these.
    """
    lines = [line.strip() for line in text.splitlines()]
    joined = " / ".join(line for line in lines if line)
    printable = "".join(_printable_character(character) for character in joined)
    printable = printable.replace("##[", "# #[")
    if printable.startswith("::"):
        printable = f": {printable[1:]}"
    if len(printable) <= most:
        return printable
    return printable[: most - 4] + " ..."


def printable(text: str) -> str:
    """The text with "?" for characters that do not print; line breaks are not changed."""
    if text.isprintable():
        return text
    return "".join(_printable_character(character, allowed="\n\t") for character in text)


MARKED = re.compile(r"[\\`*_{}\[\]#|~$]")
"""Characters that are markup in Markdown."""
SPOKEN_TO = re.compile(r"@(?=\w)|://|(?<=www)\.|#(?=\d)|GH-(?=\d)", re.IGNORECASE)
"""Bare text from which GitHub makes a mention, a link, or a reference to an issue."""
NOTHING = "&#8203;"
"""A space of no width, which ends a name and a link."""


def markdown_text(text: str) -> str:
    """Markdown that shows the text literally on one line: no markup, HTML, table cell, mention of a
    person, or link arises from it.
    """
    line = " ".join(printable(text).split())
    # Cut after the first character of every mention or link; a space of no width in the cut ends
    # it.
    cuts = [match.start() + 1 for match in SPOKEN_TO.finditer(line)]
    starts = [0, *cuts]
    ends = [*cuts, len(line)]
    pieces = [line[start:end] for start, end in zip(starts, ends, strict=True)]
    return NOTHING.join(_escaped(piece) for piece in pieces)


def _escaped(text: str) -> str:
    """The text with HTML's special characters as entities, Markdown's behind a backslash."""
    html = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return MARKED.sub(r"\\\g<0>", html)


def in_file_name(text: str, most: int = 80) -> str:
    """The text as a part of a file name, safe on any file system: lower case, with "-" for other
    characters than letters, digits and . = _ -; of different texts it may be the same.
    """
    return re.sub(r"[^a-z0-9.=_-]+", "-", text.lower()).strip("-.")[:most]


def cell(value: object) -> object:
    """A cell of a CSV file; a text that a spreadsheet would take for a formula begins with an
    apostrophe.
    """
    if not isinstance(value, str):
        return value
    text = printable(value)
    if text.startswith(("=", "+", "-", "@", "\t")):
        return f"'{text}"
    return text


def opened(path: Path) -> BinaryIO | None:
    """A file that a program wrote, open for reading; None if there is none.

    Raises EngineError unless it is a plain file with this one name: a link may lead to the answer
    of another run, and reading a pipe may wait for ever.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW | os.O_CLOEXEC)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise EngineError(
            f"{path.name} cannot be read: {error.strerror}; expected a plain file that this run"
            " wrote"
        ) from None
    status = os.fstat(descriptor)
    if not stat.S_ISREG(status.st_mode) or status.st_nlink != 1:
        os.close(descriptor)
        raise EngineError(
            f"{path.name} is a link, a pipe, a device or a folder; expected a plain file that this"
            " run wrote"
        )
    return os.fdopen(descriptor, "rb")


def made(path: Path) -> BinaryIO:
    """A new file, open for writing and reading, in a folder that programs can reach.

    Raises EngineError if the name is taken: what a program has put there, a link or a pipe, may
    lead elsewhere, or wait for ever.
    """
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
    except OSError as error:
        raise EngineError(
            f"{path.name} cannot be made: {error.strerror}; expected a folder in which nothing has"
            " this name yet"
        ) from None
    return os.fdopen(descriptor, "w+b")


def put_new(path: Path, data: bytes) -> None:
    """Writes a new file in a folder that programs can reach; raises EngineError as `made` does."""
    with made(path) as file:
        file.write(data)
