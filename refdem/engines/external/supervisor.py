"""Runs programs one after another for the process that started it, and ends all that they start.

A script with the standard library alone, started by process.py as `python -I -S supervisor.py
FOLDER PROCESS`. Its standard input is a socket: a line of JSON with the descriptors of the
program's output comes in, a line of JSON goes out. It adopts orphans (PR_SET_CHILD_SUBREAPER), so
that every process that a program has started, in whatever session, is a descendant of it; and when
the socket is closed, because refdem has ended in whatever way, it ends them and itself. It is two
processes: one serves, the other ends what is left where a program has killed the one that serves.
The folder is that of all runs of the process, which it takes away if that process was killed.

A program may also stay alive (class Service): what comes in is then a line for it, and what goes
out is the line with which it answered, or how it failed to.
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
"""Seconds in which what a program has started may end after it."""
ENDING = 60.0
"""Seconds that the end of a killed process may take."""
PAUSE = 0.01
"""Seconds between looks at processes that are ending."""
LOOK = 0.1
"""Seconds between looks at the memory of a program: at 2 GB/s it takes 0.2 GB between two."""
MEMORY = (b"RssAnon:", b"RssShmem:", b"VmSwap:")
"""Lines of /proc/PID/status, see proc(5), whose sum is the memory that a program has taken."""
GOODBYE = b"end"
"""What comes over the socket where refdem goes on without this process; nothing comes where refdem
itself was killed.
"""
STREAMS = 3
"""Standard input, output and error."""
DISMISSED = 0
"""Exit status of the process that serves, when refdem goes on without it."""
ABANDONED = 3
"""Exit status of the process that serves, when refdem is gone."""
MOST_ASKED = 2**20
"""Bytes of a line that asks for a run."""
MOST_LINE = 2**16
"""Bytes of a line with which a program that stays alive answers; a reason takes some hundred."""
MOST_MESSAGES = 2**26
"""Bytes of messages that a program that stays alive may write during one request."""
LAST_MESSAGES = 2**12
"""Bytes of them that are kept, the last ones."""
MOST_READ = 2**16
"""Bytes that are read from a pipe at once: as many as a pipe holds."""
MOST_DRAINED = 64
"""Reads of a pipe whose program is thought to be silent."""
SHOWN = 500
"""Characters of a line that an answer about it has."""
ANSWERS = ("done", "unsupported", "failed")
"""The answers to a request; an answer has one of these words."""


def answer_of(line: dict[str, Any]) -> str | None:
    """The word of ANSWERS with which a line answers a request; None of a line that does not: done
    is true, and a refusal or a failure says why.
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
    """Nobody waits for the run any more."""


class TooMuchMemoryError(Exception):
    """A process of the run has taken more memory than it may."""

    def __init__(self, taken: int) -> None:
        super().__init__(taken)
        self.taken = taken


class FaultError(Exception):
    """A program that stays alive has not answered as it should; `said` tells refdem how."""

    def __init__(self, fault: str, **said: Any) -> None:
        super().__init__(fault)
        self.said: dict[str, Any] = {"fault": fault, **said}


