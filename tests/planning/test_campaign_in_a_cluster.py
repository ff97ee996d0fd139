"""Runs in the workers of a Dask cluster: the same bits as in processes of this machine, whoever
dies; and what a user is told of a cluster that is not there or not fit.
"""

import asyncio
import multiprocessing
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import CancelledError
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec
import pytest
from distributed import KilledWorker, LocalCluster

from refdem.core import discovery
from refdem.core.finding import Record
from refdem.core.problem import Request
from refdem.core.run import Failure
from refdem.core.store import Store
from refdem.engines.external import supervisor
from refdem.errors import ClusterError
from refdem.execution import cluster, remote, worker
from refdem.execution.cluster import Cluster, connected
from refdem.execution.schedule import InProcess, Job, Schedule
from refdem.planning.campaign import Campaign
from refdem.planning.specification import Entry, Specification

PLAYED = "tcp://played:1"
"""The address of the player below."""
LIMIT = 600.0
"""[s], a time limit that no busy machine reaches."""


@pytest.fixture(scope="module")
def two_workers(played: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[LocalCluster]:
    """A cluster of two processes, each with the engine that misbehaves."""
    folder = tmp_path_factory.mktemp("workers")
    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        # Any port that is free: a second cluster on this machine would warn of the usual one.
        dashboard_address=":0",
        memory_limit=None,
        local_directory=str(folder),
    ) as local_cluster:
        yield local_cluster


