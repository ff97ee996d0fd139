"""Runs programs one after another for the process that started it, and ends every process that
they start.

This script needs only the standard library. process.py starts it as `python -I -S supervisor.py
FOLDER PROCESS`. Its standard input is a socket: a request is a line of JSON with the descriptors of
the program's output, and the answer is a line of JSON. It adopts orphans (PR_SET_CHILD_SUBREAPER),
so that every process that a program has started, in any session, is its descendant. The socket is
closed when refdem ends for any reason; then the supervisor ends all descendants and itself. It
consists of two processes: one serves requests, the other ends the remaining processes if a program
has killed the first one. FOLDER holds all runs of the process PROCESS; it is deleted if that
process was killed.

A program may also stay alive (class Service). A request is then a line for that program, and the
answer is the line that it wrote, or the kind of its failure.
"""

import contextlib
import ctypes
import fcntl
import json
import os
import resource
import select
import shutil
import signal
import socket
import stat
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

PR_SET_PDEATHSIG = 1
"""Operation of prctl(2), from <sys/prctl.h>: the signal that a child gets when its parent ends."""
PR_SET_CHILD_SUBREAPER = 36
"""Operation of prctl(2), from <sys/prctl.h>: orphans among the descendants become children."""
GRACE = 1.0
"""Seconds within which the child processes of a program may end after it."""
ENDING = 60.0
"""Seconds within which a killed process ends."""
PAUSE = 0.01
"""Seconds between checks of processes that are ending."""
LOOK = 0.1
"""Seconds between checks of a program's memory: at 2 GB/s it allocates 0.2 GB between two."""
MEMORY = (b"RssAnon:", b"RssShmem:", b"VmSwap:")
"""Lines of /proc/PID/status, see proc(5), whose sum is the memory that a program uses."""
GOODBYE = b"end"
"""The message over the socket if refdem continues without this process. If refdem itself was
killed, the socket closes without it.
"""
STREAMS = 3
"""Standard input, output and error."""
DISMISSED = 0
"""Exit status of the process that serves, when refdem goes on without it."""
ABANDONED = 3
"""Exit status of the process that serves, when refdem is gone."""
MOST_REQUEST = 2**20
"""Most bytes of a line that requests a run."""
MOST_LINE = 2**16
"""Most bytes of an answer of a program that stays alive; a reason takes some hundred."""
MOST_MESSAGES = 2**26
"""Most bytes of messages that a program that stays alive may write during one request."""
LAST_MESSAGES = 2**12
"""Bytes of these messages that are kept, the last ones."""
MOST_READ = 2**16
"""Bytes that are read from a pipe at once: as many as a pipe holds."""
MOST_DRAINED = 64
"""Most reads of a pipe whose program is expected to write nothing more."""
SHOWN = 500
"""Most characters of a program's line that an answer quotes."""
ANSWERS = ("done", "unsupported", "failed")
"""The answers to a request; an answer has one of these words."""


def answer_of(line: dict[str, Any]) -> str | None:
    """The word of ANSWERS with which a line answers a request; None if the line is no answer.

    The value of `done` must be true, and that of `unsupported` or `failed` a text with the reason.
    """
    words = [word for word in ANSWERS if word in line]
    if "id" not in line or len(words) != 1:
        return None
    (word,) = words
    if word == "done":
        fits = line[word] is True
    else:
        fits = isinstance(line[word], str)
    if not fits:
        return None
    return word


class AbandonedError(Exception):
    """The process that requested the run no longer waits for it."""


class TooMuchMemoryError(Exception):
    """A process of the run has exceeded its memory limit."""

    def __init__(self, taken: int) -> None:
        super().__init__(taken)
        self.taken = taken


class FaultError(Exception):
    """A program that stays alive violated the protocol; `details` describes it for refdem."""

    def __init__(self, fault: str, **details: Any) -> None:
        super().__init__(fault)
        self.details: dict[str, Any] = {"fault": fault, **details}


