"""Parts of the process that watches over programs, asked in this one: what it counts, what it waits
for, and what it takes away.
"""

import os
import resource
import shutil
import signal
import socket
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from refdem.engines.external import supervisor

REAL = {name: getattr(os, name) for name in ("lstat", "open", "scandir", "unlink", "rmdir")}
"""What rmtree asks of the system."""


def filled(folder: Path) -> Path:
    """A folder with folders and files in it."""
    for name in ("a", "b/c"):
        (folder / name).mkdir(parents=True)
        (folder / name / "file").touch()
    return folder


@pytest.mark.parametrize("part", ["", "a", "b", "b/c"])
def test_folders_that_vanish_at_any_moment_of_being_removed_are_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, part: str
) -> None:
    """Another process takes a part of it away before each of the calls by which rmtree removes it:
    before the first call, before the second one, and so on.
    """
    calls = 0
    last = 0

    def overtaken(name: str, folder: Path, before: int) -> Callable[..., object]:
        def called(*arguments: object, **options: object) -> object:
            nonlocal calls
            calls += 1
            if calls == before:
                for function, real in REAL.items():
                    monkeypatch.setattr(os, function, real)
                shutil.rmtree(folder / part, ignore_errors=True)
            return REAL[name](*arguments, **options)

        return called

    while calls >= last:
        last += 1
        calls = 0
        folder = filled(tmp_path / str(last))
        for name in REAL:
            monkeypatch.setattr(os, name, overtaken(name, folder, last))
        supervisor.remove(folder)
        for name, real in REAL.items():
            monkeypatch.setattr(os, name, real)
        assert not folder.exists()
    assert last > 5


@pytest.mark.parametrize("kind", ["file", "folder", "link", "link to nothing", "nothing"])
def test_what_lies_in_a_folder_without_rights_is_taken_away_and_nothing_beside_it(
    tmp_path: Path, kind: str
) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "file").touch()
    outside.chmod(0o500)
    locked = tmp_path / "locked"
    locked.mkdir()
    (locked / "neighbour").touch()
    place = locked / "place"
    if kind == "file":
        place.touch()
    elif kind == "folder":
        filled(place).chmod(0)
    elif kind == "link":
        place.symlink_to(outside)
    elif kind == "link to nothing":
        place.symlink_to("nothing")
    locked.chmod(0)
    supervisor._opened_up(os.unlink, str(place), None)
    assert stat.S_IMODE(locked.stat().st_mode) == stat.S_IRWXU
    assert os.listdir(locked) == ["neighbour"]
    assert stat.S_IMODE(outside.stat().st_mode) == 0o500
    assert os.listdir(outside) == ["file"]
    outside.chmod(stat.S_IRWXU)


def test_a_folder_that_is_a_link_is_not_opened_up(tmp_path: Path) -> None:
    """What a program puts in place of its folder may lead to a folder of someone else."""
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "file").touch()
    outside.chmod(0o500)
    (tmp_path / "link").symlink_to(outside)
    supervisor._opened_up(os.unlink, str(tmp_path / "link" / "gone"), None)
    assert stat.S_IMODE(outside.stat().st_mode) == 0o500
    outside.chmod(stat.S_IRWXU)