class Recording(Store):
    """A store that remembers the trajectories that it was given, by the keys of their runs."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.trajectories: dict[str, bytes] = {}

    def put(self, kind: str, key: str, data: bytes) -> None:
        """Keeps it as every store does."""
        super().put(kind, key, data)
        if kind == "run":
            self.trajectories[key] = msgspec.msgpack.decode(data, type=worker.Reply).trajectory


def campaign(store: Store, **more: Any) -> list[object]:
    """The records of a campaign to the last bit, without the seconds that anything took."""
    specification = Specification(
        name="test",
        case=[Entry("harmonic-oscillator")],
        engines=["reference"],
        checks=["error", "order", "determinism"],
        levels=4,
        timeout=LIMIT,
    )
    sheets = Campaign(specification, store, jobs=1, **more).sheets()
    records = [sheet for sheet in sheets if isinstance(sheet, Record)]
    return [untimed(msgspec.to_builtins(record)) for record in records]


def untimed(value: Any) -> Any:
    """A document without what it says of seconds; floats as text, where NaN equals NaN."""
    if isinstance(value, dict):
        return {key: untimed(item) for key, item in value.items() if key != "seconds"}
    if isinstance(value, list | tuple):
        return [untimed(item) for item in value]
    return repr(value)


def test_records_are_those_of_one_process_though_a_worker_is_killed(
    two_workers: LocalCluster, tmp_path: Path
) -> None:
    killed = []

    def progress(stage: str, done: int, total: int) -> None:
        if stage == "runs" and done == 4 and not killed:
            assert total > 20
            pid = two_workers.workers[0].process.pid
            os.kill(pid, signal.SIGKILL)
            killed.append(pid)

    here = Recording(tmp_path / "here")
    there = Recording(tmp_path / "there")
    records_here = campaign(here)
    records_there = campaign(there, progress=progress, scheduler=two_workers.scheduler_address)
    assert killed
    assert records_there == records_here
    assert there.trajectories == here.trajectories
    assert len(here.trajectories) > 20
    assert started_by_workers(two_workers) == []


def started_by_workers(local_cluster: LocalCluster) -> list[int]:
    """The processes below all workers, apart from the resource trackers of Python."""
    client = connected(local_cluster.scheduler_address)
    try:
        below = client.run(lambda: supervisor.descendants())
    finally:
        client.close()
    processes = [process for of_worker in below.values() for process in of_worker]
    commands = {process: Path(f"/proc/{process}/cmdline").read_bytes() for process in processes}
    return [process for process, command in commands.items() if b"tracker;main" not in command]


def test_a_worker_that_gets_no_batch_any_more_ends_what_it_has_started(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(remote, "IDLE", 0.0)
    before = set(multiprocessing.active_children())
    processes = remote._Processes()
    job = Job(0, worker.run, ("reference", request(), float("inf")), computes=True)
    for _ in range(2):
        ((_, result),) = processes.results([job])
        assert isinstance(result, bytes)
        processes._idle.join()
        assert set(multiprocessing.active_children()) == before


def test_what_is_busy_is_not_ended() -> None:
    processes = remote._Processes()
    job = Job(0, worker.run, ("reference", request(), float("inf")), computes=True)
    results = processes.results([job, job])
    next(results)
    processes.rest()
    assert isinstance(next(results)[1], bytes)
    assert list(results) == []
    processes.rest()


def test_an_engine_that_crashes_in_a_cluster_costs_its_own_run(two_workers: LocalCluster) -> None:
    jobs = [
        Job(name, worker.run, ("played", request(name), float("inf")), computes=True)
        for name in ("good", "crash", "refuses")
    ]
    with Schedule(1, LIMIT) as here:
        expected = {job.key: result for job, result in here.results(jobs)}
    code = remote.code_state([discovery.engine("played")])
    with Cluster(two_workers.scheduler_address, code, LIMIT, Schedule(1, LIMIT)) as there:
        found = {job.key: result for job, result in there.results(jobs)}
    assert found == expected
    # It is the worker that says so: it went on.
    assert found["crash"] == Failure(
        kind="crash", sentence="the worker process died with exit code 7"
    )


def request(method: str = "velocity-verlet") -> bytes:
    """A packed request for a few steps."""
    problem = discovery.case("harmonic-oscillator").at(samples="2").problem
    return Request(problem=problem, method=method, step=problem.interval / 4).packed()


def state(**changed: Any) -> bytes:
    """The state of the code of this process, with some fields of it changed."""
    own = msgspec.msgpack.decode(
        remote.code_state([discovery.engine("reference")]), type=remote.CodeState
    )
    return msgspec.msgpack.encode(msgspec.structs.replace(own, **changed))


@pytest.mark.parametrize(
    ("expected", "words"),
    [
        (state(), ""),
        (
            state(refdem="0" * 64),
            "expected 000000000000, that of the refdem that started the campaign",
        ),
        (state(machine="0" * 64), "its processor has other features"),
        (
            state(methods=[remote.MethodState("no-such", "leapfrog", "")]),
            "engine no-such cannot be read there",
        ),
        (
            state(methods=[remote.MethodState("/nowhere/refdem.toml", "leapfrog", "")]),
            "engine /nowhere/refdem.toml cannot be read there",
        ),
        (
            state(methods=[remote.MethodState("reference", "velocity-verlet", "0" * 64)]),
            "method velocity-verlet of engine reference has the fingerprint",
        ),
    ],
)
def test_a_worker_says_why_it_is_not_fit(expected: bytes, words: str) -> None:
    reason = remote.mismatch(expected)
    assert words in reason
    assert bool(words) == bool(reason)
    batch = remote.Batch(expected=expected, longest=1.0, errands=[])
    assert returned_for(batch).mismatch == reason


def returned_for(batch: remote.Batch) -> remote.Returned:
    """What a worker makes of a batch."""
    data = remote.made(msgspec.msgpack.encode(batch))
    return msgspec.msgpack.decode(data, type=remote.Returned)


def test_a_batch_that_takes_too_long_comes_back_one_run_shorter_at_least(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(remote, "_schedule", InProcess)
    errand = remote.Errand(
        engine="reference",
        request=request(),
        limit=LIMIT,
        seconds_left=float("inf"),
        computes=True,
    )
    batch = remote.Batch(expected=state(), longest=0.0, errands=[errand] * 3)
    first, *others = returned_for(batch).outcomes
    assert first.reply is not None
    assert others == [remote.Outcome(), remote.Outcome()]
    for begun in returned_for(msgspec.structs.replace(batch, longest=LIMIT)).outcomes:
        assert begun.reply is not None


def test_an_engine_that_a_worker_lacks_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    expected = state(machine=remote.fingerprint.of_machine())
    engine = discovery.engine("reference")
    monkeypatch.setattr(type(engine), "missing", lambda self: "pip install it")
    remote.mismatch.cache_clear()
    assert remote.mismatch(expected) == "engine reference is not installed there: pip install it"
    remote.mismatch.cache_clear()


def test_workers_that_are_not_fit_are_said_before_the_first_run(two_workers: LocalCluster) -> None:
    there = Cluster(
        two_workers.scheduler_address, state(refdem="0" * 64), LIMIT, Schedule(1, LIMIT)
    )
    with pytest.raises(ClusterError) as raised, there:
        pass
    # The worker that was killed above may not be back yet.
    lines = str(raised.value).splitlines()
    assert len(lines) in (1, 2)
    for line in lines:
        assert line.startswith("worker tcp://")
        assert "expected 000000000000" in line


@pytest.mark.parametrize("kind", ["closed", "mute", "worker", "nonsense"])
def test_an_address_where_no_scheduler_answers_is_said_in_bounded_time(
    kind: str, two_workers: LocalCluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        if kind == "closed":
            server.close()
        if kind in ("closed", "mute"):
            monkeypatch.setattr(cluster, "CONNECT", 0.2)
        worker_address = next(iter(two_workers.scheduler_info["workers"]))
        address = {"worker": worker_address, "nonsense": "here"}.get(
            kind, f"tcp://127.0.0.1:{port}"
        )
        with pytest.raises(ClusterError, match=f"no scheduler answers at '{address}'"):
            connected(address)


def test_a_scheduler_is_asked_for_where_a_loop_runs_already_as_in_a_notebook(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cluster, "CONNECT", 0.2)

    async def cell() -> None:
        connected("nowhere")

    with pytest.raises(ClusterError, match="no scheduler answers at 'nowhere'") as caught:
        asyncio.run(cell())
    assert "event loop" not in str(caught.value)


def test_without_dask_a_user_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ClusterError, match=r"pip install 'refdem\[distributed\]'"):
        connected("tcp://127.0.0.1:1")


@dataclass
class Answered:
    """A future of the player below, as Dask's are used."""

    answer: object
    status: str = "finished"

    def exception(self, timeout: float) -> BaseException | None:
        """The error of the task, if it failed."""
        return self.answer if isinstance(self.answer, BaseException) else None

    def result(self, timeout: float) -> object:
        """What the task returned, unless it was cancelled."""
        if self.status == "cancelled":
            raise CancelledError
        return self.answer

    def add_done_callback(self, callback: Any) -> None:
        """It is done at once."""
        callback(self)

    def __hash__(self) -> int:
        return id(self)


