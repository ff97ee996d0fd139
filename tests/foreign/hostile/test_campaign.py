"""One campaign over a zoo of hostile programs: an error each, the rest judged, nothing left."""

import re
import time
from pathlib import Path

import pytest

from tests.foreign.hostile import modes
from tests.foreign.hostile.campaigns import (
    described,
    findings_in,
    refuse_commands,
    run,
    wait_for_folders,
)

PATIENCE = 120.0
"""Seconds within which a folder is taken away, on any machine."""
FAST = [*modes.ERRORS, *modes.TIMES, *modes.REFUSALS, *modes.HARMLESS, *modes.WRONG]


def left(mark: str) -> "list[Path]":
    """Processes that have a word in their command line."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            is_one = mark.encode() in path.read_bytes()
        except OSError:
            continue
        if is_one:
            found.append(path)
    return found


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory):
    """The folder of a campaign that has run, and what it said."""
    folder = tmp_path_factory.mktemp("zoo")
    # The good program takes a second on any machine, and those that hang take all of their time.
    fast = described(folder, "zoo", ["good", *FAST], "timeout = 300\nbudget = 3000\nmemory = 0.5")
    slow = described(folder, "slow", list(modes.SLOW), "timeout = 1\nbudget = 3000")
    return folder, run(folder, [fast, slow])


@pytest.fixture(scope="module")
def findings(campaign) -> "dict[str, list[tuple[str, str]]]":
    """Outcome and sentence of every finding by method."""
    folder, _ = campaign
    return findings_in(folder)


def test_the_campaign_ends_as_one_in_which_a_check_failed(campaign) -> None:
    _, done = campaign
    assert done.returncode == 1, done.stderr[-3000:]
    assert b"Traceback" not in done.stdout + done.stderr


def test_every_mode_is_judged(findings) -> None:
    assert sorted(findings) == sorted(["good", *modes.MODES])


@pytest.mark.parametrize(
    ("method", "says"),
    [*modes.ERRORS.items(), *modes.TIMES.items(), *modes.SLOW.items()],
)
def test_each_is_one_error(findings, method: str, says: str) -> None:
    ((outcome, sentence),) = findings[method]
    assert outcome == "error"
    assert re.search(says, sentence), sentence


@pytest.mark.parametrize(("method", "says"), modes.REFUSALS.items())
def test_each_refusal_is_no_error(findings, method: str, says: str) -> None:
    assert {outcome for outcome, _ in findings[method]} == {"unsupported"}
    assert all(says in sentence for _, sentence in findings[method])


@pytest.mark.parametrize("method", modes.HARMLESS)
def test_what_hurts_nobody_is_judged_as_the_good_program(findings, method: str) -> None:
    assert findings[method] == findings["good"]
    outcomes = {outcome for outcome, _ in findings["good"]}
    assert "pass" in outcomes
    assert not outcomes & {"fail", "error"}


@pytest.mark.parametrize("method", modes.WRONG)
def test_what_is_wrong_fails(findings, method: str) -> None:
    outcomes = {outcome for outcome, _ in findings[method]}
    assert "fail" in outcomes
    assert "error" not in outcomes


def test_no_process_and_no_folder_is_left(campaign) -> None:
    folder, _ = campaign
    assert not left(f"grandchild of {folder}")
    # What was killed is cleaned up behind by a process of its own.
    until = time.monotonic() + PATIENCE
    wait_for_folders(folder, until)


def test_nothing_that_a_program_says_reaches_a_terminal_or_a_log_as_a_command(campaign) -> None:
    folder, done = campaign
    refuse_commands(folder, done.stdout + done.stderr)
    for path in (folder / "report").rglob("*"):
        if path.suffix in (".html", ".md"):
            assert "<script>alert(1)" not in path.read_text(), path
        if path.suffix == ".csv":
            assert not re.search(r'(^|[,"])[=@]', path.read_text(), re.MULTILINE), path
        if path.suffix == ".md":
            assert "@everyone" not in path.read_text(), path
