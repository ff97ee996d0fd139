"""The folders of runs: empty at their start, taken away at their end, whatever a program has left
in them.

All that a process makes lie in one folder, which it holds by a lock, so that others see when it is
gone; its supervisors (supervisor.py) take that folder away if it is killed.
"""

import atexit
import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from refdem.engines.external.supervisor import remove

PREFIX = "refdem-runs-"
"""Of the folder of a process that holds it."""
MAKING = "refdem-new-"
"""Of one that is just being made; the number of the process comes next, for nobody holds it yet."""


@contextmanager
def run_folder() -> Iterator[Path]:
    """An empty folder for one run."""
    folder = Path(tempfile.mkdtemp(dir=home()))
    try:
        yield folder
    finally:
        remove(folder)


@cache
def home() -> Path:
    """The folder of this process; those of processes that are gone are taken away first."""
    sweep()
    making = f"{MAKING}{os.getpid()}-"
    created = Path(tempfile.mkdtemp(prefix=making))
    # The lock lasts as long as the process does; nobody takes the folder for a stale one before it
    # has it.
    holding = os.open(created, os.O_RDONLY | os.O_CLOEXEC)
    fcntl.flock(holding, fcntl.LOCK_SH)
    held = created.rename(created.with_name(created.name.replace(making, PREFIX)))
    atexit.register(remove, held)
    return held


def sweep() -> None:
    """Takes away the folders of processes that are gone."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError):
            trying = os.open(folder, os.O_RDONLY | os.O_NOFOLLOW | os.O_DIRECTORY | os.O_CLOEXEC)
            try:
                fcntl.flock(trying, fcntl.LOCK_EX | fcntl.LOCK_NB)
                remove(folder)
            finally:
                os.close(trying)
    for folder in Path(tempfile.gettempdir()).glob(f"{MAKING}*"):
        maker = folder.name.removeprefix(MAKING).partition("-")[0]
        # A process that was killed here leaves its folder empty: rmdir takes no other.
        if not Path("/proc", maker).exists():
            with suppress(OSError):
                folder.rmdir()