class Service:
    """A program that stays alive: its process, the pipes to and from it, and its output so far.

    `phase` is its state: it starts, works on a request, or is `idle`.
    """

    def __init__(self, request: "dict[str, Any]") -> None:
        """Starts it; raises FaultError if that is impossible."""
        theirs_in, self.asking = os.pipe()
        self.answering, theirs_out = os.pipe()
        self.telling, theirs_err = os.pipe()
        for descriptor in (self.asking, self.answering, self.telling):
            os.set_blocking(descriptor, False)
        program, problem = started(request, [theirs_in, theirs_out, theirs_err])
        for descriptor in (theirs_in, theirs_out, theirs_err):
            os.close(descriptor)
        self.phase = "start"
        self.status: int | None = None
        self.text = b""
        self.messages = b""
        self.message_bytes = 0
        self.open = {self.answering, self.telling}
        self.is_deaf = False
        self.look = time.monotonic() + LOOK
        if program is None:
            self.close()
            raise FaultError("problem", words=problem)
        self.process = program

    def close(self) -> None:
        """Closes the pipes to and from the program."""
        for descriptor in (self.asking, self.answering, self.telling):
            if descriptor >= 0:
                os.close(descriptor)
        self.asking = self.answering = self.telling = -1

    def hang_up(self) -> None:
        """Closes its standard input, which requests it to end."""
        os.close(self.asking)
        self.asking = -1

    def write(self, line: str) -> None:
        """Sends a line; raises FaultError if the program does not read."""
        try:
            os.write(self.asking, line.encode() + b"\n")
        except BlockingIOError:
            raise FaultError("deaf") from None
        except BrokenPipeError:
            # Either it has ended, which the wait for its next line detects, or it has closed its
            # standard input.
            self.is_deaf = True

    def begin(self, phase: str) -> None:
        """Starts a new phase; later messages on standard error belong to it."""
        self.phase = phase
        self.messages = b""
        self.message_bytes = 0

    def line(self) -> "bytes | None":
        """The next complete line of its output, if there is one."""
        line, end, rest = self.text.partition(b"\n")
        if not end:
            return None
        self.text = rest
        return line

    def read(self) -> None:
        """Reads the output since the last call; raises FaultError if it is too long."""
        if self.answering in self.open:
            part = self.part(self.answering)
            self.text += part
            if len(self.text) > MOST_LINE and b"\n" not in self.text[:MOST_LINE]:
                raise FaultError("long", most=MOST_LINE, line=shown(self.text))
        if self.telling in self.open:
            part = self.part(self.telling)
            self.message_bytes += len(part)
            self.messages = (self.messages + part)[-LAST_MESSAGES:]
            if self.message_bytes > MOST_MESSAGES:
                raise FaultError("flood", most=MOST_MESSAGES)

    def part(self, pipe: int) -> bytes:
        """The content of a pipe; the end of the pipe is recorded."""
        try:
            part = os.read(pipe, MOST_READ)
        except BlockingIOError:
            return b""
        if not part:
            self.open.discard(pipe)
        return part

    def drain(self) -> None:
        """Reads the remaining output of a program that is expected to write nothing more.

        It stops after MOST_DRAINED reads, as a program may write without end.
        """
        for _ in range(MOST_DRAINED):
            before = self.message_bytes, len(self.text)
            self.read()
            if before == (self.message_bytes, len(self.text)):
                return

    @property
    def silence(self) -> str:
        """Why no line is read: its output is closed, it does not read its input, or it hangs."""
        if self.answering not in self.open:
            return "closed"
        if self.is_deaf:
            return "deaf"
        return "hang"

    def refuse_memory(self, most: int) -> None:
        """Raises FaultError if a process of the program uses more than `most` bytes.

        The memory is checked at a fixed interval, also across requests.
        """
        if time.monotonic() < self.look:
            return
        taken = max(map(memory_of, descendants()), default=0)
        self.look = time.monotonic() + LOOK
        if taken > most:
            raise FaultError("memory", taken=taken)

    @property
    def last_messages(self) -> str:
        """The end of its messages."""
        return self.messages.decode(errors="replace")


