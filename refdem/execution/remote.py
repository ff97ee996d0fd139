"""The functions of a cluster's worker for a campaign: it checks whether its code is the expected
one, and makes runs.

All of its inputs and results are text or MessagePack of the documents below, which the receiver
validates.
"""

import multiprocessing
import threading
import time
from collections.abc import Iterable, Iterator
from functools import lru_cache

import msgspec

from refdem.core import discovery, fingerprint
from refdem.core.engine import Engine
from refdem.core.run import Failure
from refdem.errors import RefdemError
from refdem.execution import worker
from refdem.execution.schedule import Job, Schedule

SHOWN = 12
"""Hexadecimal digits of a digest in a sentence; 48 bits distinguish any two states of a code."""
NOT_BEGUN = Failure(kind="not begun", sentence="the batch took too long", is_begun=False)


class MethodState(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A method of the engine at an address, and the fingerprint of all that can change its runs."""

    engine: str
    method: str
    fingerprint: str


class CodeState(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The state of the code of one process: digests of refdem, of the processor's features, and of
    every method that is to run.
    """

    refdem: str
    machine: str
    methods: list[MethodState]


class Errand(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One run: the address of its engine, the packed request, its time limit [s], and the time [s]
    within which it must begin.

    If it `computes`, the limit is one of CPU time.
    """

    engine: str
    request: bytes
    limit: float
    seconds_left: float
    computes: bool


class Batch(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Runs for one worker, and the state of the code that they need, as MessagePack of CodeState.

    After `longest` [s] the worker begins no further run. The remaining runs are returned, to be
    distributed again, or to be given up if others hung.
    """

    expected: bytes
    longest: float
    errands: list[Errand]


class Outcome(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The end of one run: the bytes of a reply, or a failure; with neither it was not started."""

    reply: bytes | None = None
    failure: Failure | None = None


class Returned(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The outcomes of a batch in its order and the seconds that it took; or why the worker cannot
    run any of it.
    """

    outcomes: list[Outcome]
    seconds: float
    mismatch: str = ""


def code_state(engines: Iterable[Engine]) -> bytes:
    """The state of the code of this process, for all methods of these engines, as MessagePack of
    CodeState.
    """
    methods = [
        MethodState(engine.address, method.name, engine.fingerprint(method))
        for engine in engines
        for method in engine.methods
    ]
    state = CodeState(
        refdem=fingerprint.of_refdem(), machine=fingerprint.of_machine(), methods=methods
    )
    return msgspec.msgpack.encode(state)


@lru_cache(maxsize=8)
def mismatch(expected: bytes) -> str:
    """The reason why runs of this process may differ from those of the process with the state
    `expected`, or an empty text.

    It is computed once for each state, since the code of a process does not change.
    """
    state = msgspec.msgpack.decode(expected, type=CodeState)
    here = fingerprint.of_refdem()
    if here != state.refdem:
        return (
            f"its refdem has the digest {here[:SHOWN]}; expected {state.refdem[:SHOWN]}, that of"
            " the refdem that started the campaign: install the same wheel there, or share one"
            " environment"
        )
    if fingerprint.of_machine() != state.machine:
        return (
            "its processor has other features than that of the machine that started the campaign,"
            " and results are bitwise equal on one kind of processor only: run `refdem run` on a"
            " machine of the workers' kind"
        )
    reasons = [reason for method in state.methods if (reason := _misfit_of(method))]
    # The methods of one engine usually have the same reason.
    return "; ".join(dict.fromkeys(reasons))


def _misfit_of(expected: MethodState) -> str:
    """Why one method would run differently here than in the requesting process; empty if it would
    not.
    """
    try:
        engine = discovery.engine(expected.engine)
        missing = engine.missing()
        if missing:
            return f"engine {engine.name} is not installed there: {missing}"
        here = engine.fingerprint(engine.method(expected.method))
    except (RefdemError, OSError) as error:
        return f"engine {expected.engine} cannot be read there: {error}"
    if here != expected.fingerprint:
        return (
            f"method {expected.method} of engine {engine.name} has the fingerprint"
            f" {here[:SHOWN]}; expected {expected.fingerprint[:SHOWN]}: install the same version"
            " of the engine there, from the same files"
        )
    return ""


IDLE = 60.0
"""Seconds without a batch after which a worker ends the processes that it has started for runs,
because refdem was killed or the scheduler is lost. They can be restarted within a few seconds.
"""


class _Processes:
    """The schedule of one thread of a worker: one process, which runs the engines.

    An engine that crashes or hangs ends only that process and its run; the worker continues.
    """

    def __init__(self) -> None:
        self._busy = threading.Lock()
        self._schedule: Schedule | None = None
        self._idle = threading.Timer(IDLE, self.rest)

    def results(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes | Failure]]:
        """Every job once with its bytes or its Failure, in the order in which they end."""
        self._idle.cancel()
        with self._busy:
            if self._schedule is None:
                self._schedule = Schedule(1, timeout=0.0)
            yield from self._schedule.results(jobs)
        self._idle = threading.Timer(IDLE, self.rest)
        self._idle.daemon = True
        self._idle.start()

    def rest(self) -> None:
        """Ends the process, and the programs that it keeps alive, unless it is busy.

        The next batch starts a new process.
        """
        if not self._busy.acquire(blocking=False):
            return
        try:
            if self._schedule is not None:
                self._schedule.__exit__()
                self._schedule = None
        finally:
            self._busy.release()


_here = threading.local()
_OF_THREADS: list[_Processes] = []
"""The schedules of all threads of this worker."""


def _schedule() -> _Processes:
    """The schedule of this thread."""
    if not hasattr(_here, "schedule"):
        # The nanny starts a worker as a daemon, which may not have child processes.
        multiprocessing.current_process().daemon = False
        _here.schedule = _Processes()
        _OF_THREADS.append(_here.schedule)
    schedule: _Processes = _here.schedule
    return schedule


def rested() -> None:
    """Ends what this worker keeps running for runs, except what another campaign uses now."""
    for processes in tuple(_OF_THREADS):
        processes.rest()


class _Begin:
    """Decides whether a run may still be started. The first answer is kept: a run that was started
    continues to its end.
    """

    def __init__(self, end: float) -> None:
        self._end = end
        self._is_begun = False

    def __call__(self) -> Failure | None:
        if self._is_begun or time.monotonic() < self._end:
            self._is_begun = True
            return None
        return NOT_BEGUN


def made(batch_bytes: bytes) -> bytes:
    """The outcomes of a batch of runs, as MessagePack of Returned."""
    begin = time.monotonic()
    batch = msgspec.msgpack.decode(batch_bytes, type=Batch)
    reason = mismatch(batch.expected)
    if reason:
        return msgspec.msgpack.encode(Returned(outcomes=[], seconds=0.0, mismatch=reason))
    jobs = [
        _job(number, errand, begin, begin + batch.longest)
        for number, errand in enumerate(batch.errands)
    ]
    outcomes = [Outcome()] * len(jobs)
    for job, result in _schedule().results(jobs):
        if isinstance(result, bytes):
            outcomes[job.key] = Outcome(reply=result)
        elif result != NOT_BEGUN:
            outcomes[job.key] = Outcome(failure=result)
    seconds = time.monotonic() - begin
    return msgspec.msgpack.encode(Returned(outcomes=outcomes, seconds=seconds))


def _job(number: int, errand: Errand, begin: float, end: float) -> Job:
    """The run of an errand in the process of this thread, for a batch that began at `begin` [s];
    after `end` [s] only the first run of the batch is started.
    """
    given_up = _Begin(end)
    if number == 0:
        # The first run is always started, so that a returned batch is at least one run shorter.
        given_up = _Begin(float("inf"))
    return Job(
        number,
        worker.run,
        (errand.engine, errand.request, begin + errand.seconds_left),
        errand.limit,
        computes=errand.computes,
        given_up=given_up,
    )
