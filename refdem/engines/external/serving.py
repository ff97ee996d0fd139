"""Programs that stay alive (`serve = true`): each thread has its own process of a program, which
answers one request after another. If it hangs or crashes, only that request fails, and the next
request starts a new process.

Requests to such a program and its answers are lines of JSON:

    {"ready": true}                                      from it, once, when it has started
    {"id": "1", "request": "/.../request.json", ...}     to it, with the paths of files
    {"id": "1", "warm": true}                            from it, optional: compilation has ended
    {"id": "1", "done": true}                            from it, or `unsupported`, or `failed`
"""

import atexit
import contextlib
import json
import threading
import weakref
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from refdem.core.outside import one_line
from refdem.core.problem import Request
from refdem.engines.external.folders import is_there, made_in_home
from refdem.engines.external.process import (
    MAX_OUTPUT,
    Limits,
    Supervised,
    status_words,
    too_much_memory,
)
from refdem.engines.external.supervisor import remove
from refdem.errors import EngineError, HangError, UsageError

READY = '{"ready": true}'
"""The first line of a program that stays alive."""
ADVICE = (
    "standard output is reserved for answers; write messages to standard error, those of"
    " libraries included (docs/programs.md, A program that stays alive)"
)
MOST_SERVED = 8
"""Most programs that one thread keeps alive, those that it used last."""
NOT_AGAIN = "; it was not started again"
"""Text after the failure of the last start, in the errors of later requests."""
MOST_STARTS = 2
"""Number of failed starts after which a program is not started again."""
SHOWN = 120
"""Most characters of a line of a program that an error shows."""
_LOCAL = threading.local()
_ALIVE: "weakref.WeakSet[Served]" = weakref.WeakSet()
"""The processes of all threads."""
_FAILED_STARTS: dict["Identity", list[EngineError]] = {}

Identity = tuple[object, ...]
"""The state of a program: its command, its files and their modification times."""


@dataclass(frozen=True, kw_only=True)
class ServedLimits(Limits):
    """The limits of a request to a program that stays alive.

    In addition to those of a run: `start_timeout` [s] until a started program is ready, and
    `warm_up` [s] that a request may take in addition if the program reports that it has warmed up.
    """

    start_timeout: float
    warm_up: float


@dataclass(frozen=True, kw_only=True)
class WrittenRequest:
    """A request, the files of its folder by name, and its limits."""

    request: Request
    paths: dict[str, Path]
    limits: ServedLimits

    def line(self, number: str) -> str:
        """The line that the program reads, without its newline."""
        return line_of(number, self.request.method, {n: str(p) for n, p in self.paths.items()})


@dataclass(frozen=True, kw_only=True)
class Reply:
    """The answer to a request.

    `answer` is `done` or `unsupported`, with a `reason`; `seconds` are those of stepping and
    `setup` those of set-up; `messages` is the program's standard error; `before` is the request
    that the same process had answered before, if any.
    """

    answer: str
    reason: str
    seconds: float
    setup: float
    messages: str
    before: Request | None


def line_of(number: str, method: str, paths: dict[str, str]) -> str:
    """A request as one line of JSON; its strings need no escapes, so that a program in C or Fortran
    finds them by their quotes.

    Raises UsageError for a path that has a quote, a backslash or what does not print.
    """
    for path in paths.values():
        if not path.isprintable() or '"' in path or "\\" in path:
            raise UsageError(
                f"the path {one_line(path)!r} cannot be sent to a program; expected one without"
                " quotes and backslashes: set TMPDIR, or name another folder"
            )
    return json.dumps({"id": number, "method": method} | paths, ensure_ascii=False)