class Supervisor:
    """Answers what comes over a socket until it is closed."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        self.is_dismissed = False
        self.service: Service | None = None
        self.woken, waking = os.pipe()
        os.set_blocking(self.woken, False)
        os.set_blocking(waking, False)
        # The end of a child writes a byte into the pipe, so that one `select` waits for it and for
        # the socket.
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(waking)

    def answers(self) -> None:
        """Runs what is requested until there are no more requests."""
        while True:
            received = self.received()
            if received is None:
                self.retire()
                return
            request, descriptors = received
            if "line" in request:
                answer = self.served(request)
            else:
                answer = self.answer(request, descriptors)
            try:
                self.connection.sendall(json.dumps(answer).encode() + b"\n")
            except OSError:
                # refdem no longer waits for the answer; it may have sent GOODBYE before.
                self.is_dismissed = self.connection.recv(len(GOODBYE)) == GOODBYE
                raise

    def received(self) -> "tuple[dict[str, Any], list[int]] | None":
        """The next request with its descriptors, or None."""
        text = b""
        descriptors: list[int] = []
        while not text.endswith(b"\n"):
            part, more, _, _ = socket.recv_fds(self.connection, MOST_REQUEST, 2)
            if not part:
                self.is_dismissed = text == GOODBYE
                return None
            text += part
            descriptors += more
        request: dict[str, Any] = json.loads(text)
        return request, descriptors

    def answer(self, request: "dict[str, Any]", descriptors: "list[int]") -> "dict[str, Any]":
        """The answer that describes how a run ended."""
        began = time.monotonic()
        program, problem = started(request, descriptors)
        for descriptor in descriptors:
            os.close(descriptor)
        if program is None:
            return {"problem": problem}
        try:
            status = self.waited(program, began + request["timeout"], request["memory"])
        except TooMuchMemoryError as error:
            end_descendants()
            return {"memory": error.taken}
        seconds = time.monotonic() - began
        if status is None:
            left = 0
        else:
            left = lingering()
        end_descendants()
        return {"status": status, "seconds": seconds, "left": left}

    def waited(self, program: int, until: float, most: int) -> "int | None":
        """The exit status of the program, None if it was still running `until` then; raises
        AbandonedError, and TooMuchMemoryError if one of its processes takes more than `most` bytes.
        """
        look = time.monotonic() + LOOK
        while True:
            statuses = reaped()
            if program in statuses:
                return os.waitstatus_to_exitcode(statuses[program])
            left = until - time.monotonic()
            if left <= 0:
                return None
            connection = self.connection.fileno()
            ready, _, _ = select.select([connection, self.woken], [], [], min(left, LOOK))
            if connection in ready:
                self.is_dismissed = self.connection.recv(len(GOODBYE)) == GOODBYE
                raise AbandonedError
            # This is checked in every pass: children that end all the time would keep `select`
            # from timing out.
            if time.monotonic() >= look:
                look = time.monotonic() + LOOK
                taken = max(map(memory_of, descendants()), default=0)
                if taken > most:
                    raise TooMuchMemoryError(taken)
            with contextlib.suppress(BlockingIOError):
                os.read(self.woken, 4096)

    def served(self, request: "dict[str, Any]") -> "dict[str, Any]":
        """The answer of the program that stays alive, which is started if it does not run.

        A program that violates the protocol is ended, and the next request starts a new process.
        """
        service = self.service
        try:
            start = 0.0
            if service is None:
                began = time.monotonic()
                service = self.service = Service(request)
                self.ready(service, request)
                start = time.monotonic() - began
            return self.answered(service, request) | {"start": start, "said": service.last_messages}
        except FaultError as fault:
            end_descendants()
            if service is None:
                return fault.details | {"phase": "start", "said": ""}
            with contextlib.suppress(FaultError):
                service.drain()
            service.close()
            self.service = None
            return fault.details | {"phase": service.phase, "said": service.last_messages}

    def ready(self, service: Service, request: "dict[str, Any]") -> None:
        """Waits until the program reports that it is ready; raises FaultError if it does not."""
        until = time.monotonic() + request["ready"]
        line = self.next_line(service, until, request["memory"])
        if dictionary(line).get("ready") is not True:
            raise FaultError("stray", line=shown(line))

    def answered(self, service: Service, request: "dict[str, Any]") -> "dict[str, Any]":
        """The answer to one request, the seconds of warming up for it and of stepping."""
        self.refuse_noise(service)
        service.begin("request")
        limit_files([service.process, *descendants()], request["bytes"])
        began = time.monotonic()
        warm = None
        # Lines that the program writes do not extend this limit.
        until = began + request["warm"] + request["timeout"]
        service.write(request["line"])
        while True:
            line = self.next_line(service, until, request["memory"])
            answer = dictionary(line)
            # A program may return the id as a number.
            if "id" in answer and str(answer["id"]) != request["id"]:
                raise FaultError("other", line=shown(line))
            word = answer_of(answer)
            if word is not None:
                break
            is_warm = "id" in answer and answer.get("warm") is True
            if not is_warm or warm is not None:
                raise FaultError("stray", line=shown(line))
            warm = time.monotonic()
            until = min(until, warm + request["timeout"])
        ended = time.monotonic()
        if warm is None:
            warm = began
        service.drain()
        service.phase = "idle"
        return {
            "answer": word,
            "reason": shown(str(answer[word]).encode(errors="replace")),
            "warm": warm - began,
            "seconds": ended - warm,
        }

    def refuse_noise(self, service: Service) -> None:
        """Raises FaultError if a program has ended or has written a line without a request."""
        if service.phase != "idle":
            return
        service.read()
        self.reap(service)
        line = service.line()
        if line is not None:
            raise FaultError("stray", line=shown(line))
        if service.status is not None:
            raise FaultError("ended", status=service.status, half=shown(service.text))

    def next_line(self, service: Service, until: float, most: int) -> bytes:
        """The next line that the program writes `until` then; raises FaultError if none comes,
        AbandonedError if refdem no longer waits for it.
        """
        while True:
            # This is checked in every pass: a program may answer at once and use more memory each
            # time.
            service.refuse_memory(most)
            service.read()
            line = service.line()
            if line is not None:
                return line
            self.refuse_end(service)
            left = until - time.monotonic()
            if left <= 0:
                raise FaultError(service.silence, half=shown(service.text))
            connection = self.connection.fileno()
            heard = [connection, self.woken, *service.open]
            if service.silence != "hang":
                # No answer is possible any more; wait briefly for the program to end.
                until = min(until, time.monotonic() + GRACE)
            ready, _, _ = select.select(heard, [], [], min(left, LOOK))
            if connection in ready:
                self.is_dismissed = self.connection.recv(len(GOODBYE)) == GOODBYE
                raise AbandonedError

    def refuse_end(self, service: Service) -> None:
        """Raises FaultError if the program has ended without another line."""
        with contextlib.suppress(BlockingIOError):
            os.read(self.woken, 4096)
        self.reap(service)
        if service.status is None:
            return
        # It may have written more between the last read and its end.
        service.drain()
        if b"\n" not in service.text:
            raise FaultError("ended", status=service.status, half=shown(service.text))

    def reap(self, service: Service) -> None:
        """Notes how the program ended, if it has."""
        statuses = reaped()
        if service.process in statuses:
            service.status = os.waitstatus_to_exitcode(statuses[service.process])

    def retire(self) -> None:
        """Gives the program that stays alive some time to end by itself, if refdem continues."""
        service = self.service
        if service is None or not self.is_dismissed:
            return
        service.hang_up()
        until = time.monotonic() + GRACE
        while service.status is None and service.open and time.monotonic() < until:
            select.select([self.woken, *service.open], [], [], LOOK)
            with contextlib.suppress(BlockingIOError):
                os.read(self.woken, 4096)
            with contextlib.suppress(FaultError):
                service.read()
            service.text = b""
            self.reap(service)


def dictionary(line: bytes) -> "dict[str, Any]":
    """The content of a line of JSON in UTF-8; raises FaultError unless it is a dictionary without
    repeated keys.
    """
    try:
        # From bytes, UTF-16 would be read as well.
        content = json.loads(line.decode("utf-8-sig"), object_pairs_hook=each_once)
    except (ValueError, RecursionError):
        content = None
    if not isinstance(content, dict):
        raise FaultError("stray", line=shown(line))
    return content


def each_once(pairs: "list[tuple[str, Any]]") -> "dict[str, Any]":
    """The dictionary of these pairs; raises ValueError where a key comes twice."""
    content = dict(pairs)
    if len(content) < len(pairs):
        raise ValueError
    return content


def shown(text: bytes) -> str:
    """The beginning of a program's output, as text."""
    return text[:SHOWN].decode(errors="replace")


