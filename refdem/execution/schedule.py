"""The schedule: jobs are given to worker processes, and results are returned as they end; a crash
or a hang fails only its own job.

Programs are separate processes already, so that threads wait for a few runs of them, and no worker
is started for these.
"""

import ctypes
import math
import os
import resource
import signal
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from concurrent.futures import TimeoutError as FutureTimeout
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any, Protocol, TypeVar
from weakref import WeakKeyDictionary

from refdem.core.engine import Stages, Waiting
from refdem.core.outside import one_line
from refdem.core.run import Failure
from refdem.execution.spawning import Spawning, unblock_interrupts

READ_HERE = 25_000
"""Rows of answers that this process reads in the CPU time that the start of a worker takes."""
RUN = 250
"""Rows that take as long to read as all other work of this process for a run."""
SLOWER = 10.0
"""Largest permitted ratio of wall-clock time to CPU time of a computation. On two processors with
sixteen other busy processes it is nine.
"""
PR_SET_PDEATHSIG = 1
"""Operation of prctl(2), from <sys/prctl.h>: the signal that a child gets when its parent ends."""
PAUSE = 0.02
"""Seconds between checks of programs that are being ended."""
LOOK = 1.0
"""Seconds between checks of the pool of workers while no result arrives."""
MOST_WAITING = 2**24
"""Bytes of arguments of queued jobs above which no further job is handed to the workers before one
of them is free.
"""
UNTAKEN = 60.0
"""Seconds for which a job may wait although a worker is free, including the start of a worker.
After that the job is lost: a worker that is killed while it takes a job cannot report it.
"""
POOLS = 3
"""Number of consecutive broken pools, without a result between them, after which jobs fail."""
NEVER_BEGUN = (
    f"the worker process died while it started, {POOLS} times in a row: the machine may be short of"
    " memory, or its processes are being killed"
)


Progress = Callable[[str, int, int], None]
"""A function that is called with the stage, the number of its finished jobs, and their total."""

Result = TypeVar("Result")


def counted(
    results: Iterable[Result], stage: str, total: int, progress: Progress
) -> Iterator[Result]:
    """The same results; progress is informed that the stage begins, before any work for it is
    done, and whenever a result has been handled.
    """
    if total:
        progress(stage, 0, total)
    for done, result in enumerate(results, 1):
        yield result
        progress(stage, done, total)


@dataclass(frozen=True)
class Job:
    """A function of a module and its arguments, all of them bytes, text or plain containers; `key`
    is returned with the result.

    The time limit is `timeout` [s], or that of the schedule without one, times `patience`. If the
    job only `computes`, the limit is one of CPU time, so that it does not depend on the load of the
    machine; if such a job waits instead, the clock ends it at SLOWER times the limit. A job that
    runs a program with its own time limit also has `stages`, which do the same as the function, and
    the number of `rows` of the answer.
    """

    key: Any
    function: Callable[..., bytes]
    arguments: tuple[Any, ...] = ()
    timeout: float | None = None
    patience: float = 1.0
    computes: bool = False
    stages: Callable[..., Stages[bytes]] | None = None
    rows: int = 0
    given_up: Callable[[], Failure | None] = lambda: None
    """Called just before the job begins: the reason why it is not run any more, or None."""
    pack: Callable[[], tuple[Any, ...]] | None = None
    """Makes the arguments just before the job begins, if those of all jobs need much memory."""

    def ready(self) -> "Job":
        """The same job with its arguments made."""
        if self.pack is None:
            return self
        return replace(self, arguments=self.pack(), pack=None)


class Scheduler(Protocol):
    """Whatever makes jobs: this process, processes of this machine, or a cluster."""

    def __enter__(self) -> Any: ...

    def __exit__(self, *error: object) -> None: ...

    def results(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes | Failure]]:
        """Every job once with its bytes or its Failure, in the order in which they end."""
        ...


class InProcess:
    """Runs jobs in this process, for engine objects; it does not protect from hangs or crashes."""

    def __enter__(self) -> "InProcess":
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def results(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes | Failure]]:
        """Every job once with its bytes, in order."""
        for job in jobs:
            yield job, job.given_up() or job.function(*job.ready().arguments)


