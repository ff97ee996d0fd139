"""Writing a file that a person named: by an option, or as the baseline of a gate."""

import errno
import os
import platform
import secrets
import stat
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

REPLACED_BY_NOBODY = {errno.EACCES, errno.EPERM, errno.EBUSY, errno.EROFS}
"""Errors of a file that can be written, in a folder where no other can be made, or that is mounted
by itself, as containers do.
"""


def put(path: Path, data: bytes) -> None:
    """Puts `data` at `path`, as a whole or not at all where that can be done; raises OSError.

    A path that is no plain file is written to and not replaced: /dev/null, a pipe to another
    program, a link to standard output.
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
    """Raises OSError if nothing can be written to what has this name; no file is changed.

    A pipe is not opened: that would wait for its reader, or end it.
    """
    kind = path.stat().st_mode
    if stat.S_ISFIFO(kind):
        return
    with path.open("ab", buffering=0) as file:
        # Only writing shows that a device takes nothing, as /dev/full does.
        if stat.S_ISCHR(kind) and not os.isatty(file.fileno()):
            file.write(b"\n")


def replace(path: Path, data: bytes) -> None:
    """Writes a file beside `path` and gives it that name; raises OSError.

    A link or a pipe that had this name is gone then; nothing is written where it led.
    """
    # Of several processes that write the same file each has one of its own. Its name is short, also
    # where that of the file is as long as the system takes.
    beside = path.with_name(f"{_beginning()}{os.getpid()}-{secrets.token_hex(4)}")
    try:
        beside.write_bytes(data)
        beside.replace(path)
    finally:
        # Also where the writing was interrupted.
        with suppress(OSError):
            beside.unlink(missing_ok=True)


def sweep(files: Iterable[Path]) -> None:
    """Takes away those of the files that `replace` was writing in processes of this machine which
    were killed.
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
    """True if no process of this machine has that number, as it stands in the name of a file; False
    for what is no number.
    """
    try:
        os.kill(int(process), 0)
    except ProcessLookupError:
        return True
    except (OSError, ValueError, OverflowError):
        # It is another user's, or the name is not one of ours.
        return False
    return False


def _beginning() -> str:
    """How the names of files begin that are being written on this machine: another one, which
    shares the folder, has processes that are not seen here.
    """
    return f".refdem-{platform.node()}-"
