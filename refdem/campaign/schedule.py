"""The schedule: jobs to worker processes, results as they come; a crash or a hang costs its own job and no other."""

import math
import multiprocessing
import resource
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, wait
from concurrent.futures import TimeoutError as FutureTimeout
from dataclasses import dataclass
from typing import Any

from pebble import ProcessExpired, ProcessPool

from refdem.core.run import Failure


@dataclass(frozen=True)
class Job:
    """A function of a module and its arguments, all of them bytes, text or plain containers; `key` comes back with the result.

    `timeout` [s], if any, is its own; else the schedule's holds. Of what only `computes` CPU time counts and not the clock, so that
    it ends on a busy machine as it does on a quiet one.
    """

    key: Any
    function: Callable[..., bytes]
    arguments: tuple[Any, ...]
    timeout: float | None = None
    computes: bool = False


class InProcess:
    """The same in this process, for engines that live here; a hang or a crash is the caller's own."""

    def __enter__(self) -> "InProcess":
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def results(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes | Failure]]:
        """Every job once with its bytes, in order."""
        for job in jobs:
            yield job, job.function(*job.arguments)


class Schedule:
    """Worker processes (spawned, so that no state is shared); a job that takes longer than `timeout` [s] is killed."""

    def __init__(self, workers: int, timeout: float) -> None:
        self._pool = ProcessPool(max_workers=workers, context=multiprocessing.get_context("spawn"))
        self._timeout = timeout
        self._window = 4 * workers

    def __enter__(self) -> "Schedule":
        return self

    def __exit__(self, *error: object) -> None:
        self._pool.stop()  # type: ignore[no-untyped-call]
        self._pool.join()

    def results(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes | Failure]]:
        """Every job once with its bytes or its Failure, in the order in which they end."""
        waiting, running = iter(jobs), dict[Any, Job]()
        while True:
            for job in waiting:
                running[self._begun(job)] = job
                if len(running) >= self._window:
                    break
            if not running:
                return
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                job = running.pop(future)
                yield job, self._result(future, job)

    def _begun(self, job: Job) -> Any:
        """The future of a job."""
        limit = job.timeout or self._timeout
        if job.computes:
            return self._pool.schedule(limited, args=(limit, job.function, *job.arguments))
        return self._pool.schedule(guarded, args=(job.function, *job.arguments), timeout=limit)

    def _result(self, future: Any, job: Job) -> bytes | Failure:
        limit = job.timeout or self._timeout
        try:
            result: bytes | Failure = future.result()
            return result
        except FutureTimeout:
            return Failure(kind="hang", sentence=f"it was still running after {limit:g} s and was killed")
        except ProcessExpired as error:
            if job.computes and error.exitcode == -signal.SIGXCPU:
                return Failure(kind="hang", sentence=f"it had computed for {limit:g} s of CPU time and was killed")
            return Failure(kind="crash", sentence=f"its process died with exit code {error.exitcode}")
        except Exception as error:
            return _failure(error)


def guarded(function: Callable[..., bytes], *arguments: Any) -> bytes | Failure:
    """What the function returns, or what it raised as a Failure: not every exception can travel between processes."""
    try:
        return function(*arguments)
    except Exception as error:
        return _failure(error)


def limited(limit: float, function: Callable[..., bytes], *arguments: Any) -> bytes | Failure:
    """The same within `limit` [s] of CPU time, rounded up; beyond it the system ends the process, whatever it is in the middle of."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    before, most = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
    end = math.ceil(used.ru_utime + used.ru_stime + limit)
    resource.setrlimit(resource.RLIMIT_CPU, (end if most == resource.RLIM_INFINITY else min(end, most), most))
    try:
        return guarded(function, *arguments)
    finally:
        resource.setrlimit(resource.RLIMIT_CPU, (before, most))


def _failure(error: Exception) -> Failure:
    return Failure(kind="exception", sentence=f"{type(error).__name__}: {error}")
