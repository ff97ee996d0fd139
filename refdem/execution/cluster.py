"""The schedule of a cluster: runs to the workers of a Dask scheduler, results as they come.

Only this process reads and writes the store. Truths are proved here, in worker processes of this
machine. A worker that dies costs no run: what it had is made again by another one.
"""

import asyncio
import contextlib
import logging
import math
import queue
import time
import uuid
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from typing import Any

import msgspec

from refdem.core.outside import one_line
from refdem.core.run import Failure
from refdem.errors import ClusterError
from refdem.execution import remote, worker
from refdem.execution.schedule import Job, Schedule

CONNECT = 10.0
"""Seconds within which a scheduler must answer; on one network it does in milliseconds."""
ARRIVAL = 60.0
"""Seconds without any worker before a campaign gives up: a worker that its nanny starts again is
back within some.
"""
LOOK = 1.0
"""Seconds between questions to the scheduler for its workers."""
AHEAD = 2
"""Batches that each thread of a worker has at most: one that it runs, and one that waits there, so
that it never waits for the network.
"""
BATCH = 0.25
"""Seconds that the runs of a batch should take: passing it on takes some milliseconds."""
SCHEDULED = 2e-3
"""Seconds of a scheduler's time that one batch may take: it takes half of that, and is one process
for all workers, so that batches of many threads are longer.
"""
LONGER = 4.0
"""Times the seconds of a batch after which a worker begins no other run of it."""
MOST = 2048
"""Runs in a batch at most."""
LOST = (OSError, RuntimeError, CancelledError)
"""What Dask raises where the scheduler is gone: connections that close, clients that are closed,
questions that are given up.
"""
MOST_LOST = 10
"""Batches, one after the other, whose results were lost with their workers, after which a campaign
gives up: one that is lost is made again.
"""
MOST_BYTES = 2**20
"""Of the requests in a batch, unless one alone has more."""


class Cluster:
    """The workers of the scheduler at `address` ("tcp://host:port").

    `expected` is the state of the code that all workers must have (`remote.code_state`); `timeout`
    [s] is that of jobs without a limit of their own; `local` makes all jobs that are not runs.
    """

    def __init__(self, address: str, expected: bytes, timeout: float, local: Schedule) -> None:
        self._address = address
        self._expected = expected
        self._timeout = timeout
        self._local = local
        self._client: Any = None

    def __enter__(self) -> "Cluster":
        """Connects, and raises ClusterError unless workers are there and all of them are fit."""
        self._client = connected(self._address)
        try:
            with _noticed(self._address):
                self._wait_for_workers()
                self._refuse_misfits()
        except BaseException:
            self._client.close()
            raise
        self._local.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self._local.__exit__(*error)
        # Workers live on, and so would the programs that they keep alive. A scheduler that is lost
        # cannot pass this on: they end these by themselves after a while.
        if self._client.status == "running":
            with contextlib.suppress(*LOST):
                self._client.run(remote.rested, on_error="ignore")
        self._client.close()

    def results(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes | Failure]]:
        """Every job once with its bytes or its Failure, in the order in which they end.

        Raises ClusterError if the cluster is lost, or a worker that came later is not fit.
        """
        if any(job.function is not worker.run for job in jobs):
            return self._local.results(jobs)
        distribution = _Distribution(
            self._client, self._address, self._expected, self._timeout, jobs
        )
        return distribution.results()

    def _wait_for_workers(self) -> None:
        """Returns once there is a worker; raises ClusterError if none comes."""
        end = time.monotonic() + ARRIVAL
        while not self._client.nthreads():
            if time.monotonic() > end:
                raise ClusterError(
                    f"the scheduler at {self._address} has no workers after {ARRIVAL:g} s; expected"
                    f" at least one: start one with `dask worker {self._address}`"
                )
            time.sleep(LOOK)

    def _refuse_misfits(self) -> None:
        """Raises ClusterError with a line for each worker that would not run as this process
        does.
        """
        answers = self._client.run(remote.mismatch, self._expected, on_error="return")
        lines = []
        for address, answer in sorted(answers.items()):
            if isinstance(answer, OSError):
                # It has just died. Whatever comes in its place is asked with its first batch.
                continue
            if not isinstance(answer, str):
                reason = f"it did not report the version of its refdem ({answer}): install"
                " the same one there"
                lines.append(_line(address, reason))
            elif answer:
                lines.append(_line(address, answer))
        if lines:
            raise ClusterError("\n".join(lines))


