"""A program under limits, asked directly: what of its words an error shows, how its end is told,
and how much memory it may take.
"""

import contextlib
import json
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from refdem.core.outside import one_line
from refdem.engines.external import process
from refdem.engines.external.process import Limits, ended, most_memory
from refdem.errors import EngineError, HangError, UnsupportedError

SHOWN = 300
"""Characters of what a program said that an error shows."""
LETTERS = ("x", "\u00e4", "\u529b", "\U0001f9ea")
"""Letters of 1 to 4 bytes in UTF-8."""
Ran = Callable[..., float]


@pytest.fixture
def ran(tmp_path: Path) -> Ran:
    """`ran(code, timeout=60)`: the seconds that a program of Python in an empty folder takes."""

    def seconds(code: str, timeout: float = 60.0) -> float:
        limits = Limits(timeout=timeout, file_bytes=2**24, memory=2**33)
        command = [sys.executable, "-I", "-S", "-c", f"import os, sys, time\n{code}"]
        # A run has a folder of its own, in which nothing was said before.
        for name in ("stdout.txt", "stderr.txt"):
            (tmp_path / name).unlink(missing_ok=True)
        return ended(command, tmp_path, name="small", limits=limits)

    return seconds


def says(text: str, status: int) -> str:
    """The code of a program that says a text and ends."""
    return f"os.write(2, {text.encode()!r}); os._exit({status})"


@pytest.mark.parametrize("letter", LETTERS)
@pytest.mark.parametrize("end", ["", "\n", "\r\n"])
@pytest.mark.parametrize("count", [1, SHOWN - 1, SHOWN, SHOWN + 1, 20 * SHOWN])
def test_an_error_shows_the_end_of_what_was_said_in_any_alphabet(
    ran: Ran, letter: str, end: str, count: int
) -> None:
    """To the last 300 characters, of which none is half a character."""
    text = letter * count
    with pytest.raises(EngineError) as raised:
        ran(says(text + end, 1))
    assert str(raised.value) == f"small ended with exit status 1: {text[-SHOWN:]}"


@pytest.mark.parametrize("letter", LETTERS)
def test_a_refusal_shows_its_last_line_and_of_that_the_end(ran: Ran, letter: str) -> None:
    line = letter * SHOWN
    for text in (f"first\n{line}\n", f"first\nbefore {line}", f"{letter * 5000}\n{line}"):
        with pytest.raises(UnsupportedError) as raised:
            ran(says(text, 77))
        assert str(raised.value) == line


def test_a_refusal_without_words_says_what_it_is(ran: Ran) -> None:
    for text in ("", "\n \n"):
        with pytest.raises(UnsupportedError, match=r"not supported \(exit status 77\)$"):
            ran(says(text, 77))


@pytest.mark.parametrize("status", [1, 76, 78, 255])
def test_no_other_status_is_a_refusal(ran: Ran, status: int) -> None:
    with pytest.raises(
        EngineError, match=f"^small ended with exit status {status}: stderr is empty$"
    ):
        ran(says("", status))


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (signal.SIGTERM, r"signal 15 \(SIGTERM\)"),
        (signal.SIGABRT, r"signal 6 \(SIGABRT\)"),
        (signal.SIGXFSZ, r"signal 25 \(SIGXFSZ: a file grew too large\)"),
        (signal.SIGRTMIN + 1, "signal 35"),
    ],
)
@pytest.mark.skipif(sys.platform != "linux", reason="numbers of signals are Linux's")
def test_a_signal_is_told_by_number_and_name(ran: Ran, number: int, words: str) -> None:
    with pytest.raises(EngineError, match=f"^small ended with {words}: stderr is empty$"):
        ran(
            f"import signal\nsignal.signal({int(number)}, signal.SIG_DFL)\n"
            f"os.kill(os.getpid(), {int(number)}); time.sleep(60)"
        )


def test_a_program_that_ends_well_has_its_seconds_and_words(ran: Ran, tmp_path: Path) -> None:
    code = "time.sleep(0.25); print('out', flush=True); print('err', file=sys.stderr, flush=True)"
    assert ran(code) >= 0.25
    assert (tmp_path / "stdout.txt").read_text() == "out\n"
    assert (tmp_path / "stderr.txt").read_text() == "err\n"


def test_a_program_that_has_no_time_left_is_ended(ran: Ran) -> None:
    with pytest.raises(HangError, match=r"^small was still running after 0\.125 s and was ended$"):
        ran("time.sleep(60)", timeout=0.125)


