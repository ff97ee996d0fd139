"""Programs that take away what others might need, each an engine of its own: an error each, and the
rest of the campaign is complete.
"""

import json
import re
from pathlib import Path

import pytest

from tests.foreign.hostile import modes
from tests.foreign.hostile.campaigns import described, run

LIMITS = 'inputs = ["input.txt"]\ntimeout = 300\nbudget = 3000'


def engine(folder: Path, mode: str, name: str) -> str:
    """The refdem.toml of an engine with one method, which misbehaves in one way."""
    path = described(folder, name, [mode], LIMITS)
    (folder / name / "input.txt").write_text("some numbers")
    return path


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory):
    """The folder of a campaign that has run, and what it said."""
    folder = tmp_path_factory.mktemp("losses")
    lost = [*modes.LOSSES, *modes.NOT_LOST]
    # Good programs run before, between and after the others.
    engines = [engine(folder, "good", "first")]
    for mode in lost:
        engines += [engine(folder, mode, mode), engine(folder, "good", f"after-{mode}")]
    return folder, run(folder, engines)


@pytest.fixture(scope="module")
def findings(campaign) -> "dict[str, list[tuple[str, str]]]":
    """Outcome and sentence of every finding by engine."""
    folder, done = campaign
    assert done.returncode == 3, done.stderr[-3000:]
    lines = (folder / "report" / "records.jsonl").read_text().splitlines()
    records = [sheet for sheet in map(json.loads, lines) if sheet["type"] == "record"]
    return {
        record["engine"]: [(one["outcome"], one["sentence"]) for one in record["findings"]]
        for record in records
    }


def test_an_engine_that_broke_is_what_the_campaign_ends_with(campaign) -> None:
    _, done = campaign
    assert done.returncode == 3, done.stderr[-3000:]
    # A program's own traceback is one line of its error.
    assert not re.search(rb"^Traceback", done.stdout + done.stderr, re.MULTILINE)


@pytest.mark.parametrize(("mode", "says"), modes.LOSSES.items())
def test_a_loss_is_one_error_of_who_caused_it(findings, mode: str, says: str) -> None:
    ((outcome, sentence),) = findings[mode]
    assert outcome == "error"
    assert re.search(says, sentence), sentence


@pytest.mark.parametrize("mode", modes.NOT_LOST)
def test_what_refdem_does_not_need_is_no_loss(findings, mode: str) -> None:
    assert findings[mode] == findings["first"]


@pytest.mark.parametrize("mode", [*modes.LOSSES, *modes.NOT_LOST])
def test_the_next_program_is_judged(findings, mode: str) -> None:
    outcomes = {outcome for outcome, _ in findings["first"]}
    assert "pass" in outcomes
    assert not outcomes & {"fail", "error"}
    assert findings[f"after-{mode}"] == findings["first"]
