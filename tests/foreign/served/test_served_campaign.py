"""One campaign over the zoo of programs that stay alive: an error each, the rest judged, nothing
left and nothing said in refdem's name.
"""

import json
import re
import shutil
import sys
import time
from pathlib import Path

import pytest

from tests.foreign.hostile.campaigns import (
    findings_in,
    refuse_commands,
    run,
    wait_for_folders,
)
from tests.foreign.served import modes
from tests.processes import processes

PROGRAM = Path(__file__).with_name("program.py")
PATIENCE = 120.0
"""Seconds within which processes and folders are gone, on any machine."""
LOST = {"takes-the-folder-of-its-request-away": r"wrote no trajectory\.csv"}
"""One error each, beside those that a single request shows."""


def described(folder: Path, name: str, methods: "list[str]", limits: str) -> str:
    """The refdem.toml of a copy of the program that stays alive."""
    place = folder / name
    place.mkdir()
    shutil.copy(PROGRAM, place / "program.py")
    tables = "".join(f'[[engine.methods]]\nname = "{method}"\norder = 2\n' for method in methods)
    path = place / "refdem.toml"
    path.write_text(
        f'[engine]\nname = "{name}"\ncommand = {json.dumps([sys.executable, "program.py"])}\n'
        f'serve = true\nsupports = ["spring", "dimension:1"]\n{limits}\n{tables}'
    )
    return str(path)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory):
    """The folder of a campaign that has run, and what it said."""
    folder = tmp_path_factory.mktemp("served")
    fast = ["good", *modes.ERRORS, *LOST, *modes.HARMLESS]
    limits = "timeout = 300\nwarm_up = 300\nbudget = 3000\nmemory = 0.5"
    engines = [
        described(folder, "zoo", fast, limits),
        described(folder, "slow", list(modes.SLOW), "timeout = 1\nwarm_up = 1\nbudget = 3000"),
    ]
    return folder, run(folder, engines)


@pytest.fixture(scope="module")
def findings(campaign) -> "dict[str, list[tuple[str, str]]]":
    """Outcome and sentence of every finding by method."""
    folder, _ = campaign
    return findings_in(folder)


def test_the_campaign_ends_as_one_in_which_runs_failed(campaign) -> None:
    _, done = campaign
    assert done.returncode == 3, done.stderr[-3000:]
    # A program's own traceback is one line of its error.
    assert not re.search(rb"^Traceback", done.stdout + done.stderr, re.MULTILINE)


@pytest.mark.parametrize(
    ("method", "says"), [*modes.ERRORS.items(), *modes.SLOW.items(), *LOST.items()]
)
def test_each_is_one_error(findings, method: str, says: str) -> None:
    ((outcome, sentence),) = findings[method]
    assert outcome == "error"
    # The memory that is allowed differs here.
    assert re.search(says.replace(r"0\.3 GB", r"0\.5 GB"), sentence), sentence


@pytest.mark.parametrize("method", modes.HARMLESS)
def test_what_hurts_nobody_is_judged_as_the_good_program(findings, method: str) -> None:
    assert findings[method] == findings["good"]
    outcomes = {outcome for outcome, _ in findings["good"]}
    assert "pass" in outcomes
    assert not outcomes & {"fail", "error"}


def test_no_process_and_no_folder_is_left(campaign) -> None:
    folder, _ = campaign
    until = time.monotonic() + PATIENCE
    while processes(f"{folder}/"):
        assert time.monotonic() < until, processes(f"{folder}/")
        time.sleep(0.05)
    wait_for_folders(folder, until)


def test_nothing_that_a_program_says_reaches_a_terminal_or_a_log_as_a_command(campaign) -> None:
    folder, done = campaign
    refuse_commands(folder, done.stdout + done.stderr)
