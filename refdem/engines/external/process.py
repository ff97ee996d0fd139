"""A process of its own group, with limits on its time and on the size of what it writes."""

import contextlib
import os
import signal
import subprocess
import threading
from pathlib import Path
from time import perf_counter

from refdem.errors import EngineError, UnsupportedError

NOT_SUPPORTED = 77
SHOWN = 300
_RUNNING: set[int] = set()
"""Process groups under way, of all threads."""


def ended(command: list[str], folder: Path, *, name: str, timeout: float, most_bytes: int) -> float:
    """Runs the command in `folder`, its output in stdout.txt and stderr.txt there, and then ends its whole process group.

    Returns the seconds that it took. Raises UnsupportedError for exit status 77, EngineError if it cannot start, does not end
    within `timeout` [s] or ends with another status.
    """
    began = perf_counter()
    with (folder / "stdout.txt").open("wb") as out, (folder / "stderr.txt").open("wb") as err:
        try:
            process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=err, start_new_session=True)
        except (OSError, ValueError) as error:
            raise EngineError(f"{command[0]} cannot be started: {error}") from None
        overdue, status = _status_of(process, timeout, most_bytes)
    seconds = perf_counter() - began
    if overdue:
        raise EngineError(f"{name} was still running after {timeout:g} s and was ended")
    says = _last_lines(folder / "stderr.txt")
    if status == NOT_SUPPORTED:
        raise UnsupportedError(says.splitlines()[-1] if says else "the program says it cannot (exit 77)")
    if status != 0:
        raise EngineError(f"{name} ended with {_status(status)}: {says or 'it said nothing on stderr'}")
    return seconds


def _status_of(process: subprocess.Popen[bytes], timeout: float, most_bytes: int) -> tuple[bool, int]:
    """True if the process was ended for its time, and its exit status; a clock of its own ends it, so that nothing is polled."""
    overdue = threading.Event()

    def end() -> None:
        overdue.set()
        _end(process.pid)

    clock = threading.Timer(timeout, end)
    clock.daemon = True
    _RUNNING.add(process.pid)
    try:
        _limit_files(process.pid, most_bytes)
        clock.start()
        status = process.wait()
        return overdue.is_set(), status
    finally:
        clock.cancel()
        _end(process.pid)
        process.wait()
        _RUNNING.discard(process.pid)


def end_all() -> None:
    """Ends every program that any thread waits for."""
    for group in tuple(_RUNNING):
        _end(group)


def _end(group: int) -> None:
    """Ends a process and what it has started, if they are there."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(group, signal.SIGKILL)


def _limit_files(pid: int, most_bytes: int) -> None:
    """No file of the process may grow beyond this; Linux only, and no harm where a process has ended already."""
    import resource

    with contextlib.suppress(AttributeError, OSError):
        resource.prlimit(pid, resource.RLIMIT_FSIZE, (most_bytes, most_bytes))


def _status(status: int) -> str:
    """How a process ended, in words."""
    if status >= 0:
        return f"exit status {status}"
    with contextlib.suppress(ValueError):
        name = signal.Signals(-status).name
        return f"signal {-status} ({name}" + (": a file grew too large)" if name == "SIGXFSZ" else ")")
    return f"signal {-status}"


def _last_lines(path: Path) -> str:
    """The end of what the program said, printable."""
    try:
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - 4 * SHOWN))
            text = file.read().decode(errors="replace").strip()
    except OSError:
        return ""
    return printable(text)[-SHOWN:]


def printable(text: str) -> str:
    """The text with a question mark for what a terminal would obey."""
    return "".join(c if c.isprintable() or c == "\n" else "?" for c in text)