@dataclass
class Player:
    """A client whose workers do with each batch what `play` says."""

    play: Any
    sizes: list[int] = field(default_factory=list)
    status: str = "running"

    def nthreads(self) -> dict[str, int]:
        """One worker with one thread."""
        return {PLAYED: 1}

    def submit(self, function: object, data: bytes, key: str) -> Answered:
        """The future of a batch."""
        errands = msgspec.msgpack.decode(data, type=remote.Batch).errands
        self.sizes.append(len(errands))
        answer = self.play(errands)
        if isinstance(answer, str):
            return Answered(None, status=answer)
        return Answered(answer)

    def cancel(self, futures: list[Answered]) -> None:
        """Nothing is left to cancel."""


def played_results(player: Player, jobs: int) -> dict[int, bytes | Failure]:
    """The results of so many jobs, whose engines are numbered."""
    asked = [
        Job(number, worker.run, (str(number), request(), float("inf"))) for number in range(jobs)
    ]
    distribution = cluster._Distribution(player, PLAYED, b"", LIMIT, asked)
    results = list(distribution.results())
    assert len(results) == jobs
    return {job.key: result for job, result in results}


def all_made(errands: list[remote.Errand]) -> bytes:
    """Each run of a batch returns the name of its engine."""
    outcomes = [remote.Outcome(reply=errand.engine.encode()) for errand in errands]
    return msgspec.msgpack.encode(remote.Returned(outcomes=outcomes, seconds=0.0))


def test_short_runs_travel_in_batches() -> None:
    player = Player(all_made)
    results = played_results(player, 400)
    assert results == {number: str(number).encode() for number in range(400)}
    assert max(player.sizes) > 20
    assert len(player.sizes) < 100


def test_a_run_that_takes_its_workers_with_it_costs_no_other() -> None:
    def play(errands: list[remote.Errand]) -> object:
        if "37" in [errand.engine for errand in errands]:
            return KilledWorker("refdem", None, 3)
        return all_made(errands)

    results = played_results(Player(play), 100)
    failure = results.pop(37)
    assert isinstance(failure, Failure)
    assert failure.kind == "crash"
    assert results == {number: str(number).encode() for number in range(100) if number != 37}


def test_runs_that_a_worker_did_not_begin_are_made_once() -> None:
    def play(errands: list[remote.Errand]) -> bytes:
        outcomes = [remote.Outcome() for _ in errands]
        outcomes[0] = remote.Outcome(reply=errands[0].engine.encode())
        return msgspec.msgpack.encode(remote.Returned(outcomes=outcomes, seconds=0.0))

    results = played_results(Player(play), 30)
    assert results == {number: str(number).encode() for number in range(30)}


