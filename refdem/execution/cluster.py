"""The schedule of a cluster: runs are sent to the workers of a Dask scheduler, and results are
returned as they end.

Only this process reads and writes the store. Truths are proved in worker processes of this machine.
If a worker dies, its runs are repeated by another one.
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
"""Seconds without any worker before a campaign gives up. A worker that its nanny restarts is back
within a few seconds.
"""
LOOK = 1.0
"""Seconds between queries of the scheduler for its workers."""
AHEAD = 2
"""Most batches of each thread of a worker: one that it runs, and one in reserve, so that it never
waits for the network.
"""
BATCH = 0.25
"""Intended duration [s] of a batch; its transfer takes a few milliseconds."""
SCHEDULED = 2e-3
"""Scheduler time [s] allowed for one batch, twice what it takes. The scheduler is one process for
all workers, so that batches are longer the more threads there are.
"""
LONGER = 4.0
"""Factor on the intended duration of a batch, after which a worker starts no further run of it."""
MOST = 2048
"""Largest number of runs in a batch."""
LOST = (OSError, RuntimeError, CancelledError)
"""Exceptions of Dask for a lost scheduler: closed connections, closed clients, and cancelled
queries.
"""
MOST_LOST = 10
"""Number of consecutive batches lost with their workers after which a campaign gives up; until then
a lost batch is repeated.
"""
MOST_BYTES = 2**20
"""Most bytes of the requests in a batch, unless a single one has more."""


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
        """Connects; raises ClusterError unless there are workers and all have the expected code."""
        self._client = connected(self._address)
        try:
            with _reporting_loss(self._address):
                self._wait_for_workers()
                self._refuse_misfits()
        except BaseException:
            self._client.close()
            raise
        self._local.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self._local.__exit__(*error)
        # Workers continue to run, and so would the programs that they keep alive. If the scheduler
        # is lost, this request cannot reach them, and they end these programs after a timeout.
        if self._client.status == "running":
            with contextlib.suppress(*LOST):
                self._client.run(remote.rested, on_error="ignore")
        self._client.close()

    def results(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes | Failure]]:
        """Every job once with its bytes or its Failure, in the order in which they end.

        Raises ClusterError if the cluster is lost, or if a worker that joined later has other code.
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
                # It has just died. Its replacement is checked with its first batch.
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
        # Callbacks in the client's own threads put finished futures here.
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
            # If the scheduler is lost, there is nothing to cancel.
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
        with _reporting_loss(self._address):
            self._threads = sum(self._client.nthreads().values())
        if self._threads:
            self._peopled = now
        elif now > self._peopled + ARRIVAL:
            raise ClusterError(f"no worker has been connected for {ARRIVAL:g} s; {_KEPT}")

    def _submitted(self) -> Iterator[tuple[Job, Failure]]:
        """Submits batches to the scheduler until every thread has enough.

        Jobs that are given up before they are submitted are yielded with their Failure.
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
        # Each batch has a unique key: Dask would return the old result for an equal key.
        with _reporting_loss(self._address):
            future = self._client.submit(
                remote.made, msgspec.msgpack.encode(batch), key=f"refdem-{uuid.uuid4().hex}"
            )
        self._running[future] = jobs
        future.add_done_callback(self._ended.put)

    def _errand(self, job: Job, now: float) -> remote.Errand:
        """A job as it is sent. As the clocks of two machines differ, it has remaining times instead
        of deadlines.
        """
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
        # The number of runs that take the intended duration, at most twice the previous number.
        wanted = self._batch_seconds() * len(done) / max(returned.seconds, 1e-6)
        self._size = max(1, min(MOST, 2 * self._size, int(wanted)))
        yield from done

    def _returned(self, future: Any, jobs: list[Job]) -> remote.Returned | Failure | None:
        """The result of a batch; a Failure for a single run during which several workers died.

        It is None if the runs are queued again, each in a batch of its own.
        """
        from distributed import KilledWorker

        try:
            error, data = _outcome(future)
        except LOST:
            # The worker with the result, or the scheduler, has died; `_look` finds out which.
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
    """The error that is raised if the scheduler is lost."""
    return ClusterError(
        f"the scheduler at {one_line(address)} does not respond any more; restart it, or omit"
        f" --scheduler; {_KEPT}"
    )


@contextlib.contextmanager
def _reporting_loss(address: str) -> Iterator[None]:
    """Within this context an error of the connection is raised as a lost scheduler."""
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
    # Dask would log a lost scheduler with a traceback; ClusterError reports it in a sentence.
    for name in ("distributed", "distributed.client", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        # A client that fails to connect leaves threads behind, so the scheduler is queried first.
        # The query has its own thread, because a notebook's thread already runs an event loop.
        with ThreadPoolExecutor(max_workers=1) as apart:
            apart.submit(_ask, address).result()
        # Results are bytes: nothing else is accepted from a worker, and nothing is unpickled.
        families = ["dask", "msgpack"]
        return distributed.Client(
            address,
            timeout=CONNECT,
            set_as_default=False,
            serializers=families,
            deserializers=families,
        )
    except Exception as error:
        # Any other server may listen at the address; Dask raises when it cannot parse the reply.
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
    """The error of a batch that ended, or its result.

    Raises one of LOST if the result was lost with its worker, and ClusterError for a result that is
    more than data.
    """
    if future.status == "lost":
        # Reading the result would now wait until another worker has recomputed it.
        raise CancelledError
    error = future.exception(timeout=ARRIVAL)
    if error is not None:
        return error, None
    try:
        return None, future.result(timeout=ARRIVAL)
    except TypeError as error:
        raise ClusterError(f"a worker returned invalid data: {one_line(str(error))}") from error


def _read(data: object) -> remote.Returned:
    """The decoded result of a worker; raises ClusterError for bytes that are none."""
    if not isinstance(data, bytes):
        raise ClusterError(f"a worker returned {type(data).__name__}; expected bytes")
    try:
        return msgspec.msgpack.decode(data, type=remote.Returned)
    except ValueError as error:
        raise ClusterError(f"a worker returned bytes that are no results: {error}") from error


def _line(address: str, reason: str) -> str:
    """One printable line about a worker."""
    return one_line(f"worker {address}: {reason}")
