"""What comes from outside (a program's output, a file, a name) as one printable line.

Nothing from outside may move a cursor, begin a line of its own, or be read as a command by a service
that reads logs. Where it goes on to (HTML, CSV, Markdown) it is escaped once more in that way.
"""

import os
import stat
from pathlib import Path
from typing import BinaryIO

from refdem.errors import EngineError

MOST = 2000
"""Characters of a line."""


def one_line(text: str, most: int = MOST) -> str:
    """The text as one printable line of at most `most` characters.

    Lines are joined by " / ", other characters that do not print become "?", and what the log of a
    workflow on GitHub would take for a command is broken by a blank: `##[` anywhere, `::` at the begin.
    """
    lines = [line.strip() for line in text.splitlines()]
    joined = " / ".join(line for line in lines if line)
    printable = "".join(c if c.isprintable() else "?" for c in joined)
    printable = printable.replace("##[", "# #[")
    if printable.startswith("::"):
        printable = f": {printable[1:]}"
    return printable if len(printable) <= most else printable[: most - 4] + " ..."


def opened(path: Path) -> BinaryIO | None:
    """A file that a program wrote, None if there is none; raises EngineError if it is no plain file of its own.

    A link may lead to the answer of another run, and a pipe would be waited for without end.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW | os.O_CLOEXEC)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise EngineError(f"{path.name} cannot be read: {error.strerror}; expected a plain file that this run wrote") from None
    found = os.fstat(descriptor)
    if not stat.S_ISREG(found.st_mode) or found.st_nlink != 1:
        os.close(descriptor)
        raise EngineError(f"{path.name} is a link, a pipe, a device or a folder; expected a plain file that this run wrote")
    return os.fdopen(descriptor, "rb")