class Served:
    """A program that stays alive, with its supervisor and the folder that it runs in."""

    def __init__(self, name: str, command: list[str]) -> None:
        """Starts the supervisor; the program starts with the first request."""
        self.name = name
        self.command = command
        self.folder = made_in_home(name)
        self.supervised = Supervised()
        self.count = 0
        self.before: Request | None = None
        _end_all_at_exit()
        _ALIVE.add(self)

    @property
    def is_there(self) -> bool:
        """Whether its supervisor runs."""
        return self.supervised.process.poll() is None

    def reply(self, written_request: WrittenRequest) -> Reply:
        """The reply to a request; raises EngineError if there is none, or a failure."""
        self.count += 1
        number = str(self.count)
        limits = written_request.limits
        if not is_there(self.folder):
            # An earlier process may have deleted the folder; the next one gets a new folder.
            self.folder = made_in_home(self.name)
        message = {
            "command": self.command,
            "folder": str(self.folder),
            "environment": {"TMPDIR": str(self.folder.parent)},
            "ready": limits.start_timeout,
            "warm": limits.warm_up,
            "timeout": limits.timeout,
            "bytes": limits.file_bytes,
            "memory": limits.memory,
            "id": number,
            "line": written_request.line(number),
        }
        answer = self.supervised.answer(message, [])
        before = self.before
        if "fault" in answer:
            self.before = None
            raise self._error(answer, message)
        self.before = written_request.request
        if answer["answer"] == "failed":
            raise EngineError(f"{self.name} failed: {one_line(answer['reason'])[:MAX_OUTPUT]}")
        return Reply(
            answer=answer["answer"],
            reason=one_line(answer["reason"])[:MAX_OUTPUT],
            seconds=answer["seconds"],
            setup=answer["start"] + answer["warm"],
            messages=answer["said"],
            before=before,
        )

    def _error(self, answer: dict[str, Any], message: dict[str, Any]) -> EngineError:
        """The error for a request that the program did not answer properly."""
        if answer["fault"] == "memory":
            return too_much_memory(message, answer["taken"])
        sentence = f"{self.name} {_FAULTS[answer['fault']](answer, message)}"
        messages = one_line(" / ".join(answer["said"].strip().splitlines()))[-MAX_OUTPUT:]
        if messages:
            sentence += f" (standard error: {messages})"
        if answer["phase"] == "start":
            return NotStartedError(sentence)
        if answer["fault"] == "hang":
            return HangError(sentence)
        return EngineError(sentence)

    def close(self) -> None:
        """Lets the program end, or ends it."""
        _ALIVE.discard(self)
        self.supervised.close()
        if self.folder.exists():
            remove(self.folder)

    def __del__(self) -> None:
        self.close()


class NotStartedError(EngineError):
    """A program that stays alive did not get ready."""


def _half(answer: dict[str, Any]) -> str:
    """The unfinished last line of the program's output."""
    if not answer["half"]:
        return ""
    return f", after half a line {one_line(answer['half'], SHOWN)!r}"


def _ended(answer: dict[str, Any], _: dict[str, Any]) -> str:
    """The words for a program that ended instead of staying alive."""
    words = f"ended with {status_words(answer['status'])}"
    half = _half(answer)
    if answer["phase"] == "start":
        return f"{words} before it was ready to read requests{half}"
    if answer["phase"] == "idle":
        return (
            f"{words} after its answer to the request before this one{half}; expected a program"
            " that reads requests until its standard input ends"
        )
    return f"{words} and did not answer{half}"


def _hung(answer: dict[str, Any], message: dict[str, Any]) -> str:
    """The words for a program that exceeded a time limit."""
    if answer["phase"] == "start":
        return (
            f"was not ready after {message['ready']:g} s and was ended; expected the line {READY}"
            " on standard output, flushed, as soon as it can read requests (`start_timeout` in"
            f" refdem.toml){_half(answer)}"
        )
    return f"was still running after {message['timeout']:g} s and was ended{_half(answer)}"


def _stray(answer: dict[str, Any], message: dict[str, Any]) -> str:
    """The words for a line that is no answer."""
    expected = f'{{"id": "{message["id"]}", "done": true}}, `unsupported` or `failed`'
    when = "as the answer to a request"
    if answer["phase"] == "start":
        expected = READY
        when = "as its first line"
    if answer["phase"] == "idle":
        expected = "nothing before the next request"
        when = "after its answer to the request before this one"
    return f"wrote {one_line(answer['line'], SHOWN)!r} {when}; expected {expected}: {ADVICE}"


