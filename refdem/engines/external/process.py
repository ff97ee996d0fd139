"""A program under limits on its time, its memory and the size of its files; no process of it stays
behind.

Every thread that runs programs has a supervisor (supervisor.py). This small process starts programs
one after another and ends the processes that they leave, also if refdem itself is killed.
"""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from refdem.core.outside import made, one_line
from refdem.engines.external.folders import home
from refdem.engines.external.supervisor import ENDING, GOODBYE, descendants
from refdem.errors import EngineError, HangError, UnsupportedError

NOT_SUPPORTED = 77
"""Exit status of a program that does not support a request. The protocol defines it; automake uses
the same status for a skipped test.
"""
GIGABYTE = 10**9
"""Bytes of a gigabyte, decimal as in the limits that engine.toml sets."""
SHARE = 0.9
"""Fraction of the machine's memory that a process of a program may use by default."""
CONTROL_GROUPS = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")
"""Where Linux keeps the limit of a container: control groups version 2, and 1."""
MAX_OUTPUT = 300
"""Characters of a program's output that an error or a refusal shows."""
HELD_UP = 2 * ENDING
"""Seconds within which a supervisor answers after the time limit of a run, on any machine. Until
then it ends the processes that the program left, and possibly a program that stayed alive.
"""
LONGEST_WAIT = 2e6
"""Seconds for which a socket can wait, at most: poll(2) counts milliseconds in 31 bits."""
LONGEST_CHARACTER = 4
"""Bytes of a character in UTF-8, at most."""
SUPERVISOR = Path(__file__).with_name("supervisor.py")
EMPTY: Mapping[str, str] = {}
_LOCAL = threading.local()
_BUSY: set["Supervised"] = set()
"""Supervisors whose programs are under way, of all threads."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """The limits of a run: time [s], bytes of each file that it writes, bytes of memory of each of
    its processes.
    """

    timeout: float
    file_bytes: int
    memory: int


@dataclass(frozen=True)
class Ended:
    """How a program ended: its exit status, None if its time was up; seconds; how many processes it
    left running.
    """

    status: int | None
    seconds: float
    left: int


def most_memory() -> int:
    """Bytes that a process of a program may use by default: a fraction of the memory of the machine
    or of the container in which refdem runs.
    """
    limits = [os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")]
    for place in CONTROL_GROUPS:
        # "max" stands for no limit.
        with contextlib.suppress(OSError, ValueError):
            limits.append(int(Path(place).read_text()))
    return int(SHARE * min(limits))


class Supervised:
    """The supervisor of one thread."""

    def __init__(self) -> None:
        self.socket, theirs = socket.socketpair()
        # -I and -S: neither the user's settings nor the installed packages are read.
        own = [str(home()), str(os.getpid())]
        command = [sys.executable, "-I", "-S", str(SUPERVISOR), *own]
        with theirs:
            self.process = subprocess.Popen(command, stdin=theirs.fileno(), start_new_session=True)
        self.answers = self.socket.makefile("rb")

    def ended(self, request: dict[str, Any], out: BinaryIO, err: BinaryIO) -> Ended:
        """Runs the requested program; raises EngineError if it cannot be started or if the
        supervisor itself was killed.
        """
        answer = self.answer(request, [out.fileno(), err.fileno()])
        if "memory" in answer:
            raise too_much_memory(request, answer["memory"])
        if "problem" in answer:
            raise EngineError(
                f"{request['command'][0]} cannot be started: {one_line(answer['problem'])}"
            )
        return Ended(answer["status"], answer["seconds"], answer["left"])

    def answer(self, request: dict[str, Any], descriptors: list[int]) -> dict[str, Any]:
        """The supervisor's answer to a request.

        Raises EngineError if the supervisor was killed, or does not answer in time because a
        program stopped it by a signal. If an exception such as Ctrl-C interrupts the wait, the
        supervisor is ended. Otherwise its late answer would be taken for that to the next request.
        """
        line = b""
        limits = sum(request.get(limit, 0.0) for limit in ("ready", "warm", "timeout"))
        self.socket.settimeout(min(HELD_UP + limits, LONGEST_WAIT))
        _BUSY.add(self)
        try:
            text = json.dumps(request).encode() + b"\n"
            socket.send_fds(self.socket, [text], descriptors)
            line = self.answers.readline()
        except OSError:
            line = b""
        finally:
            _BUSY.discard(self)
            if not line:
                self.close()
        if not line:
            raise EngineError(
                f"{request['command'][0]} was terminated externally, together with its supervisor"
                " process"
            )
        answer: dict[str, Any] = json.loads(line)
        return answer

    def stop(self) -> None:
        """Ends what it runs, from any thread."""
        with contextlib.suppress(OSError):
            self.socket.sendall(GOODBYE)
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Ends the supervisor and the processes that it runs."""
        self.stop()
        self.answers.close()
        self.socket.close()
        # A supervisor that was stopped by a signal continues, and ends the programs that it runs.
        self.process.send_signal(signal.SIGCONT)
        try:
            self.process.wait(ENDING)
        except subprocess.TimeoutExpired:
            for process in descendants(self.process.pid):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(process, signal.SIGKILL)
            self.process.kill()
            self.process.wait()

    def __del__(self) -> None:
        self.close()


