"""What comes from outside (a program's output, a file, a name) as one printable line.

Nothing from outside may move a cursor, begin a line of its own, or be read as a command by a
service that reads logs. Where it goes on to (HTML, CSV, Markdown) it is escaped once more in that
way.
"""

import os
import re
import stat
from pathlib import Path
from typing import BinaryIO

from refdem.errors import EngineError

MOST = 2000
"""Characters of a line."""


def _shown(character: str, kept: str = "") -> str:
    """The character itself if it prints or is one of those kept, "?" otherwise."""
    if character.isprintable() or character in kept:
        return character
    return "?"


def one_line(text: str, most: int = MOST) -> str:
    """The text as one printable line of at most `most` characters.

    Lines are joined by " / ", other characters that do not print become "?", and what the log of a
    workflow on GitHub would take for a command is broken by a blank: `##[` anywhere, `::` at the
    begin.
    """
    lines = [line.strip() for line in text.splitlines()]
    joined = " / ".join(line for line in lines if line)
    printable = "".join(_shown(character) for character in joined)
    printable = printable.replace("##[", "# #[")
    if printable.startswith("::"):
        printable = f": {printable[1:]}"
    if len(printable) <= most:
        return printable
    return printable[: most - 4] + " ..."


def printable(text: str) -> str:
    """The text with "?" for characters that do not print; lines stay lines."""
    if text.isprintable():
        return text
    return "".join(_shown(character, kept="\n\t") for character in text)


MARKED = re.compile(r"[\\`*_{}\[\]#|~$]")
"""Characters by which Markdown makes more of a text than it says."""
SPOKEN_TO = re.compile(r"@(?=\w)|://|(?<=www)\.|#(?=\d)", re.IGNORECASE)
"""Where GitHub makes a mention, a link, or a reference to an issue of bare text."""
NOTHING = "&#8203;"
"""A space of no width, which ends a name and a link."""


def markdown_text(text: str) -> str:
    """The text as Markdown shows it: one line, no markup, no HTML, no end of a table's cell, nobody
    mentioned, no link.
    """
    line = " ".join(printable(text).split())
    parts = [line]
    for found in reversed(list(SPOKEN_TO.finditer(line))):
        before = parts[0][: found.start() + 1]
        after = parts[0][found.start() + 1 :]
        parts[:1] = [before, after]
    return NOTHING.join(_marked(part) for part in parts)


def _marked(text: str) -> str:
    """The text with what Markdown and HTML would read written so that it is shown."""
    shown = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return MARKED.sub(r"\\\g<0>", shown)


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
    """A file that a program wrote, None if there is none; raises EngineError if it is no plain file
    of its own.

    A link may lead to the answer of another run, and a pipe would be waited for without end.
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
    found = os.fstat(descriptor)
    if not stat.S_ISREG(found.st_mode) or found.st_nlink != 1:
        os.close(descriptor)
        raise EngineError(
            f"{path.name} is a link, a pipe, a device or a folder; expected a plain file that this"
            " run wrote"
        )
    return os.fdopen(descriptor, "rb")