def limit_files(processes: "list[int]", most: int) -> None:
    """Limits the size of every file that these processes write to `most` bytes; Linux only.

    Only the soft limit is set, so that it can be raised again for a longer answer.
    """
    if not hasattr(resource, "prlimit"):
        return
    for process in processes:
        with contextlib.suppress(OSError):
            _, allowed = resource.prlimit(process, resource.RLIMIT_FSIZE)
            resource.prlimit(process, resource.RLIMIT_FSIZE, (lower(most, allowed), allowed))


def lower(most: int, allowed: int) -> int:
    """The lower of two limits, of which the second may be none."""
    if allowed == resource.RLIM_INFINITY:
        return most
    return min(most, allowed)


def started(request: "dict[str, Any]", descriptors: "list[int]") -> "tuple[int | None, str]":
    """The process of a program in a session of its own, or None and why it cannot be started."""
    reading, writing = os.pipe()
    program = os.fork()
    if program == 0:
        try:
            become(request, descriptors)
        except BaseException as error:
            os.write(writing, str(error).encode(errors="replace")[:1000])
        os._exit(127)
    os.close(writing)
    # The pipe closes by itself when the program begins.
    problem = b""
    while part := os.read(reading, 4096):
        problem += part
    os.close(reading)
    if problem:
        os.waitpid(program, 0)
        return None, problem.decode(errors="replace")
    return program, ""