class _Distribution:
    """The runs of some jobs, spread over the workers of a client."""

    def __init__(
        self, client: Any, address: str, expected: bytes, timeout: float, jobs: Sequence[Job]
    ) -> None:
        self._client = client
        self._address = address
        self._expected = expected
        self._timeout = timeout
        self._waiting = deque(jobs)
        self._running: dict[Any, list[Job]] = {}
        # Callbacks of the client, which has threads of its own, put the futures here that ended.
        self._ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._threads = 0
        self._looked = -math.inf
        self._peopled = time.monotonic()
        self._size = 1
        self._lost_in_a_row = 0

    def results(self) -> Iterator[tuple[Job, bytes | Failure]]:
        """Every job once, as `Cluster.results`."""
        try:
            while self._waiting or self._running:
                self._look()
                yield from self._submitted()
                if self._running:
                    yield from self._next_results()
        finally:
            # Without a scheduler there is nothing to cancel.
            with contextlib.suppress(*LOST):
                self._client.cancel(list(self._running))

    def _look(self) -> None:
        """Counts the threads of all workers now and then; raises ClusterError if none came back for
        ARRIVAL seconds.
        """
        now = time.monotonic()
        if now < self._looked + LOOK:
            return
        if self._client.status != "running":
            raise _gone(self._address)
        self._looked = now
        with _noticed(self._address):
            self._threads = sum(self._client.nthreads().values())
        if self._threads:
            self._peopled = now
        elif now > self._peopled + ARRIVAL:
            raise ClusterError(f"no worker has been connected for {ARRIVAL:g} s; {_KEPT}")

    def _submitted(self) -> Iterator[tuple[Job, Failure]]:
        """Hands batches to the scheduler until every thread has enough; what is not worth running
        any more comes back with its Failure.
        """
        while self._waiting and len(self._running) < AHEAD * max(1, self._threads):
            batch = list[Job]()
            room = MOST_BYTES
            for _ in range(self._batch_size()):
                if not self._waiting:
                    break
                job = self._waiting.popleft()
                failure = job.given_up()
                if failure is not None:
                    yield job, failure
                    continue
                job = job.ready()
                size = len(job.arguments[1])
                if batch and size > room:
                    self._waiting.appendleft(job)
                    break
                batch.append(job)
                room -= size
            if batch:
                self._submit(batch)

    def _batch_seconds(self) -> float:
        """Seconds that a batch should take."""
        return max(BATCH, SCHEDULED * self._threads)

    def _batch_size(self) -> int:
        """The number of runs in the next batch: fewer at the end, so that all threads end at about
        the same time.
        """
        share = len(self._waiting) // (AHEAD * max(1, self._threads))
        return max(1, min(self._size, share))

    def _submit(self, jobs: list[Job]) -> None:
        """Hands one batch to the scheduler."""
        now = time.monotonic()
        batch = remote.Batch(
            expected=self._expected,
            longest=LONGER * self._batch_seconds(),
            errands=[self._errand(job, now) for job in jobs],
        )
        # A key of its own, so that equal runs which are asked for again are made again.
        with _noticed(self._address):
            future = self._client.submit(
                remote.made, msgspec.msgpack.encode(batch), key=f"refdem-{uuid.uuid4().hex}"
            )
        self._running[future] = jobs
        future.add_done_callback(self._ended.put)

    def _errand(self, job: Job, now: float) -> remote.Errand:
        """A job as it travels: clocks of two machines differ, so what is left of its time does."""
        engine, request, deadline = job.arguments
        return remote.Errand(
            engine=engine,
            request=request,
            limit=job.patience * (job.timeout or self._timeout),
            seconds_left=deadline - now,
            computes=job.computes,
        )

    def _next_results(self) -> Iterator[tuple[Job, bytes | Failure]]:
        """The results of the batch that ends next, if one ends soon."""
        try:
            future = self._ended.get(timeout=LOOK)
        except queue.Empty:
            return
        jobs = self._running.pop(future)
        returned = self._returned(future, jobs)
        if returned is None:
            return
        if isinstance(returned, Failure):
            yield jobs[0], returned
            return
        done: list[tuple[Job, bytes | Failure]] = []
        not_begun = []
        for job, outcome in zip(jobs, returned.outcomes, strict=True):
            if outcome.failure is not None:
                done.append((job, outcome.failure))
            elif outcome.reply is not None:
                done.append((job, outcome.reply))
            else:
                not_begun.append(job)
        self._waiting.extendleft(reversed(not_begun))
        # So many runs take as long as a batch should, but at most twice as many as before.
        wanted = self._batch_seconds() * len(done) / max(returned.seconds, 1e-6)
        self._size = max(1, min(MOST, 2 * self._size, int(wanted)))
        yield from done

    def _returned(self, future: Any, jobs: list[Job]) -> remote.Returned | Failure | None:
        """What came back for a batch; None if its runs wait again, each in a batch of its own, and
        a Failure for a single run that took several workers with it.
        """
        from distributed import KilledWorker

        try:
            error, data = _outcome(future)
        except LOST:
            # The worker that held the result has died, or the scheduler, and `_look` says which.
            self._lost_in_a_row += 1
            if self._lost_in_a_row > MOST_LOST:
                raise _gone(self._address) from None
            self._wait_again(jobs)
            return None
        if isinstance(error, KilledWorker):
            if len(jobs) == 1:
                return Failure(kind="crash", sentence="each worker of the cluster that ran it died")
            self._wait_again(jobs)
            return None
        if error is not None:
            words = one_line(f"{type(error).__name__}: {error}")
            raise ClusterError(f"a worker failed outside of its runs: {words}; {_KEPT}")
        self._lost_in_a_row = 0
        returned = _read(data)
        if returned.mismatch:
            raise ClusterError(
                f"a worker that joined later: {one_line(returned.mismatch)}; {_KEPT}"
            )
        if len(returned.outcomes) != len(jobs):
            raise ClusterError(
                f"a worker returned {len(returned.outcomes)} outcomes; expected {len(jobs)}"
            )
        return returned

    def _wait_again(self, jobs: list[Job]) -> None:
        """Puts the runs of a batch back, each into a batch of its own."""
        self._size = 1
        self._waiting.extendleft(reversed(jobs))


