"""What failed runs leave behind for their author to look at: a few folders of bounded size."""

import contextlib
import os
import shutil
import time
from pathlib import Path

from refdem.core.store import default_path

MOST_FOLDERS = 16
"""Failed runs that are kept, of all programs: the newest."""
MOST_BYTES = 2**20
"""Bytes kept of each file, from its beginning; files of an ordinary run are shorter."""
MOST_FILES = 32
"""Files of a failed run that are kept, in order of their names."""
MOST_DIGITS = 30
"""Digits of the number in a folder's name; a time [ns] has 19."""


def kept(folder: Path, name: str) -> Path | None:
    """Copies the files of a failed run beside the store and drops older ones.

    None if nothing can be written there.
    """
    home = default_path().parent / "failed-runs"
    place = home / f"{name}-{_next_stamp(home)}"
    try:
        place.mkdir(parents=True)
    except OSError:
        return None
    try:
        for path in sorted(
            path for path in folder.iterdir() if path.is_file() and not path.is_symlink()
        )[:MOST_FILES]:
            text = _beginning(path)
            if text is not None:
                (place / path.name).write_bytes(text)
    except OSError:
        shutil.rmtree(place, ignore_errors=True)
        return None
    _drop_older(home)
    return place


def _beginning(path: Path) -> bytes | None:
    """The first MOST_BYTES of a file; None if it cannot be read without waiting.

    A program that still runs may have locked it, or have replaced it by a pipe.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return None
    with os.fdopen(descriptor, "rb") as file:
        return file.read(MOST_BYTES)


def _next_stamp(home: Path) -> int:
    """A number larger than that of every folder there: the time [ns], or, if the clock was set back
    or has not advanced, the number of the newest folder plus 1.
    """
    newest = 0
    with contextlib.suppress(OSError):
        newest = max(map(_stamp, home.iterdir()), default=0)
    return max(time.time_ns(), newest + 1)


def _stamp(place: Path) -> int:
    """The number at the end of a folder's name; 0 if there is none."""
    number = place.name.rpartition("-")[2]
    if number.isascii() and number.isdigit():
        return int(number[:MOST_DIGITS])
    return 0


def _drop_older(home: Path) -> None:
    """Removes all but the newest folders; another process may be doing the same."""
    with contextlib.suppress(OSError):
        for path in sorted(home.iterdir(), key=_stamp)[:-MOST_FOLDERS]:
            shutil.rmtree(path, ignore_errors=True)