@pytest.fixture
def child() -> Iterator[Callable[[str], "subprocess.Popen[str]"]]:
    """Starts processes of Python that say a line once they are there; ends them."""
    begun: list[subprocess.Popen[str]] = []

    def started(code: str) -> "subprocess.Popen[str]":
        text = f"import os, sys, time\n{code}\nprint('here', flush=True)\nsys.stdin.read()"
        process = subprocess.Popen(
            [sys.executable, "-I", "-S", "-c", text],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        begun.append(process)
        assert process.stdout is not None
        assert process.stdout.readline() == "here\n"
        return process

    yield started
    for process in begun:
        process.kill()
        process.communicate()


def test_descendants_are_those_that_have_not_ended(
    child: "Callable[[str], subprocess.Popen[str]]",
) -> None:
    """Children of children among them, also of a program with a bracket in its name; what has ended
    and what this process did not start is not.
    """
    before = set(supervisor.descendants())
    code = (
        "r, w = os.pipe()\nif os.fork() == 0:\n    os.close(w)\n    os.read(r, 1)\n    os._exit(0)"
    )
    if sys.platform == "linux":
        code += "\nopen('/proc/self/comm', 'w').write('a) R 1 (b')"
    parent = child(code)
    there = set(supervisor.descendants()) - before
    assert parent.pid in there
    assert len(there) == 2
    assert os.getpid() not in there
    assert os.getppid() not in there
    parent.kill()
    parent.wait()
    assert parent.pid not in supervisor.descendants()


def test_memory_is_what_a_process_has_filled(
    child: "Callable[[str], subprocess.Popen[str]]", tmp_path: Path
) -> None:
    """In bytes, shared with other processes or not; a process that is gone has none."""
    size = 2**26
    small = child("pass")
    large = child(f"filled = b'x' * {size}")
    grown = supervisor.memory_of(large.pid) - supervisor.memory_of(small.pid)
    assert grown == pytest.approx(size, rel=0.1)
    shared = child(
        f"import mmap\nplace = mmap.mmap(-1, {size}, mmap.MAP_SHARED)\nplace.write(b'x' * {size})"
    )
    grown = supervisor.memory_of(shared.pid) - supervisor.memory_of(small.pid)
    assert grown == pytest.approx(size, rel=0.1)
    # Pages of a file are the system's.
    file = tmp_path / "file"
    file.write_bytes(b"x" * size)
    reader = child(
        f"import mmap\nfile = open({str(file)!r}, 'rb')\n"
        f"place = mmap.mmap(file.fileno(), {size}, access=mmap.ACCESS_READ)\n"
        "seen = sum(place[::4096])"
    )
    assert supervisor.memory_of(reader.pid) - supervisor.memory_of(small.pid) < size / 10
    small.kill()
    small.wait()
    assert supervisor.memory_of(small.pid) == 0


def test_what_lingers_is_waited_for_and_then_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that ends within the grace does not count; the clock is one of the test's own."""
    now = 0.0
    ends = 0.0

    def slept(seconds: float) -> None:
        nonlocal now
        now += seconds

    monkeypatch.setattr(supervisor, "has_children", lambda: now < ends)
    monkeypatch.setattr(supervisor.time, "monotonic", lambda: now)
    monkeypatch.setattr(supervisor.time, "sleep", slept)
    monkeypatch.setattr(supervisor, "descendants", lambda: [7, 8])
    for part, left, waits in ((0.0, 0, 0.0), (0.5, 0, 0.5), (2.0, 2, 1.0)):
        now = 0.0
        ends = part * supervisor.GRACE
        until = waits * supervisor.GRACE
        assert supervisor.lingering() == left
        assert until <= now <= until + 2 * supervisor.PAUSE


def test_an_orphan_is_told_from_a_process_that_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0

    def slept(seconds: float) -> None:
        nonlocal now
        now += seconds

    monkeypatch.setattr(supervisor.time, "monotonic", lambda: now)
    monkeypatch.setattr(supervisor.time, "sleep", slept)
    monkeypatch.setattr(supervisor, "PAUSE", supervisor.ENDING / 16)
    monkeypatch.setattr(supervisor.os, "getppid", lambda: 7)
    assert supervisor.is_orphan(8)
    assert now == 0.0
    assert not supervisor.is_orphan(7)
    assert supervisor.ENDING < now < 1.25 * supervisor.ENDING


@pytest.mark.parametrize(
    ("allowed", "most", "limit"),
    [(resource.RLIM_INFINITY, 5, 5), (7, 5, 5), (3, 5, 3), (0, 5, 0)],
)
def test_a_limit_is_never_wider_than_the_one_before(
    monkeypatch: pytest.MonkeyPatch, allowed: int, most: int, limit: int
) -> None:
    told: list[tuple[int, tuple[int, int]]] = []
    monkeypatch.setattr(supervisor.resource, "getrlimit", lambda kind: (1, allowed))
    monkeypatch.setattr(
        supervisor.resource, "setrlimit", lambda kind, both: told.append((kind, both))
    )
    supervisor.limited(resource.RLIMIT_FSIZE, most)
    assert told == [(resource.RLIMIT_FSIZE, (limit, limit))]


def test_an_open_descriptor_is_told_from_a_closed_one() -> None:
    own, other = os.pipe()
    assert supervisor.is_open(own)
    os.close(own)
    os.close(other)
    assert not supervisor.is_open(other)


@pytest.mark.parametrize("pieces", [1, 2, 6])
def test_a_request_that_comes_in_pieces_is_one_request(
    monkeypatch: pytest.MonkeyPatch, pieces: int
) -> None:
    """The descriptors of all pieces come with it, in order."""
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    monkeypatch.setattr(signal, "set_wakeup_fd", lambda _: -1)
    ours, its = socket.socketpair()
    server = supervisor.Supervisor(its)
    text = b'{"command": ["a", "b"]}\n'
    size = -(-len(text) // pieces)
    ends = [os.pipe() for _ in range(pieces)]
    for number in range(pieces):
        part = text[number * size : (number + 1) * size]
        socket.send_fds(ours, [part], [ends[number][1]])
    received = server.received()
    assert received is not None
    request, descriptors = received
    assert request == {"command": ["a", "b"]}
    for number, descriptor in enumerate(descriptors):
        os.write(descriptor, b"%d" % number)
        assert os.read(ends[number][0], 1) == b"%d" % number
    assert len(descriptors) == pieces
    for descriptor in (*descriptors, *(end for pair in ends for end in pair)):
        os.close(descriptor)
    os.close(server.woken)
    ours.close()
    its.close()


@pytest.mark.parametrize(
    ("last", "is_dismissed"), [(supervisor.GOODBYE, True), (b"", False), (b"en", False)]
)
def test_only_a_goodbye_dismisses(
    monkeypatch: pytest.MonkeyPatch, last: bytes, is_dismissed: bool
) -> None:
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    monkeypatch.setattr(signal, "set_wakeup_fd", lambda _: -1)
    ours, its = socket.socketpair()
    server = supervisor.Supervisor(its)
    ours.sendall(last)
    ours.close()
    assert server.received() is None
    assert server.is_dismissed is is_dismissed
    os.close(server.woken)
    its.close()


def test_memory_is_looked_at_also_where_an_answer_has_come_already(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(supervisor, "descendants", lambda: [1, 2])
    monkeypatch.setattr(supervisor, "memory_of", lambda process: 100 * process)
    service = object.__new__(supervisor.Service)
    service.text = b'{"id": "1", "done": true}\n'
    service.open = set()
    service.answering = service.telling = -1
    service.look = 0.0
    watching = object.__new__(supervisor.Supervisor)
    with pytest.raises(supervisor.FaultError) as raised:
        watching.next_line(service, until=float("inf"), most=199)
    assert raised.value.details == {"fault": "memory", "taken": 200}
    service.look = 0.0
    assert watching.next_line(service, until=float("inf"), most=200) == b'{"id": "1", "done": true}'
    # The next look comes a while after this one.
    assert service.look > 0