def _other(answer: dict[str, Any], message: dict[str, Any]) -> str:
    """The words for an answer with the id of another request."""
    return (
        f"wrote {one_line(answer['line'], SHOWN)!r} as the answer to request {message['id']!r};"
        " expected the id of the request, each answered before the next is read"
    )


_FAULTS: dict[str, Callable[[dict[str, Any], dict[str, Any]], str]] = {
    "problem": lambda answer, _: f"cannot be started: {one_line(answer['words'])}",
    "ended": _ended,
    "hang": _hung,
    "stray": _stray,
    "other": _other,
    "long": lambda answer, _: (
        f"wrote a line of more than {answer['most']} bytes to standard output, beginning with"
        f" {one_line(answer['line'], SHOWN)!r}: {ADVICE}"
    ),
    "flood": lambda answer, _: (
        f"wrote more than {answer['most']} bytes to standard error during one request and was ended"
    ),
    "closed": lambda _, __: (
        "closed its standard output and did not answer; expected a program that leaves it open"
    ),
    "deaf": lambda _, __: (
        "does not read its standard input; expected one line read for each request"
    ),
}
"""The words for each kind of fault of a program that stays alive."""


class Exchange:
    """Requests to a program that stays alive, one after another, and the replies.

    They go to the program of the thread that calls `made`, or to a `fresh` one, which is ended
    afterwards.
    """

    def __init__(
        self,
        name: str,
        command: list[str],
        identity: Identity,
        requests: list[WrittenRequest],
        *,
        is_fresh: bool = False,
    ) -> None:
        """Prepares the exchange; a running process is used only if its `identity` is the same."""
        self.name = name
        self.command = command
        self.identity = (is_fresh, *identity)
        self.requests = requests
        self.is_fresh = is_fresh
        self.replies: list[Reply] = []

    def made(self) -> float:
        """Seconds of stepping; raises EngineError for the first request that is not answered."""
        failed = _FAILED_STARTS.setdefault(self.identity, [])
        if len(failed) >= MOST_STARTS:
            raise NotStartedError(f"{failed[-1]}{NOT_AGAIN}")
        if self.is_fresh:
            with contextlib.closing(Served(self.name, self.command)) as served:
                self._ask(served)
        else:
            self._ask(self._of_thread())
        return sum(reply.seconds for reply in self.replies)

    def _ask(self, served: Served) -> None:
        """Asks one request after another."""
        for request in self.requests:
            try:
                self.replies.append(served.reply(request))
            except NotStartedError as error:
                _FAILED_STARTS[self.identity].append(error)
                raise

    def _of_thread(self) -> Served:
        """The program of this thread, which is made where there is none."""
        of_thread: OfThread | None = getattr(_LOCAL, "of_thread", None)
        if of_thread is None:
            of_thread = _LOCAL.of_thread = OfThread()
        alive = of_thread.alive
        served = alive.pop(self.identity, None)
        if served is not None and not served.is_there:
            served.close()
            served = None
        if served is None:
            served = Served(self.name, self.command)
        alive[self.identity] = served
        while len(alive) > MOST_SERVED:
            _, oldest = alive.popitem(last=False)
            oldest.close()
        return served


class OfThread:
    """The programs of one thread, in the order of their last use; they are ended with the thread.

    Only the thread refers to this object, so that it is deleted with the thread. A program itself
    may be referred to by the traceback of an error that is kept longer.
    """

    def __init__(self) -> None:
        self.alive: OrderedDict[Identity, Served] = OrderedDict()

    def __del__(self) -> None:
        for served in self.alive.values():
            served.close()


@cache
def _end_all_at_exit() -> None:
    """Registers that programs that stay alive are ended when this process exits.

    It is called after the folder of all runs is made, so that they end before it is deleted
    (functions registered with atexit run in reverse order).
    """
    atexit.register(end_served)


def end_served() -> None:
    """Ends all programs that stay alive."""
    for served in tuple(_ALIVE):
        served.close()
