"""The folders of runs: empty at their start, taken away at their end, whatever a program has left
in them.

All that a process makes lie in one folder, which it holds by a lock, so that others see when it is
gone; its supervisors (supervisor.py) take that folder away if it is killed. In it each engine has a
home of its own, so that a program which moves or empties the folder above its own costs no other
engine a run. What has been taken away all the same is made again.
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
"""Of the folder of a process that holds it."""
MAKING = "refdem-new-"
"""Of one that is being made, which no process holds yet; the number of the process comes next."""

MOST_TRIES = 3
"""Times that a run is begun where someone takes the homes of engines away meanwhile."""
_MAKING = threading.Lock()
_HELD: list[Path] = []
"""The folders that this process has made for itself; those before the last one were taken away."""
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
    """A new folder in the home of an engine; raises EngineError where it is taken away each
    time.
    """
    for _ in range(MOST_TRIES):
        try:
            return Path(tempfile.mkdtemp(dir=engine_home(engine)))
        except FileNotFoundError:
            # Someone took the home away since it was looked for.
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
    """The folder of this process; those of processes that are gone are taken away first."""
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
        if is_gone(maker):
            with suppress(OSError):
                folder.rmdir()
