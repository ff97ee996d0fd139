"""Jobs in worker processes: what a job raises costs that job alone, and a busy machine ends none
that only computes.
"""

import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

import pytest
from pebble.pool import process as pool_process

from refdem.core import discovery
from refdem.core.engine import Stages
from refdem.core.run import Failure
from refdem.engines.external.process import Limits, ended
from refdem.execution.schedule import NEVER_BEGUN, POOLS, READ_HERE, InProcess, Job, Schedule, begin
from refdem.execution.worker import COUNT_BYTES
from refdem.planning.truths import sampled_truths


class LocalError(ValueError):
    """An exception that cannot be made again from what it was given first: pickling it breaks a
    pool.
    """

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code


def works() -> bytes:
    return b"done"


def raises() -> bytes:
    raise LocalError("singular", "no analytic point")


def echoes(data: bytes) -> bytes:
    """What it is given."""
    return data


def echoes_in_stages(data: bytes) -> Stages[bytes]:
    """What it is given, at once."""
    yield from ()
    return data


@pytest.mark.parametrize("place", ["here", "programs", "workers"])
def test_arguments_are_packed_only_when_their_job_begins(
    place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    packed = list[int]()

    def job(number: int) -> Job:
        """A job that notes when its arguments are packed."""

        def pack() -> tuple[bytes]:
            """The only argument: the number as bytes."""
            packed.append(number)
            return (bytes([number]),)

        stages = echoes_in_stages if place == "programs" else None
        return Job(number, echoes, stages=stages, pack=pack)

    ahead = 0
    with InProcess() if place == "here" else Schedule(1, 60) as scheduler:
        for done, (one, result) in enumerate(scheduler.results([job(k) for k in range(20)])):
            assert result == bytes([one.key])
            ahead = max(ahead, len(packed) - done)
    assert sorted(packed) == list(range(20))
    assert ahead < 10


def test_one_job_with_large_arguments_waits_for_a_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    monkeypatch.setattr("refdem.execution.schedule.MOST_WAITING", 100)
    packed = list[int]()

    def job(number: int) -> Job:
        """A job that notes when its arguments, of 80 bytes, are packed."""

        def pack() -> tuple[bytes]:
            """The only argument."""
            packed.append(number)
            return (bytes(80),)

        return Job(number, echoes, pack=pack)

    ahead = 0
    with Schedule(1, 60) as scheduler:
        for done, (_, result) in enumerate(scheduler.results([job(k) for k in range(8)])):
            assert result == bytes(80)
            ahead = max(ahead, len(packed) - done)
    assert sorted(packed) == list(range(8))
    assert ahead == 2


def test_an_exception_that_cannot_travel_costs_its_own_job(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2])  # workers import this module by its name
    jobs = [Job(0, raises, ()), Job(1, works, ()), Job(2, raises, ())]
    with Schedule(1, 60) as schedule:
        found = {job.key: result for job, result in schedule.results(jobs)}
    assert found[1] == b"done"
    assert (
        found[0] == found[2] == Failure(kind="exception", sentence="LocalError: no analytic point")
    )


def folder_of_temporary_files() -> bytes:
    """The one that `tempfile` knows already."""
    return str(tempfile.tempdir).encode()