def become(request: "dict[str, Any]", descriptors: "list[int]") -> None:
    """Turns this child into the program; returns only by an exception."""
    os.setsid()
    control(PR_SET_PDEATHSIG, signal.SIGKILL)
    signal.set_wakeup_fd(-1)
    for number in (
        signal.SIGCHLD,
        signal.SIGPIPE,
        signal.SIGXFSZ,
        signal.SIGINT,
        signal.SIGTERM,
        signal.SIGHUP,
    ):
        signal.signal(number, signal.SIG_DFL)
    if "line" in request:
        # The limit on files follows each request (`limit_files`).
        sources = descriptors
    else:
        sources = [os.open(os.devnull, os.O_RDONLY), *descriptors]
        limited(resource.RLIMIT_FSIZE, request["bytes"])
    for target, source in enumerate(sources):
        os.dup2(source, target)
    limited(resource.RLIMIT_CORE, 0)
    ended_first()
    os.chdir(request["folder"])
    command = request["command"]
    os.execvpe(command[0], command, os.environ | request["environment"])


def limited(kind: int, most: int) -> None:
    """Sets a resource limit to `most`, or to the previous hard limit if that is lower."""
    _, allowed = resource.getrlimit(kind)
    most = lower(most, allowed)
    resource.setrlimit(kind, (most, most))


def ended_first() -> None:
    """Makes the kernel kill this process and its children first if the machine runs out of memory.

    The process that judges them then survives.
    """
    with contextlib.suppress(OSError), open("/proc/self/oom_score_adj", "w") as file:
        file.write("1000")


def memory_of(process: int) -> int:
    """Bytes of memory that a process uses: anonymous, shared and swapped out (Linux).

    It is 0 if the process has ended. Pages of files, which the kernel can drop at any time, and
    memory that is only reserved do not count. The system's limits (RLIMIT_AS, RLIMIT_DATA) count
    reserved memory. They would end every program built with a sanitizer, which reserves 15 TB.
    """
    try:
        with open(f"/proc/{process}/status", "rb") as file:
            lines = file.read().splitlines()
    except OSError:
        return 0
    # As in "RssShmem:      1536 kB".
    sizes = [line.split()[1] for line in lines if line.startswith(MEMORY)]
    return 1024 * sum(map(int, sizes))


def reaped() -> "dict[int, int]":
    """The wait statuses of all children that have ended."""
    statuses = {}
    with contextlib.suppress(ChildProcessError):
        while True:
            process, status = os.waitpid(-1, os.WNOHANG)
            if process == 0:
                break
            statuses[process] = status
    return statuses


def has_children() -> bool:
    """Whether a child of this process runs; those that have ended are reaped. Linux only.

    Orphans are adopted, so that without a child there is no descendant. The kernel's answer is
    atomic. A walk over /proc is not: it misses a process that starts during the walk if its parent
    ends before the walk reaches it.
    """
    if not os.path.isdir("/proc/self"):
        return False
    try:
        while os.waitpid(-1, os.WNOHANG) != (0, 0):
            pass
    except ChildProcessError:
        return False
    return True


def lingering() -> int:
    """The number of processes of an ended program that still run after a grace period."""
    until = time.monotonic() + GRACE
    while has_children():
        if time.monotonic() > until:
            return max(1, len(descendants()))
        time.sleep(PAUSE)
    return 0


def end_descendants() -> None:
    """Ends all that this process has started or adopted.

    They are stopped first, so that none starts another meanwhile.
    """
    while has_children():
        there = descendants()
        for number in (signal.SIGSTOP, signal.SIGKILL):
            for process in there:
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.kill(process, number)
        # If a walk over /proc finds no process while a child exists, processes replace one another
        # quickly, so the next walk starts at once.
        if there:
            time.sleep(PAUSE)


