"""Writing a file whose name the user gave: by an option, or as the baseline of a gate."""

import errno
import os
import platform
import secrets
import stat
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

REPLACED_BY_NOBODY = {errno.EACCES, errno.EPERM, errno.EBUSY, errno.EROFS}
"""Errors on replacing a file that can be written but not replaced: no file can be created in its
folder, or the file itself is a mount point, as in containers.
"""


def put(path: Path, data: bytes) -> None:
    """Writes `data` to `path`, atomically where the file can be replaced; raises OSError.

    A path that is no plain file, such as /dev/null, a pipe or a link to standard output, is written
    to and not replaced.
    """
    if is_replaceable(path):
        try:
            sweep(path.parent.glob(".*"))
            replace(path, data)
        except OSError as error:
            if error.errno not in REPLACED_BY_NOBODY or not path.is_file():
                raise
        else:
            return
    path.write_bytes(data)


def is_replaceable(path: Path) -> bool:
    """True unless a device, a pipe or a link has this name."""
    try:
        return stat.S_ISREG(path.lstat().st_mode)
    except FileNotFoundError:
        return True


def refuse_full(path: Path) -> None:
    """Raises OSError if the file or device of this name cannot be written; changes no file.

    A pipe is not opened: that would wait for its reader, or end it.
    """
    kind = path.stat().st_mode
    if stat.S_ISFIFO(kind):
        return
    with path.open("ab", buffering=0) as file:
        # A full device, such as /dev/full, is detected only by writing to it.
        if stat.S_ISCHR(kind) and not os.isatty(file.fileno()):
            file.write(b"\n")


def replace(path: Path, data: bytes) -> None:
    """Writes a temporary file beside `path` and renames it to `path`; raises OSError.

    A link or a pipe of that name is replaced; its target is not written to.
    """
    # Each process has a temporary file of its own. The name of that file does not contain the name
    # of `path`, which may have the largest length that the system permits.
    beside = path.with_name(f"{_beginning()}{os.getpid()}-{secrets.token_hex(4)}")
    try:
        beside.write_bytes(data)
        beside.replace(path)
    finally:
        # This also removes the temporary file if writing was interrupted.
        with suppress(OSError):
            beside.unlink(missing_ok=True)


def sweep(files: Iterable[Path]) -> None:
    """Deletes those of the files that are temporary files of `replace` in processes of this machine
    that have ended.
    """
    beginning = _beginning()
    for file in files:
        if not file.name.startswith(beginning):
            continue
        process = file.name.removeprefix(beginning).partition("-")[0]
        if is_gone(process):
            with suppress(OSError):
                file.unlink()


def is_gone(process: str) -> bool:
    """True if `process` is the number of no process of this machine; False if it is no number."""
    try:
        os.kill(int(process), 0)
    except ProcessLookupError:
        return True
    except (OSError, ValueError, OverflowError):
        # The process belongs to another user, or `process` is no number.
        return False
    return False


def _beginning() -> str:
    """The first part of the names of temporary files of this machine.

    It contains the name of the machine, since process numbers of another machine that shares the
    folder cannot be checked here.
    """
    return f".refdem-{platform.node()}-"