def test_a_worker_does_not_look_for_the_folder_of_temporary_files(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # tempfile looks by making a file, and a worker that is killed just then leaves it.
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    with Schedule(1, 60) as schedule:
        ((_, found),) = schedule.results([Job(0, folder_of_temporary_files, ())])
    assert found == tempfile.gettempdir().encode()


def dies(parent: int, temporary: str) -> None:
    """In place of `begin`: ends a worker that starts, as often as there is a file left."""
    for file in sorted(Path(os.environ["DEATHS"]).iterdir()):
        with suppress(FileNotFoundError):
            file.unlink()
            os.kill(os.getpid(), signal.SIGKILL)
    begin(parent, temporary)


@pytest.mark.parametrize("deaths", [1, 2])
def test_a_pool_that_breaks_while_a_worker_starts_is_made_again(
    deaths: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    found = results_with_deaths(deaths, monkeypatch, tmp_path)
    assert found == dict.fromkeys(range(6), b"done")


def test_jobs_whose_workers_never_start_fail_and_the_others_go_on(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    found = results_with_deaths(POOLS, monkeypatch, tmp_path)
    failed = [result for result in found.values() if result != b"done"]
    assert sorted(found) == list(range(6))
    # One worker holds four jobs.
    assert failed == [Failure(kind="crash", sentence=NEVER_BEGUN)] * 4


def results_with_deaths(
    deaths: int, monkeypatch: pytest.MonkeyPatch, folder: Path
) -> "dict[int, bytes | Failure]":
    """Results of six jobs where the first `deaths` workers die while they start."""
    for k in range(deaths):
        (folder / str(k)).touch()
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    monkeypatch.setenv("DEATHS", str(folder))
    monkeypatch.setattr("refdem.execution.schedule.begin", dies)
    with Schedule(1, 60) as schedule:
        return {
            job.key: result
            for job, result in schedule.results([Job(k, works, ()) for k in range(6)])
        }


def loses(parent: int, temporary: str) -> None:
    """In place of `begin`: a worker that takes a job while another one runs dies of it, once."""
    begin(parent, temporary)
    taken = pool_process.task_transaction

    def lost(channel: pool_process.WorkerChannel) -> object:
        if not Path(os.environ["BEGUN"]).exists():
            return taken(channel)
        with suppress(FileNotFoundError):
            Path(os.environ["DEATH"]).unlink()
            with channel.lock():
                channel.recv()
                os.kill(os.getpid(), signal.SIGKILL)
        return taken(channel)

    pool_process.task_transaction = lost


def runs_meanwhile() -> bytes:
    """Runs until the worker that died has been replaced by another one, which works."""
    folder = Path(os.environ["BEGUN"]).parent
    (folder / "begun").touch()
    wait_for(folder / "another")
    return b"done"


def comes_next() -> bytes:
    """Runs when the other job does, and tells it whether the worker has died."""
    folder = Path(os.environ["BEGUN"]).parent
    wait_for(folder / "begun")
    if not (folder / "death").exists():
        (folder / "another").touch()
    return b"done"


def wait_for(path: Path) -> None:
    """Waits until a file is there."""
    until = time.monotonic() + 120
    while not path.exists() and time.monotonic() < until:
        time.sleep(0.01)


def results_with_one_death(
    begins: Callable[[int, str], None],
    jobs: list[Job],
    monkeypatch: pytest.MonkeyPatch,
    folder: Path,
) -> "dict[int, bytes | Failure]":
    """Results of jobs in two workers, of which one dies, as what it `begins` with has it."""
    death = folder / "death"
    death.touch()
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    monkeypatch.setenv("DEATH", str(death))
    monkeypatch.setattr("refdem.execution.schedule.begin", begins)
    with Schedule(2, 300) as schedule:
        found = {job.key: result for job, result in schedule.results(jobs)}
    assert not death.exists()
    return found


def test_a_job_whose_worker_is_killed_as_it_takes_it_is_handed_over_again(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("BEGUN", str(tmp_path / "begun"))
    monkeypatch.setattr("refdem.execution.schedule.UNTAKEN", 2.0)
    jobs = [Job(0, runs_meanwhile, ()), *(Job(k, comes_next, ()) for k in range(1, 6))]
    found = results_with_one_death(loses, jobs, monkeypatch, tmp_path)
    assert found == dict.fromkeys(range(6), b"done")


def waits(seconds: float) -> bytes:
    time.sleep(seconds)
    return b"done"


def computes_for_ever() -> bytes:
    while True:
        pass


def test_of_what_only_computes_the_clock_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that a busy machine does not run looks from outside like one that waits."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    # However busy this machine is, a second of computing does not take a hundred seconds.
    monkeypatch.setattr("refdem.execution.schedule.SLOWER", 100.0)
    jobs = [
        Job(0, waits, (1.5,), 1, computes=True),
        Job(1, waits, (30.0,), 1),
        Job(2, computes_for_ever, (), 1, computes=True),
        Job(4, waits, (60.0,), 0.01, computes=True),
    ]
    with Schedule(3, 60) as schedule:
        found = {job.key: result for job, result in schedule.results([*jobs, Job(3, works, ())])}
    assert found[0] == found[3] == b"done"
    assert found[1] == Failure(
        kind="hang", sentence="it was still running after 1 s and was killed"
    )
    assert found[2] == Failure(
        kind="hang", sentence="it had computed for 1 s of CPU time and was killed"
    )
    assert found[4] == Failure(
        kind="hang", sentence="it was still running after 1 s and was killed"
    )


def who() -> bytes:
    return str(os.getpid()).encode()


def who_in_stages() -> Stages[bytes]:
    assert (yield lambda: 0.0)() == 0
    return who()


@pytest.mark.parametrize(
    ("rows", "here"), [((1, 1, 1, 1), True), ((1, READ_HERE), False), ((1, None), False)]
)
def test_programs_need_no_workers_where_there_is_little_to_read(
    rows: tuple[int | None, ...], here: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    jobs = [
        Job(n, who, ()) if count is None else Job(n, who, (), stages=who_in_stages, rows=count)
        for n, count in enumerate(rows)
    ]
    with Schedule(2, 60) as schedule:
        found = {job.key: result == who() for job, result in schedule.results(jobs)}
    assert found == dict.fromkeys(range(len(rows)), here)


def fails_in_stages(early: bool) -> Stages[bytes]:
    if early:
        raise LocalError("singular", "before")
    (yield raises)()  # type: ignore[misc]
    return b"done"


def test_a_program_that_cannot_be_run_costs_its_own_job() -> None:
    failing = [Job(early, works, (early,), stages=fails_in_stages) for early in (True, False)]
    with Schedule(1, 60) as schedule:
        found = {
            job.key: result
            for job, result in schedule.results([*failing, Job(2, works, (), stages=who_in_stages)])
        }
    assert found[2] == who()
    assert found[True] == Failure(kind="exception", sentence="LocalError: before")
    assert found[False] == Failure(kind="exception", sentence="LocalError: no analytic point")


LIMITS = Limits(timeout=600, file_bytes=4096, memory=2**33)


def waits_often(times: int) -> Stages[bytes]:
    """Programs one after another; each job waits for several."""
    for _ in range(times):
        result = yield lambda: time.sleep(0.01) or 0.0
        result()
    return b"done"


def test_jobs_that_wait_for_several_programs_come_back_once_each() -> None:
    jobs = [Job(n, works, (n % 4 + 1,), stages=waits_often) for n in range(40)]
    with Schedule(2, 60) as schedule:
        results = list(schedule.results(jobs))
    assert sorted(job.key for job, _ in results) == list(range(40))
    assert {result for _, result in results} == {b"done"}


def sleeps(folder: str, until: str) -> Stages[bytes]:
    """A program that says its number in `pid` and goes on until there is a file `until`."""
    command = ["sh", "-c", f"echo $$ >new; mv new pid; while [ ! -e {until} ]; do sleep 0.05; done"]
    (yield lambda: ended(command, Path(folder), name="sleeper", limits=LIMITS))()
    return b"done"


def interrupted(jobs: list[Job]) -> None:
    with Schedule(2, 60) as schedule:
        next(schedule.results(jobs))
        raise KeyboardInterrupt


def test_programs_end_when_whoever_waits_for_them_is_interrupted(tmp_path: Path) -> None:
    folders = [tmp_path / name for name in ("short", "long", "not begun")]
    for folder in folders:
        folder.mkdir()
    ends = zip(folders, ("../long/pid", "never", "never"), strict=True)
    jobs = [
        Job(n, who, (str(folder), until), stages=sleeps) for n, (folder, until) in enumerate(ends)
    ]
    with pytest.raises(KeyboardInterrupt):
        interrupted(jobs)
    pid = (folders[1] / "pid").read_text().strip()
    assert subprocess.run(["kill", "-0", pid], capture_output=True).returncode != 0


def test_truths_only_compute() -> None:
    """So that no load of the machine takes the truth, and with it the exponent, from a chaotic
    motion.
    """
    asked: list[Job] = []

    class Asked:
        def results(self, jobs: list[Job]) -> list[tuple[Job, Failure]]:
            asked.extend(jobs)
            return [(job, Failure(kind="hang", sentence="it was killed")) for job in jobs]

    instance = discovery.case("double-pendulum").at(theta0="3,3", duration="5", samples="96")
    (truth,) = sampled_truths(Asked(), Nothing(), [(instance, ())], lambda stage, done, total: None)  # type: ignore[arg-type]
    assert [job.computes for job in asked] == [True]
    assert (truth.until, "it was killed" in truth.reason) == (0, True)


def test_what_was_certified_is_made_again_with_more_time_than_the_proof_had() -> None:
    """A proof that came to its last sample just before its end took all of its time for it."""
    asked: list[Job] = []

    class EndsAfterThree:
        def results(self, jobs: list[Job]) -> Iterator[tuple[Job, bytes | Failure]]:
            for job in jobs:
                asked.append(job)
                *_, told = job.arguments
                if told is None:
                    yield job, job.function(*job.arguments)
                else:
                    place, row = told
                    with open(place, "r+b") as file:
                        file.seek(COUNT_BYTES * row)
                        file.write((3).to_bytes(COUNT_BYTES, "little"))
                    yield job, Failure(kind="hang", sentence="it was killed")

    # Of a length that no stored set has.
    instance = discovery.case("harmonic-oscillator").at(duration="7.25", samples="5")
    (truth,) = sampled_truths(
        EndsAfterThree(),  # type: ignore[arg-type]
        Nothing(),  # type: ignore[arg-type]
        [(instance, ())],
        lambda stage, done, total: None,
    )
    assert truth.until == 3
    first, again = asked
    assert first.patience == 1.0
    assert again.patience > 2.0


class Nothing:
    """A store without anything."""

    def truth(self, key: str) -> None:
        return None


def is_cut_short(parent: int, temporary: str) -> None:
    """In place of `begin`: a worker is killed when a part of a long result is in the pipe, once."""
    begin(parent, temporary)
    whole = Connection._send

    def partly(connection: Connection, message: bytes, **how: object) -> None:
        if len(message) >= len(LONG):
            with suppress(FileNotFoundError):
                Path(os.environ["DEATH"]).unlink()
                os.write(connection.fileno(), message[:PART])
                os.kill(os.getpid(), signal.SIGKILL)
        whole(connection, message, **how)

    Connection._send = partly


LONG = b"-" * 2**24
"""A result that is sent in two pieces, its length and itself."""
PART = 2**15
"""Bytes that have room in a pipe."""


def tells_much() -> bytes:
    """A long result."""
    return LONG


def test_a_pool_in_which_a_result_was_cut_short_is_made_again(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("refdem.execution.schedule.UNTAKEN", 10.0)
    jobs = [Job(0, tells_much, ()), *(Job(k, works, ()) for k in range(1, 12))]
    found = results_with_one_death(is_cut_short, jobs, monkeypatch, tmp_path)
    crash = found.pop(0)
    assert isinstance(crash, Failure)
    assert crash.kind == "crash"
    assert found == dict.fromkeys(range(1, 12), b"done")
