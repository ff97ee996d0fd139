"""Work that takes long says so, whatever part of it does: no clock decides, for the work waits
until it has been said.
"""

import sys
import threading

import pytest

from refdem.cli.progress import Progress, Watch

PATIENCE = 600.0
"""Seconds after which a sentence that never comes fails the test."""


class Heard:
    """Standard error that tells when something is written to it."""

    def __init__(self, tty: bool) -> None:
        self.tty = tty
        self.text = ""
        self.said = threading.Event()

    def isatty(self) -> bool:
        return self.tty

    def write(self, text: str) -> int:
        self.text += text
        self.said.set()
        return len(text)

    def flush(self) -> None:
        pass


class Full(Heard):
    """Standard error on a disk that is full."""

    def write(self, text: str) -> int:
        raise OSError(28, "No space left on device")


@pytest.mark.parametrize("tty", [True, False])
def test_a_standard_error_that_cannot_be_written_ends_no_work(tty, monkeypatch):
    monkeypatch.setattr(sys, "stderr", Full(tty))
    progress = Progress()
    progress("runs", 0, 1)
    progress("runs", 1, 1)
    with Watch("proving", quiet=0.0) as watch:
        watch.say("it goes on")


@pytest.mark.parametrize("tty", [True, False])
def test_work_that_forecasts_nothing_still_says_that_it_goes_on(tty, monkeypatch):
    heard = Heard(tty)
    monkeypatch.setattr(sys, "stderr", heard)
    with Watch("proving", quiet=0.0):
        assert heard.said.wait(PATIENCE)
    assert "proving: 0 s of CPU so far" in heard.text
    assert heard.text.endswith("\r\x1b[K" if tty else "\n")


def test_what_is_left_is_told_where_it_is_known(monkeypatch):
    heard = Heard(False)
    monkeypatch.setattr(sys, "stderr", heard)
    with Watch("proving", quiet=0.0) as watch:
        watch.expect(1e5)
        assert heard.said.wait(PATIENCE)
    assert "so far, about 1.2 days to go" in heard.text


def test_work_goes_on_where_nobody_reads_what_is_said(monkeypatch):
    heard = Heard(False)
    monkeypatch.setattr(sys, "stderr", heard)

    def gone(text):
        heard.said.set()
        raise BrokenPipeError

    heard.write = gone
    with Watch("proving", quiet=0.0):
        assert heard.said.wait(PATIENCE)


def test_work_that_is_soon_done_says_nothing(capsys):
    with Watch("proving", quiet=1e9):
        pass
    assert capsys.readouterr() == ("", "")


def test_a_stage_is_told_in_a_pipe_when_it_begins_and_when_it_has_ended(capsys):
    progress = Progress()
    progress("truths", 0, 2)
    assert capsys.readouterr().err == "truths: 2 to do\n"
    progress("truths", 1, 2)
    assert capsys.readouterr().err == ""
    progress("truths", 2, 2)
    assert capsys.readouterr().err.startswith("truths: 2 done, ")