class Programs:
    """Runs programs, `most` at a time.

    Threads only wait for them; all other work is done in the thread that iterates over results.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._threads = ThreadPoolExecutor(most)
        self._running: dict[Future[float], tuple[Job, Stages[bytes]]] = {}

    def results(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes | Failure]]:
        """Every job once with its bytes or its Failure, in the order in which they end."""
        fresh = iter(jobs)
        going = list[tuple[Job, Stages[bytes], Waiting]]()
        while True:
            for job, stages, result in going:
                ended = self._gone_on(job, stages, result)
                if ended is not None:
                    yield job, ended
            going = []
            # One more job than can run is started, so that a processor is not idle during the work
            # of this thread. A job that waits for its program again has kept its place.
            begun = list(islice(fresh, self._most + 1 - len(self._running)))
            for job in begun:
                failure = job.given_up()
                if failure is not None:
                    yield job, failure
                elif job.stages is not None:
                    ended = self._gone_on(job, job.stages(*job.ready().arguments), None)
                    if ended is not None:
                        yield job, ended
            if not begun and not self._running:
                return
            if self._running:
                done = wait(self._running, return_when=FIRST_COMPLETED).done
                going = [(*self._running.pop(future), future.result) for future in done]

    def _gone_on(
        self, job: Job, stages: Stages[bytes], result: Waiting | None
    ) -> bytes | Failure | None:
        """The result of a job that has ended; None if it waits for its program again.

        `result` is what the wait returned or raised, None for a job that is starting.
        """
        try:
            if result is None:
                waiting = next(stages)
            else:
                waiting = stages.send(result)
        except StopIteration as end:
            ended: bytes = end.value
            return ended
        except Exception as error:
            return _failure(error)
        self._running[self._threads.submit(waiting)] = job, stages
        return None

    def end(self) -> None:
        """Ends the programs that still run, and prevents others from starting."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        while not all(future.done() for future in self._running):
            from refdem.engines.external.process import end_all

            end_all()
            time.sleep(PAUSE)
        for _, stages in self._running.values():
            stages.close()


class Schedule:
    """Worker processes (spawned, so that no state is shared); a job that takes longer than
    `timeout` [s] is killed.
    """

    def __init__(self, workers: int, timeout: float) -> None:
        self._most = workers
        self._timeout = timeout
        self._pool: Any = None
        self._size = 0
        self._in_order = 0.0
        """When jobs were last seen to be taken [s]."""
        self._has_lost = False
        """Whether jobs were lost since the last result."""
        self._programs = Programs(workers)
        self._sizes = WeakKeyDictionary[Any, int]()
        """Bytes of the arguments of the jobs that run, by their futures."""

    def __enter__(self) -> "Schedule":
        return self

    def __exit__(self, *error: object) -> None:
        self._programs.end()
        self._dismiss()

    def results(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes | Failure]]:
        """Every job once with its bytes or its Failure, in the order in which they end."""
        rows = sum(RUN + job.rows for job in jobs)
        if rows < READ_HERE and all(job.stages for job in jobs):
            return self._programs.results(jobs)
        return self._working(jobs)

    def _working(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes | Failure]]:
        """The results of worker processes.

        A worker that dies during its start, or while it returns a result, breaks the whole pool.
        The pool is then replaced, and its jobs are handed to the new one. If POOLS consecutive
        pools break without a result, these jobs fail.
        """
        self._employ(min(self._most, len(jobs)))
        self._in_order = time.monotonic()
        waiting = deque(jobs)
        running = dict[Any, Job]()
        broken_pools = 0
        while waiting or running:
            yield from self._hand_over(waiting, running)
            done, _ = wait(running, timeout=LOOK, return_when=FIRST_COMPLETED)
            unanswered = []
            for future in done:
                job = running.pop(future)
                result = self._result(future, job)
                if result is None:
                    unanswered.append(job)
                else:
                    broken_pools = 0
                    yield job, result
            unanswered += self._lost(running, is_going=bool(done))
            if not self._pool.active:
                unanswered += running.values()
                running = {}
                broken_pools += 1
                self._dismiss()
                self._hire()
            if broken_pools < POOLS:
                waiting.extendleft(unanswered)
            else:
                broken_pools = 0
                for job in unanswered:
                    yield job, Failure(kind="crash", sentence=NEVER_BEGUN)
            yield from take_back(running)

    def _lost(self, running: dict[Any, Job], *, is_going: bool) -> list[Job]:
        """The jobs that no worker has taken for UNTAKEN seconds although one is free; they are
        removed from `running`. `is_going` is true if a result has just arrived.

        If this happens twice without a result, the pool is stopped: a worker that was killed while
        it returned a result has left an incomplete one, and the pool waits for the rest.
        """
        untaken = [future for future in running if not (future.running() or future.done())]
        taken = len(running) - len(untaken)
        if is_going or not untaken or taken >= self._size:
            self._in_order = time.monotonic()
        if is_going:
            self._has_lost = False
        if time.monotonic() - self._in_order < UNTAKEN:
            return []
        self._in_order = time.monotonic()
        if self._has_lost:
            self._pool.stop()
        self._has_lost = True
        for future in untaken:
            future.cancel()
        return [running.pop(future) for future in untaken]

    def _hand_over(
        self, waiting: deque[Job], running: dict[Any, Job]
    ) -> Iterator[tuple[Job, Failure]]:
        """Hands jobs to the workers while these have few; yields those that are given up."""
        while waiting and self._has_room(running) and self._pool.active:
            job = waiting.popleft()
            failure = job.given_up()
            if failure is not None:
                yield job, failure
                continue
            future = self._begun(job)
            if future is None:
                waiting.appendleft(job)
            else:
                running[future] = job

    def _has_room(self, running: dict[Any, Job]) -> bool:
        """True if the workers have few jobs: one more than can run at once, or, where their
        arguments are small, a few for each.
        """
        if len(running) <= self._size:
            return True
        size = sum(self._sizes[future] for future in running)
        return len(running) < 4 * self._size and size < MOST_WAITING

    def _employ(self, workers: int) -> None:
        """Starts `workers` workers, unless there are as many already."""
        if self._size < workers:
            self._dismiss()
            self._size = workers
            self._hire()

    def _hire(self) -> None:
        """Makes the pool of workers."""
        from pebble import ProcessPool  # slow to import, and not needed for programs

        self._pool = ProcessPool(
            max_workers=self._size,
            context=Spawning(),  # type: ignore[arg-type]
            initializer=begin,
            initargs=(os.getpid(), tempfile.gettempdir()),
        )

    def _dismiss(self) -> None:
        """Ends the workers, whatever they are doing."""
        if self._pool is not None:
            self._pool.stop()
            self._pool.join()

    def _begun(self, job: Job) -> Any:
        """The future of a job that is handed to a worker process; None if the pool is broken."""
        limit = job.patience * (job.timeout or self._timeout)
        arguments = job.ready().arguments
        call = (job.function, *arguments)
        try:
            if job.computes:
                timeout = SLOWER * limit
                future = self._pool.schedule(limited, args=(limit, *call), timeout=timeout)
            else:
                future = self._pool.schedule(guarded, args=call, timeout=limit)
        except RuntimeError:
            if self._pool.active:
                raise
            return None
        self._sizes[future] = sum(len(part) for part in arguments if isinstance(part, bytes))
        return future

    def _result(self, future: Any, job: Job) -> bytes | Failure | None:
        """The bytes of a job that has ended in a worker, or how it failed: hang, crash,
        exception; None if the pool broke before it had begun.
        """
        from pebble import ProcessExpired

        limit = job.patience * (job.timeout or self._timeout)
        try:
            result: bytes | Failure = future.result()
            return result
        except BrokenProcessPool:
            return None
        except FutureTimeout:
            if job.computes:
                limit *= SLOWER
            return Failure(
                kind="hang", sentence=f"it was still running after {limit:g} s and was killed"
            )
        except ProcessExpired as error:
            if job.computes and error.exitcode == -signal.SIGXCPU:
                return Failure(
                    kind="hang",
                    sentence=f"it had computed for {limit:g} s of CPU time and was killed",
                )
            return Failure(
                kind="crash", sentence=f"the worker process died with exit code {error.exitcode}"
            )
        except Exception as error:
            return _failure(error)


