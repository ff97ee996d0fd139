"""The schedule: jobs to worker processes, results as they come; a crash or a hang costs its own job and no other."""

import multiprocessing
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

    `timeout` [s], if any, is its own; else the schedule's holds.
    """

    key: Any
    function: Callable[..., bytes]
    arguments: tuple[Any, ...]
    timeout: float | None = None


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
                call = (job.function, *job.arguments)
                running[self._pool.schedule(guarded, args=call, timeout=job.timeout or self._timeout)] = job
                if len(running) >= self._window:
                    break
            if not running:
                return
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                job = running.pop(future)
                yield job, self._result(future, job.timeout or self._timeout)

    def _result(self, future: Any, timeout: float) -> bytes | Failure:
        try:
            result: bytes | Failure = future.result()
            return result
        except FutureTimeout:
            return Failure(kind="hang", sentence=f"it was still running after {timeout:g} s and was killed")
        except ProcessExpired as error:
            return Failure(kind="crash", sentence=f"its process died with exit code {error.exitcode}")
        except Exception as error:
            return _failure(error)


def guarded(function: Callable[..., bytes], *arguments: Any) -> bytes | Failure:
    """What the function returns, or what it raised as a Failure: not every exception can travel between processes."""
    try:
        return function(*arguments)
    except Exception as error:
        return _failure(error)


def _failure(error: Exception) -> Failure:
    return Failure(kind="exception", sentence=f"{type(error).__name__}: {error}")