@pytest.mark.parametrize("status", ["lost", "cancelled"])
def test_results_that_are_lost_with_their_worker_are_made_again(status: str) -> None:
    batches = []

    def play(errands: list[remote.Errand]) -> object:
        batches.append(len(errands))
        # Each third batch, so that none is lost too often.
        return status if len(batches) % 3 == 0 else all_made(errands)

    results = played_results(Player(play), 100)
    assert results == {number: str(number).encode() for number in range(100)}
    assert sum(batches) > 100


def test_what_hung_before_is_not_sent() -> None:
    failure = Failure(kind="hang", sentence="it was not started", is_begun=False)
    arguments = ("reference", request(), float("inf"))
    job = Job(0, worker.run, arguments, given_up=lambda: failure)
    player = Player(all_made)
    assert list(cluster._Distribution(player, PLAYED, b"", LIMIT, [job]).results()) == [
        (job, failure)
    ]
    assert player.sizes == []


def returned(outcomes: int, mismatch: str = "") -> bytes:
    """What a worker says, with so many outcomes."""
    document = remote.Returned(
        outcomes=[remote.Outcome(reply=b"")] * outcomes, seconds=0.0, mismatch=mismatch
    )
    return msgspec.msgpack.encode(document)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ("cancelled", "the scheduler at tcp://played:1 does not respond any more; restart it"),
        ("lost", "the scheduler at tcp://played:1 does not respond any more; restart it"),
        (ValueError("worn\nout"), "a worker failed outside of its runs: ValueError: worn"),
        (returned(0), "0 outcomes; expected 1"),
        (returned(2), "2 outcomes; expected 1"),
        (returned(0, mismatch="another refdem"), "a worker that joined later: another refdem"),
        (b"", "bytes that are no results"),
        (b"\x93\x01\x02", "bytes that are no results"),
        (["a", "list"], "list; expected bytes"),
    ],
)
def test_what_comes_back_is_checked(answer: object, words: str) -> None:
    with pytest.raises(ClusterError, match=words):
        played_results(Player(lambda errands: answer), 1)


def test_a_scheduler_that_is_gone_is_noticed() -> None:
    with pytest.raises(ClusterError, match="run the same command again to continue"):
        played_results(Player(all_made, status="closed"), 1)


def test_a_connection_that_closes_says_that_the_scheduler_is_gone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def closed() -> None:
        raise OSError("in <TCP>: Stream is closed")

    player = Player(all_made)
    monkeypatch.setattr(player, "nthreads", closed)
    with pytest.raises(
        ClusterError, match="the scheduler at tcp://played:1 does not respond any more"
    ):
        played_results(player, 1)


KILLED = """
import subprocess, sys, time
from refdem.execution import cluster, worker
from refdem.execution.schedule import Job
from refdem.errors import ClusterError

options = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show"]
command = [sys.executable, "-m", "distributed.cli.dask_scheduler", *options]
scheduler = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
lines = (line for line in scheduler.stderr if "Scheduler at:" in line)
address = next(lines).split()[-1]
client = cluster.connected(address)
job = Job(0, worker.run, ("reference", b"", float("inf")))
scheduler.kill()
while client.status == "running":
    time.sleep(0.01)
try:
    list(cluster._Distribution(client, address, b"", 600.0, [job]).results())
except ClusterError as error:
    print(error)
client.close()
"""


def test_a_scheduler_that_is_killed_is_one_sentence_and_no_traceback() -> None:
    done = subprocess.run(
        [sys.executable, "-c", KILLED], capture_output=True, text=True, check=True, timeout=LIMIT
    )
    (line,) = done.stdout.splitlines()
    assert line.startswith("the scheduler at tcp://127.0.0.1:")
    assert line.endswith("are in the store; run the same command again to continue")
    assert "Traceback" not in done.stderr


def test_a_campaign_whose_workers_never_come_back_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    player = Player(all_made)
    monkeypatch.setattr(player, "nthreads", dict)
    monkeypatch.setattr(cluster, "ARRIVAL", -1.0)
    with pytest.raises(ClusterError, match="no worker has been connected"):
        played_results(player, 1)


def test_jobs_that_are_not_runs_stay_here() -> None:
    class Local:
        def results(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes]]:
            return iter([(job, b"here") for job in jobs])

    there = Cluster("tcp://nowhere:1", b"", LIMIT, Local())  # type: ignore[arg-type]
    job = Job(0, worker.sampled_truth, ("harmonic-oscillator", {}))
    assert list(there.results([job])) == [(job, b"here")]


def test_a_campaign_in_one_place_does_not_import_dask() -> None:
    code = "import refdem.planning.campaign, sys; sys.exit('distributed' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