def take_back(running: dict[Any, Job]) -> Iterator[tuple[Job, Failure]]:
    """Cancels and yields the running jobs that are given up because of the latest results."""
    vain = [
        (future, failure)
        for future, job in running.items()
        if (failure := job.given_up()) is not None
    ]
    for future, failure in vain:
        future.cancel()
        yield running.pop(future), failure


def begin(parent: int, temporary: str) -> None:
    """Makes this worker process end when its parent ends in any way (Linux), and use the parent's
    folder of temporary files.

    Otherwise `tempfile` would test that folder by making a file in it, which stays if the worker is
    killed at that moment.
    """
    tempfile.tempdir = temporary
    # By now the pool has made this process ignore interrupts.
    unblock_interrupts()
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    # The parent may have ended before prctl was called.
    if os.getppid() != parent:
        os._exit(1)


def guarded(function: Callable[..., bytes], *arguments: Any) -> bytes | Failure:
    """The result of the function, or a Failure if it raised: not every exception can be sent from
    one process to another.
    """
    try:
        return function(*arguments)
    except Exception as error:
        return _failure(error)


def limited(limit: float, function: Callable[..., bytes], *arguments: Any) -> bytes | Failure:
    """The result of `function` within `limit` [s] of CPU time, rounded up to whole seconds; the
    system ends the process that needs more.
    """
    used = resource.getrusage(resource.RUSAGE_SELF)
    before, hard_limit = resource.getrlimit(resource.RLIMIT_CPU)
    # A process that is ended by this limit writes no core file.
    _, hard_core_limit = resource.getrlimit(resource.RLIMIT_CORE)
    resource.setrlimit(resource.RLIMIT_CORE, (0, hard_core_limit))
    end = math.ceil(used.ru_utime + used.ru_stime + limit)
    if hard_limit != resource.RLIM_INFINITY:
        end = min(end, hard_limit)
    resource.setrlimit(resource.RLIMIT_CPU, (end, hard_limit))
    try:
        return guarded(function, *arguments)
    finally:
        resource.setrlimit(resource.RLIMIT_CPU, (before, hard_limit))


def _failure(error: Exception) -> Failure:
    return Failure(kind="exception", sentence=one_line(f"{type(error).__name__}: {error}"))