_KEPT = "finished runs are in the store; run the same command again to continue"


def _gone(address: str) -> ClusterError:
    """The error that says that the scheduler was lost."""
    return ClusterError(
        f"the scheduler at {one_line(address)} does not respond any more; restart it, or omit"
        f" --scheduler; {_KEPT}"
    )


@contextlib.contextmanager
def _noticed(address: str) -> Iterator[None]:
    """Within this context an error of the connection to the scheduler says that it is gone."""
    try:
        yield
    except LOST as error:
        raise _gone(address) from error


def connected(address: str) -> Any:
    """A client of the scheduler at an address; raises ClusterError if none answers within CONNECT
    seconds, or if Dask is not installed.
    """
    try:
        import distributed
    except ImportError as error:
        raise ClusterError(
            f"a scheduler needs the package distributed ({error}); install it with"
            " `pip install 'refdem[distributed]'`"
        ) from error
    # Dask would log a lost scheduler with a traceback, and ClusterError says it in a sentence.
    for name in ("distributed", "distributed.client", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        # A client that does not come to be leaves threads behind, so one question goes first; from
        # a thread of its own, as that of a notebook has a loop that runs already.
        with ThreadPoolExecutor(max_workers=1) as apart:
            apart.submit(_ask, address).result()
        # Results are bytes: nothing else is read from a worker, and nothing of it unpickled.
        families = ["dask", "msgpack"]
        return distributed.Client(
            address,
            timeout=CONNECT,
            set_as_default=False,
            serializers=families,
            deserializers=families,
        )
    except Exception as error:
        # Whatever listens there may say anything, and Dask raises as it fails to read it.
        words = one_line(str(error)) or type(error).__name__
        raise ClusterError(
            f"no scheduler answers at {one_line(address)!r} ({words}); expected the address that"
            f" `dask scheduler` prints, as tcp://HOST:PORT, and an answer within {CONNECT:g} s"
        ) from error


def _ask(address: str) -> None:
    """Returns once a scheduler has answered; raises TimeoutError after CONNECT seconds."""
    asyncio.run(asyncio.wait_for(_identity(address), CONNECT))


async def _identity(address: str) -> None:
    """Returns once a scheduler has answered at the address; raises ValueError for another kind of
    server.
    """
    from distributed import rpc

    async with rpc(address, timeout=CONNECT) as server:
        identity = await server.identity()
    kind = identity.get("type")
    if kind != "Scheduler":
        raise ValueError(f"a {kind} is there")


def _outcome(future: Any) -> tuple[BaseException | None, object]:
    """The error of a batch that ended, or what it returned; raises one of LOST where that died with
    its worker, and ClusterError for what is more than data.
    """
    if future.status == "lost":
        # Asked now, Dask would wait until another worker has made it again.
        raise CancelledError
    error = future.exception(timeout=ARRIVAL)
    if error is not None:
        return error, None
    try:
        return None, future.result(timeout=ARRIVAL)
    except TypeError as error:
        raise ClusterError(f"a worker returned invalid data: {one_line(str(error))}") from error


def _read(data: object) -> remote.Returned:
    """What a worker returned; raises ClusterError for anything else."""
    if not isinstance(data, bytes):
        raise ClusterError(f"a worker returned {type(data).__name__}; expected bytes")
    try:
        return msgspec.msgpack.decode(data, type=remote.Returned)
    except ValueError as error:
        raise ClusterError(f"a worker returned bytes that are no results: {error}") from error


def _line(address: str, reason: str) -> str:
    """One printable line about a worker."""
    return one_line(f"worker {address}: {reason}")