def test_a_program_is_alone_and_has_no_input(ran: Ran, tmp_path: Path) -> None:
    """In a session of its own, in its folder, with three descriptors and signals as they are by
    default; it leaves no file of its memory.
    """
    code = (
        "import json, resource, signal\n"
        "numbers = set(map(int, os.listdir('/proc/self/fd')))\n"
        "open('told', 'w').write(json.dumps([os.getsid(0) == os.getpid(), os.getcwd(),"
        " sys.stdin.read(), sorted(numbers)[:4], signal.getsignal(signal.SIGINT)"
        " is signal.default_int_handler, signal.getsignal(signal.SIGTERM) is signal.SIG_DFL,"
        " signal.getsignal(signal.SIGHUP) is signal.SIG_DFL,"
        " resource.getrlimit(resource.RLIMIT_CORE)]))"
    )
    ran(code)
    told = json.loads((tmp_path / "told").read_text())
    # The fourth descriptor is that of the folder that it lists.
    expected = [True, os.path.realpath(tmp_path), "", [0, 1, 2, 3], True, True, True, [0, 0]]
    assert told == expected


@pytest.mark.parametrize(
    ("limits", "share"),
    [
        ((), 1.0),
        (("max\n",), 1.0),
        (("1000000\n",), 1e6),
        (("max\n", "3000000\n"), 3e6),
        (("2000000\n", "3000000\n"), 2e6),
        (("none of all\n",), 1.0),
        ((f"{2**62}\n",), 1.0),
    ],
    ids=str,
)
def test_most_memory_is_nine_tenths_of_what_machine_and_container_have(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limits: tuple[str, ...], share: float
) -> None:
    places = [tmp_path / "is not there"]
    for number, text in enumerate(limits):
        places.append(tmp_path / str(number))
        places[-1].write_text(text)
    monkeypatch.setattr(process, "CONTROL_GROUPS", tuple(map(str, places)))
    whole = share
    if share == 1.0:
        whole = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    assert most_memory() == int(0.9 * whole)


def test_a_program_that_cannot_be_started_is_named_with_the_reason(tmp_path: Path) -> None:
    limits = Limits(timeout=60.0, file_bytes=2**20, memory=2**33)
    missing = str(tmp_path / "not\nthere")
    for command, folder in (([missing], tmp_path), ([sys.executable], tmp_path / "gone")):
        with pytest.raises(EngineError, match=r"cannot be started: .*No such file") as raised:
            process.run(command, folder, sys.__stdout__.buffer, sys.__stderr__.buffer, limits)  # type: ignore[union-attr]
        assert one_line(str(raised.value)).endswith(str(raised.value).splitlines()[-1])


class Interrupt(BaseException):
    """What a handler of a signal raises, as Ctrl-C in a notebook does."""


def interrupt(number: int, frame: object) -> None:
    raise Interrupt


def test_the_run_after_one_that_was_interrupted_is_told_by_its_own_status(ran: Ran) -> None:
    """Runs of one session are told in the order of their answers."""
    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(Interrupt):
            ran("time.sleep(60)")
    finally:
        signal.signal(signal.SIGALRM, before)
    for status in (3, 4):
        with pytest.raises(EngineError, match=f"exit status {status}: own words"):
            ran(says("own words", status))


@pytest.mark.parametrize(
    "stops",
    [
        "os.kill(os.getppid(), 19); time.sleep(600)",
        "os.kill(os.getppid(), 19)",
        # One that goes on is stopped again.
        "exec('while True: os.kill(os.getppid(), 19)')",
        "if os.fork() == 0:\n  os.setsid()\n  while True: os.kill(STOPPED, 19)",
    ],
)
def test_a_program_that_stops_its_supervisor_is_an_error_and_nothing_is_left(
    stops: str, ran: Ran, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(process, "HELD_UP", 1.0)
    monkeypatch.setattr(process, "ENDING", 1.0)
    before = process.supervised().process
    code = f"STOPPED = os.getppid()\n{stops}\ntime.sleep(600)"
    with pytest.raises(EngineError, match="together with its supervisor process"):
        ran(code, timeout=1.0)
    assert before.poll() is not None
    mark = b"STOPPED = os.getppid()"
    until = time.monotonic() + 60.0
    while running := processes_with(mark):
        assert time.monotonic() < until, running
        time.sleep(0.05)
    assert ran("pass") > 0.0


def processes_with(mark: bytes) -> list[str]:
    """Processes that have a word in their command line and have not ended."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            if mark in path.read_bytes():
                found.append(path.parent.name)
    return found