def descendants(top: "int | None" = None) -> "list[int]":
    """All processes below `top`, this one by default, that have not ended."""
    children: dict[int, list[int]] = {}
    if not os.path.isdir("/proc/self"):  # not Linux
        return []
    for name in os.listdir("/proc"):
        if not name.isdigit():
            continue
        with contextlib.suppress(OSError):
            with open(f"/proc/{name}/stat", "rb") as file:
                text = file.read()
            # The name of the program, in brackets, may hold any characters, so the fields are read
            # after the last bracket.
            state, parent = text[text.rindex(b")") + 1 :].split()[:2]
            if state not in (b"Z", b"X"):
                children.setdefault(int(parent), []).append(int(name))
    processes: list[int] = []
    waiting = [top or os.getpid()]
    while waiting:
        for process in children.get(waiting.pop(), []):
            processes.append(process)
            waiting.append(process)
    return processes


def control(option: int, value: int) -> None:
    """prctl(option, value); Linux only."""
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(option, value, 0, 0, 0)


def is_open(descriptor: int) -> bool:
    """Whether a descriptor leads to anything."""
    try:
        os.fstat(descriptor)
    except OSError:
        return False
    return True


def main() -> None:
    """Answers over standard input."""
    # A program must not be able to write answers itself, so it inherits neither this descriptor nor
    # this standard input. If refdem has no standard output or no standard error, descriptors 1 or 2
    # are free, and the copy must not get one of these numbers.
    connection = socket.socket(fileno=fcntl.fcntl(0, fcntl.F_DUPFD_CLOEXEC, STREAMS))
    nothing = os.open(os.devnull, os.O_RDWR)
    for target in (0, 1):
        os.dup2(nothing, target)
    if not is_open(2):
        os.dup2(nothing, 2)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        # These signals are ignored: if one of them ends refdem, the socket closes.
        signal.signal(number, signal.SIG_IGN)
    control(PR_SET_CHILD_SUBREAPER, 1)
    serving = os.fork()
    if serving == 0:
        serve(connection)
    connection.close()
    # The process id is an argument and not os.getppid(), as the parent may have ended by now.
    guard(serving, int(sys.argv[2]), Path(sys.argv[1]))


def serve(connection: socket.socket) -> None:
    """Answers all requests, then ends the remaining descendants and this process."""
    control(PR_SET_CHILD_SUBREAPER, 1)
    supervisor = Supervisor(connection)
    try:
        with contextlib.suppress(OSError, AbandonedError):
            supervisor.answers()
    finally:
        end_descendants()
    if supervisor.is_dismissed:
        os._exit(DISMISSED)
    os._exit(ABANDONED)


def guard(serving: int, parent: int, folder: Path) -> None:
    """Waits for the process that serves refdem, and ends its remaining descendants.

    A program may kill its parent, the process that serves, and would then leave behind the
    processes that it has started in other sessions.
    """
    _, status = os.waitpid(serving, 0)
    end_descendants()
    code = os.waitstatus_to_exitcode(status)
    if code == ABANDONED:
        is_killed = is_orphan(parent)
    else:
        is_killed = code != DISMISSED and os.getppid() != parent
    if is_killed:
        remove(folder)


def remove(folder: Path) -> None:
    """Deletes a folder with its contents, as far as possible."""
    try:
        shutil.rmtree(folder, onerror=_opened_up)
    except RecursionError:
        # Folders may be nested thousands deep; unlike shutil, chmod and rm do not exceed a
        # recursion limit.
        for command in (["chmod", "-R", "u+rwX"], ["rm", "-rf"]):
            subprocess.run(
                [*command, "--", str(folder)],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                check=False,
            )


def _opened_up(_: Callable[..., Any], path: str, __: object) -> None:
    """Restores the permissions that a program has removed from a folder, and tries once more."""
    there = Path(path)
    with contextlib.suppress(OSError):
        for place in (there.parent, there):
            if place.is_dir() and not place.is_symlink():
                place.chmod(stat.S_IRWXU)
        if there.is_dir() and not there.is_symlink():
            shutil.rmtree(there, ignore_errors=True)
        elif there.exists() or there.is_symlink():
            there.unlink()


def is_orphan(parent: int) -> bool:
    """Whether refdem was killed, and could not delete its folder.

    A process that ends closes its sockets before its children get a new parent, so that this
    function waits for a limited time. A refdem that continues without having sent GOODBYE would
    otherwise make it wait for ever.
    """
    until = time.monotonic() + ENDING
    while os.getppid() == parent:
        if time.monotonic() > until:
            return False
        time.sleep(PAUSE)
    return True


if __name__ == "__main__":
    main()