def supervised() -> Supervised:
    """The supervisor of this thread, which is started where there is none."""
    supervisor: Supervised | None = getattr(_LOCAL, "supervised", None)
    if supervisor is None or supervisor.process.poll() is not None:
        supervisor = _LOCAL.supervised = Supervised()
    return supervisor


def run(
    command: list[str],
    folder: Path,
    out: BinaryIO,
    err: BinaryIO,
    limits: Limits,
    environment: Mapping[str, str] = EMPTY,
) -> Ended:
    """Runs a command in a folder, without input; `environment` is added to that of this process."""
    request = {
        "command": command,
        "folder": str(folder),
        "environment": dict(environment),
        "timeout": limits.timeout,
        "bytes": limits.file_bytes,
        "memory": limits.memory,
    }
    return supervised().ended(request, out, err)


def ended(command: list[str], folder: Path, *, name: str, limits: Limits) -> float:
    """Runs the command in `folder`, its output in stdout.txt and stderr.txt there, and then ends
    all that it has started.

    Returns the seconds that it took. Raises UnsupportedError for exit status 77, EngineError if it
    cannot start, does not end in time, ends with another status, or leaves processes behind.
    """
    # The output is read through the open descriptor, because a program may replace the file.
    with made(folder / "stdout.txt") as out, made(folder / "stderr.txt") as err:
        # A program that empties TMPDIR then empties only the home of its own engine.
        exit = run(command, folder, out, err, limits, {"TMPDIR": str(folder.parent)})
        says = _last_lines(err)
    if exit.status is None:
        raise HangError(f"{name} was still running after {limits.timeout:g} s and was ended")
    if exit.status == NOT_SUPPORTED:
        reason = "the program reports that the scene is not supported (exit status 77)"
        if says:
            reason = one_line(says[-1][-MAX_OUTPUT:])
        raise UnsupportedError(reason)
    if exit.status != 0:
        output = one_line(" / ".join(says))[-MAX_OUTPUT:]
        raise EngineError(
            f"{name} ended with {status_words(exit.status)}: {output or 'stderr is empty'}"
        )
    if exit.left:
        raise EngineError(
            f"{name} ended and left {exit.left} of its processes running, which were ended;"
            " expected a program that waits for the processes that it starts"
        )
    return exit.seconds


def too_much_memory(request: dict[str, Any], taken: int) -> EngineError:
    """The error of a program of which a process used `taken` bytes of memory."""
    most = request["memory"] / GIGABYTE
    return EngineError(
        f"{request['command'][0]} took {taken / GIGABYTE:.3g} GB of memory and was ended; expected"
        f" at most {most:.3g} GB for each of its processes (`memory` in refdem.toml)"
    )


def end_all() -> None:
    """Ends every program that any thread waits for."""
    for supervisor in tuple(_BUSY):
        supervisor.stop()


def status_words(status: int) -> str:
    """How a process ended, in words."""
    if status >= 0:
        return f"exit status {status}"
    with contextlib.suppress(ValueError):
        name = signal.Signals(-status).name
        if name == "SIGXFSZ":
            return f"signal {-status} ({name}: a file grew too large)"
        return f"signal {-status} ({name})"
    return f"signal {-status}"


def _last_lines(file: BinaryIO) -> list[str]:
    """The last lines of the program's output, at least MAX_OUTPUT characters where there are so
    many.
    """
    # The first character may be cut, and so is no part of these; a line end follows the last one.
    most = LONGEST_CHARACTER * (MAX_OUTPUT + 1)
    size = os.fstat(file.fileno()).st_size
    text = os.pread(file.fileno(), most, max(0, size - most))
    return text.decode(errors="replace").strip().splitlines()