class Service:
    """A program that stays alive: its process, the pipes to and from it, and what came out.

    `phase` is what it does: it starts, works on a request, or rests (`idle`).
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
        self.told = 0
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
        """Closes its standard input: it is to end."""
        os.close(self.asking)
        self.asking = -1

    def write(self, line: str) -> None:
        """Sends a line; raises FaultError if the program does not read."""
        try:
            os.write(self.asking, line.encode() + b"\n")
        except BlockingIOError:
            raise FaultError("deaf") from None
        except BrokenPipeError:
            # It has ended, which is seen by who waits for a line, or has closed its standard input.
            self.is_deaf = True

    def begin(self, phase: str) -> None:
        """Notes that it does something else now; messages that follow are about that."""
        self.phase = phase
        self.messages = b""
        self.told = 0

    def line(self) -> "bytes | None":
        """The next whole line that came out, if there is one."""
        line, end, rest = self.text.partition(b"\n")
        if not end:
            return None
        self.text = rest
        return line

    def read(self) -> None:
        """Takes in what has come out since; raises FaultError for too much of it."""
        if self.answering in self.open:
            part = self.part(self.answering)
            self.text += part
            if len(self.text) > MOST_LINE and b"\n" not in self.text[:MOST_LINE]:
                raise FaultError("long", most=MOST_LINE, line=shown(self.text))
        if self.telling in self.open:
            part = self.part(self.telling)
            self.told += len(part)
            self.messages = (self.messages + part)[-LAST_MESSAGES:]
            if self.told > MOST_MESSAGES:
                raise FaultError("flood", most=MOST_MESSAGES)

    def part(self, pipe: int) -> bytes:
        """What a pipe holds; one that has ended is noted."""
        try:
            part = os.read(pipe, MOST_READ)
        except BlockingIOError:
            return b""
        if not part:
            self.open.discard(pipe)
        return part

    def drain(self) -> None:
        """Takes in what is there, of a program that writes no more: what writes without end is left
        alone after MOST_DRAINED looks.
        """
        for _ in range(MOST_DRAINED):
            before = self.told, len(self.text)
            self.read()
            if before == (self.told, len(self.text)):
                return

    @property
    def silence(self) -> str:
        """Why no line comes: it cannot say one any more, does not hear that it should, or hangs."""
        if self.answering not in self.open:
            return "closed"
        if self.is_deaf:
            return "deaf"
        return "hang"

    def refuse_memory(self, most: int) -> None:
        """Raises FaultError if a process of the program has taken more than `most` bytes; looks
        again a while after the last look, whichever request that belonged to.
        """
        if time.monotonic() < self.look:
            return
        taken = max(map(memory_of, descendants()), default=0)
        self.look = time.monotonic() + LOOK
        if taken > most:
            raise FaultError("memory", taken=taken)

    @property
    def said(self) -> str:
        """The end of its messages."""
        return self.messages.decode(errors="replace")


class Supervisor:
    """Answers what comes over a socket until it is closed."""

    def __init__(self, asked: socket.socket) -> None:
        self.asked = asked
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
                self.asked.sendall(json.dumps(answer).encode() + b"\n")
            except OSError:
                # Nobody waits for the answer any more; why was said before.
                self.is_dismissed = self.asked.recv(len(GOODBYE)) == GOODBYE
                raise

    def received(self) -> "tuple[dict[str, Any], list[int]] | None":
        """The next request with its descriptors, or None."""
        text = b""
        descriptors: list[int] = []
        while not text.endswith(b"\n"):
            part, more, _, _ = socket.recv_fds(self.asked, MOST_ASKED, 2)
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
            asked = self.asked.fileno()
            ready, _, _ = select.select([asked, self.woken], [], [], min(left, LOOK))
            if asked in ready:
                self.is_dismissed = self.asked.recv(len(GOODBYE)) == GOODBYE
                raise AbandonedError
            # Not only where nothing happens: a program may end children without end.
            if time.monotonic() >= look:
                look = time.monotonic() + LOOK
                taken = max(map(memory_of, descendants()), default=0)
                if taken > most:
                    raise TooMuchMemoryError(taken)
            with contextlib.suppress(BlockingIOError):
                os.read(self.woken, 4096)

    def served(self, request: "dict[str, Any]") -> "dict[str, Any]":
        """The answer of the program that stays alive, which is started where it does not run.

        A program that did not answer as it should is ended: the next request starts another.
        """
        service = self.service
        try:
            start = 0.0
            if service is None:
                began = time.monotonic()
                service = self.service = Service(request)
                self.ready(service, request)
                start = time.monotonic() - began
            return self.answered(service, request) | {"start": start, "said": service.said}
        except FaultError as fault:
            end_descendants()
            if service is None:
                return fault.said | {"phase": "start", "said": ""}
            with contextlib.suppress(FaultError):
                service.drain()
            service.close()
            self.service = None
            return fault.said | {"phase": service.phase, "said": service.said}

    def ready(self, service: Service, request: "dict[str, Any]") -> None:
        """Waits until the program says that it is ready; raises FaultError if it does not."""
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
        # No line that the program writes moves this limit.
        until = began + request["warm"] + request["timeout"]
        service.write(request["line"])
        while True:
            line = self.next_line(service, until, request["memory"])
            answer = dictionary(line)
            # A program may take the id for a number.
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
        """Raises FaultError if a program has ended, or has written a line, that nobody asked."""
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
        AbandonedError if nobody waits for it any more.
        """
        while True:
            # Not only where nothing happens: a program may answer at once, and take more each time.
            service.refuse_memory(most)
            service.read()
            line = service.line()
            if line is not None:
                return line
            self.refuse_end(service)
            left = until - time.monotonic()
            if left <= 0:
                raise FaultError(service.silence, half=shown(service.text))
            asked = self.asked.fileno()
            heard = [asked, self.woken, *service.open]
            if service.silence != "hang":
                # No answer can come any more: its end is what is waited for, not long.
                until = min(until, time.monotonic() + GRACE)
            ready, _, _ = select.select(heard, [], [], min(left, LOOK))
            if asked in ready:
                self.is_dismissed = self.asked.recv(len(GOODBYE)) == GOODBYE
                raise AbandonedError

    def refuse_end(self, service: Service) -> None:
        """Raises FaultError if the program has ended without another line."""
        with contextlib.suppress(BlockingIOError):
            os.read(self.woken, 4096)
        self.reap(service)
        if service.status is None:
            return
        # What it wrote before its end may have come between the last look and this one.
        service.drain()
        if b"\n" not in service.text:
            raise FaultError("ended", status=service.status, half=shown(service.text))

    def reap(self, service: Service) -> None:
        """Notes how the program ended, if it has."""
        statuses = reaped()
        if service.process in statuses:
            service.status = os.waitstatus_to_exitcode(statuses[service.process])

    def retire(self) -> None:
        """Lets the program that stays alive end by itself, for a while, if refdem goes on."""
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
    """What a line of JSON in UTF-8 says; raises FaultError unless it is a dictionary of which each
    word is said once.
    """
    try:
        # From bytes, UTF-16 would be read as well.
        said = json.loads(line.decode("utf-8-sig"), object_pairs_hook=each_once)
    except (ValueError, RecursionError):
        said = None
    if not isinstance(said, dict):
        raise FaultError("stray", line=shown(line))
    return said


