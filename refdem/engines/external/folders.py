"""The folders of runs: empty at the start of a run, deleted at its end with whatever a program has
left in them.

All folders that a process makes are in one folder, on which the process holds a lock, so that other
processes see when it has ended. If it is killed, its supervisors (supervisor.py) delete that
folder. Each engine has its own subfolder, its *home*, so that a program which moves or empties its
parent folder does not disturb the runs of other engines. A home that was deleted is made again.
"""

import atexit
import fcntl
import os
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from refdem.core.named_file import is_gone
from refdem.engines.external.supervisor import remove
from refdem.errors import EngineError

PREFIX = "refdem-runs-"
"""Prefix of the folder of a process that holds its lock."""
MAKING = "refdem-new-"
"""Prefix of a folder that is being made and not yet locked, before the id of its process."""

MOST_TRIES = 3
"""Number of attempts to begin a run while other programs delete the homes of engines."""
_MAKING = threading.Lock()
_HELD: list[Path] = []
"""The folders that this process has made for itself; all but the last one were deleted."""
_HOMES: dict[str, Path] = {}
"""The homes of engines by their names."""


@contextmanager
def run_folder(engine: str = "") -> Iterator[Path]:
    """An empty folder for one run of an engine, in the home of that engine."""
    folder = made_in_home(engine)
    try:
        yield folder
    finally:
        remove(folder)


def made_in_home(engine: str) -> Path:
    """A new folder in the home of an engine; raises EngineError if the home is deleted at every
    attempt.
    """
    for _ in range(MOST_TRIES):
        try:
            return Path(tempfile.mkdtemp(dir=engine_home(engine)))
        except FileNotFoundError:
            # The home was deleted since it was looked up.
            continue
    raise EngineError(
        f"the folder for temporary files, {tempfile.gettempdir()}, is cleared while refdem runs;"
        " set TMPDIR to a folder whose contents persist"
    )


def engine_home(engine: str) -> Path:
    """The folder of this process in which the runs of one engine lie."""
    outer = home()
    with _MAKING:
        inner = _HOMES.get(engine)
        if inner is None or inner.parent != outer or not is_there(inner):
            inner = _HOMES[engine] = Path(tempfile.mkdtemp(dir=outer))
        return inner


def home() -> Path:
    """The folder of this process; folders of processes that have ended are deleted first."""
    with _MAKING:
        if not _HELD or not is_there(_HELD[-1]):
            _HELD.append(_held())
        return _HELD[-1]


def is_there(folder: Path) -> bool:
    """Whether a folder is there, and no link in its place."""
    return folder.is_dir() and not folder.is_symlink()


def _held() -> Path:
    """A new folder that this process holds."""
    sweep()
    making = f"{MAKING}{os.getpid()}-"
    created = Path(tempfile.mkdtemp(prefix=making))
    # The lock lasts as long as the process. Until the folder is locked, its name keeps other
    # processes from deleting it as stale.
    holding = os.open(created, os.O_RDONLY | os.O_CLOEXEC)
    fcntl.flock(holding, fcntl.LOCK_SH)
    held = created.rename(created.with_name(created.name.replace(making, PREFIX)))
    atexit.register(remove, held)
    return held


def sweep() -> None:
    """Deletes the folders of processes that have ended."""
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
        # A process that was killed at this point leaves its folder empty: rmdir deletes no other.
        if is_gone(maker):
            with suppress(OSError):
                folder.rmdir()
