"""Locks between processes that are pipes: held by one thread of one process at a time, and known to
nobody by a name.
"""

import os
import signal
import threading
from multiprocessing import resource_tracker
from pathlib import Path

import pytest

from refdem.execution.schedule import Job, Schedule
from refdem.execution.spawning import PipeLock, Spawning

PATIENCE = 120.0
"""Seconds within which a process starts and answers, on any machine."""


def in_a_thread(function) -> object:
    """What a function returns in a thread of its own."""
    found = []
    thread = threading.Thread(target=lambda: found.append(function()))
    thread.start()
    thread.join(PATIENCE)
    (one,) = found
    return one


def test_the_holder_may_acquire_a_lock_once_more_and_no_other_thread_may() -> None:
    lock = Spawning().RLock()
    assert lock.acquire()
    assert lock.acquire(block=False)
    assert not in_a_thread(lambda: lock.acquire(block=False))
    assert not in_a_thread(lambda: lock.acquire(timeout=0.01))
    lock.release()
    assert not in_a_thread(lambda: lock.acquire(block=False))
    lock.release()
    assert in_a_thread(lambda: lock.acquire(timeout=PATIENCE))


def test_a_thread_that_waits_gets_the_lock_when_it_is_released() -> None:
    lock = Spawning().RLock()
    assert lock.acquire()
    found = []
    waiting = threading.Thread(target=lambda: found.append(lock.acquire()))
    waiting.start()
    lock.release()
    waiting.join(PATIENCE)
    assert found == [True]


def tries(lock: PipeLock, connection) -> None:
    """Says whether another process gets the lock at once, and then whether it gets it at all."""
    connection.send(lock.acquire(block=False))
    connection.send(lock.acquire(timeout=PATIENCE))
    lock.release()


def test_another_process_waits_for_the_lock(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    context = Spawning()
    lock = context.RLock()
    assert lock.acquire()
    here, there = context.Pipe()
    process = context.Process(target=tries, args=(lock, there))
    process.start()
    assert here.recv() is False
    lock.release()
    assert here.recv() is True
    process.join(PATIENCE)
    assert lock.acquire(timeout=PATIENCE)


def dies_with(lock: PipeLock) -> None:
    """Is killed while it holds the lock."""
    lock.acquire()
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_lock_whose_holder_is_killed_is_free(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    context = Spawning()
    lock = context.RLock()
    process = context.Process(target=dies_with, args=(lock,))
    process.start()
    process.join(PATIENCE)
    assert process.exitcode == -signal.SIGKILL
    assert lock.acquire(block=False)


def test_an_interrupt_while_a_process_starts_does_not_reach_it(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    process = Spawning().Process(target=signal.getsignal, args=(signal.SIGINT,))
    process.start()
    assert process.pid is not None
    os.kill(process.pid, signal.SIGINT)
    process.join(PATIENCE)
    assert process.exitcode == 0
    assert "Traceback" not in capfd.readouterr().err
    # The process that starts it is interrupted as before.
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def mapped() -> bytes:
    """The shared memory with a name that this process maps."""
    lines = Path("/proc/self/maps").read_text().splitlines()
    return "\n".join(line for line in lines if "/dev/shm/" in line).encode()


def test_workers_share_no_memory_that_a_program_could_truncate(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    before = mapped()
    named = []
    monkeypatch.setattr(resource_tracker, "register", lambda *what: named.append(what))
    with Schedule(1, PATIENCE) as schedule:
        ((_, found),) = schedule.results([Job(0, mapped, ())])
        assert mapped() == before
    assert found == b""
    assert named == []