def each_once(pairs: "list[tuple[str, Any]]") -> "dict[str, Any]":
    """The dictionary of these pairs; raises ValueError where a key comes twice."""
    said = dict(pairs)
    if len(said) < len(pairs):
        raise ValueError
    return said


def shown(text: bytes) -> str:
    """The begin of what a program wrote."""
    return text[:SHOWN].decode(errors="replace")


def limit_files(processes: "list[int]", most: int) -> None:
    """No file that these processes write gets longer than `most` bytes; Linux only.

    The limit is the soft one, which rises again for a longer answer.
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
    told, telling = os.pipe()
    program = os.fork()
    if program == 0:
        try:
            become(request, descriptors)
        except BaseException as error:
            os.write(telling, str(error).encode(errors="replace")[:1000])
        os._exit(127)
    os.close(telling)
    # The pipe closes by itself when the program begins.
    problem = b""
    while part := os.read(told, 4096):
        problem += part
    os.close(told)
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
    """No more of something than `most`, or than was allowed before."""
    _, allowed = resource.getrlimit(kind)
    most = lower(most, allowed)
    resource.setrlimit(kind, (most, most))


def ended_first() -> None:
    """Where memory ends before a limit is reached, the kernel takes this process and its children
    rather than the one that judges them.
    """
    with contextlib.suppress(OSError), open("/proc/self/oom_score_adj", "w") as file:
        file.write("1000")


def memory_of(process: int) -> int:
    """Bytes of memory that a process has made its own: anonymous, shared with other processes, and
    swapped out; 0 if it has ended (Linux).

    Pages of files do not count, which the kernel can drop at any time. Neither does memory that is
    only reserved. A limit of the system's (RLIMIT_AS, RLIMIT_DATA) would count it, and end every
    program that was built with a sanitizer, which reserves 15 TB.
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

    Orphans are adopted, so that without a child there is no descendant. The kernel answers this at
    one instant; a walk over /proc does not, and misses a process that begins during the walk and
    whose parent has ended before the walk is there.
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
    """How many processes of a program that has ended are still there after a while."""
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
        # Where a walk over /proc finds nothing, one process hands on to the next: look at once.
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
            # The name of the program, in brackets, may hold anything: what follows the last bracket
            # counts.
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
    # A program must not be able to answer for itself: it gets neither this descriptor nor this
    # standard input. Where refdem has no standard output or no standard error, 1 or 2 are free, and
    # the copy must not lie there.
    asked = socket.socket(fileno=fcntl.fcntl(0, fcntl.F_DUPFD_CLOEXEC, STREAMS))
    nothing = os.open(os.devnull, os.O_RDWR)
    for target in (0, 1):
        os.dup2(nothing, target)
    if not is_open(2):
        os.dup2(nothing, 2)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        # What ends refdem closes the socket.
        signal.signal(number, signal.SIG_IGN)
    control(PR_SET_CHILD_SUBREAPER, 1)
    serving = os.fork()
    if serving == 0:
        serve(asked)
    asked.close()
    # Told, not asked for: whoever started this may be gone by now.
    guard(serving, int(sys.argv[2]), Path(sys.argv[1]))


def serve(asked: socket.socket) -> None:
    """Answers what comes over the socket, ends what is left then, and ends this process."""
    control(PR_SET_CHILD_SUBREAPER, 1)
    supervisor = Supervisor(asked)
    try:
        with contextlib.suppress(OSError, AbandonedError):
            supervisor.answers()
    finally:
        end_descendants()
    if supervisor.is_dismissed:
        os._exit(DISMISSED)
    os._exit(ABANDONED)


def guard(serving: int, parent: int, folder: Path) -> None:
    """Waits for the process that serves refdem, and ends what that has left: a program may kill it,
    which is its parent, and would leave behind what it has put into other sessions.
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
    """Takes a folder away with all that is in it; what cannot be taken away stays."""
    try:
        shutil.rmtree(folder, onerror=_opened_up)
    except RecursionError:
        # Folders in folders, thousands deep: chmod and rm do not recurse.
        for command in (["chmod", "-R", "u+rwX"], ["rm", "-rf"]):
            subprocess.run(
                [*command, "--", str(folder)],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                check=False,
            )


def _opened_up(_: Callable[..., Any], path: str, __: object) -> None:
    """Tries once more where a program has taken the rights to a folder away."""
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
    """Whether refdem was killed, and could not take its folder away.

    A process that ends closes its sockets before its children get another parent, so that this
    has to wait a moment; for ever it would wait for a refdem that goes on and said no goodbye.
    """
    until = time.monotonic() + ENDING
    while os.getppid() == parent:
        if time.monotonic() > until:
            return False
        time.sleep(PAUSE)
    return True


if __name__ == "__main__":
    main()
