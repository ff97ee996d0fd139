"""What a supervisor makes of the programs that it starts, and that nothing adds up in it over many
runs.
"""

import json
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from refdem.engines.external.process import Supervised
from refdem.errors import EngineError

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="it looks into /proc")

TOLD = """
import ctypes, json, os, signal
number = ctypes.c_int()
ctypes.CDLL(None).prctl(2, ctypes.byref(number), 0, 0, 0)
told = {
    "signal when its parent ends": number.value,
    "to go first when memory ends": open("/proc/self/oom_score_adj").read().strip(),
    "ignored signals": [n for n in (1, 2, 13, 15, 17, 25) if signal.getsignal(n) == signal.SIG_IGN],
    "shared": os.environ.get("REFDEM_TEST_SHARED"),
    "own": os.environ.get("REFDEM_TEST_OWN"),
}
json.dump(told, open("told", "w"))
"""


@pytest.fixture
def supervised(monkeypatch: pytest.MonkeyPatch) -> Iterator[Supervised]:
    """A supervisor of the test's own, in an environment of its own."""
    monkeypatch.setenv("REFDEM_TEST_SHARED", "a")
    began = Supervised()
    yield began
    began.close()


def run(began: Supervised, folder: Path, command: list[str], **changed: object) -> int | None:
    """The status of a program."""
    request = {
        "command": command,
        "folder": str(folder),
        "environment": {},
        "timeout": 60.0,
        "bytes": 2**20,
        "memory": 2**33,
    }
    with (folder / "out").open("wb") as out, (folder / "err").open("wb") as err:
        return began.ended(request | changed, out, err).status


def python(code: str) -> list[str]:
    """A program of Python."""
    return [sys.executable, "-I", "-S", "-c", code]


def children(process: int) -> list[int]:
    """The processes that one has started, those that have ended and nobody asked for among them."""
    return [
        int(word) for word in Path(f"/proc/{process}/task/{process}/children").read_text().split()
    ]


def test_many_runs_leave_no_descriptor_and_no_process_behind(
    supervised: Supervised, tmp_path: Path
) -> None:
    """Programs that end well, that fail, that cannot be started, and that leave an orphan which
    ends by itself.
    """
    orphan = "import os, time\nif os.fork() == 0:\n    time.sleep(0.02)\n    os._exit(0)"
    commands = [python("pass"), python("raise SystemExit(3)"), python(orphan)]

    def once() -> None:
        for command in commands:
            run(supervised, tmp_path, command)
        with pytest.raises(EngineError, match="cannot be started"):
            run(supervised, tmp_path, ["./missing"])

    once()
    (serving,) = children(supervised.process.pid)
    before = sorted(os.listdir(f"/proc/{serving}/fd"))
    assert children(serving) == []
    for _ in range(4):
        once()
    assert sorted(os.listdir(f"/proc/{serving}/fd")) == before
    assert children(serving) == []
    assert children(supervised.process.pid) == [serving]


def test_a_program_begins_as_it_should(supervised: Supervised, tmp_path: Path) -> None:
    """It dies with its parent and is the first to go where memory ends; no signal is ignored but
    those that Python ignores itself; its environment is refdem's own with what is asked for.
    """
    own = {"REFDEM_TEST_OWN": "b"}
    assert run(supervised, tmp_path, python(TOLD), environment=own) == 0
    told = json.loads((tmp_path / "told").read_text())
    assert told["signal when its parent ends"] == 9
    assert told["to go first when memory ends"] == "1000"
    assert told["ignored signals"] == [13, 25]
    assert told["own"] == "b"
    assert told["shared"] == "a"


@pytest.mark.parametrize("status", [0, 1, 127, 128, 255])
def test_the_status_of_a_program_is_told_as_it_is(
    supervised: Supervised, tmp_path: Path, status: int
) -> None:
    assert run(supervised, tmp_path, python(f"raise SystemExit({status})")) == status


def test_why_a_program_cannot_be_started_is_told_in_a_thousand_letters(
    supervised: Supervised, tmp_path: Path
) -> None:
    name = "./" + "m" * 3000
    with pytest.raises(EngineError, match=r"cannot be started: .*File name too long") as raised:
        run(supervised, tmp_path, [name])
    reason = str(raised.value).partition("cannot be started: ")[2]
    assert len(reason) <= 1000
    assert run(supervised, tmp_path, python("pass")) == 0


@pytest.mark.parametrize("size", [2**14, 2**14 + 1])
def test_a_file_may_be_as_large_as_the_limit(
    supervised: Supervised, tmp_path: Path, size: int
) -> None:
    code = f"assert open('big', 'wb', 0).write(b'x' * {size}) == {size}"
    assert (run(supervised, tmp_path, python(code), bytes=2**14) == 0) is (size == 2**14)
    assert (tmp_path / "big").stat().st_size == 2**14


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_what_ends_refdem_does_not_end_its_supervisor(
    supervised: Supervised, tmp_path: Path, number: int
) -> None:
    """It ends when refdem does, and not before it has ended the programs; these do end by them."""
    assert run(supervised, tmp_path, python("pass")) == 0
    for process in (*children(supervised.process.pid), supervised.process.pid):
        os.kill(process, number)
    assert run(supervised, tmp_path, python("pass")) == 0
    code = f"import os, time\nos.kill(os.getpid(), {int(number)})\ntime.sleep(60)"
    shell = ["/bin/sh", "-c", f"kill -{int(number)} $$; sleep 60"]
    assert run(supervised, tmp_path, shell) == -number
    assert run(supervised, tmp_path, python(code)) != 0
