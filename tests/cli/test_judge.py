"""Trajectories that come back from elsewhere are compared with the baseline beside them."""

import csv
import json
import os
import shutil
import subprocess
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from refdem.gate import baseline
from tests.planning.test_exchange import TOML, run

Done = Callable[..., "subprocess.CompletedProcess[str]"]
WHY = ("--bless", "--why", "it was looked at")
PLACE = "far-baseline.jsonl"


@pytest.fixture(scope="module")
def returned(tmp_path_factory: pytest.TempPathFactory, command_line: Done) -> Path:
    """An export with all of its trajectories, in a folder of its own."""
    above = tmp_path_factory.mktemp("elsewhere")
    (above / "refdem.toml").write_text(TOML)
    words = ["export", "to-run", "harmonic-oscillator", "--engine", "refdem.toml", "--levels", "3"]
    # The second export has the runs that go on from the end of others.
    for _ in range(2):
        assert command_line(*words, cwd=above, env=environment(above)).returncode == 0
        for request in (above / "to-run").glob("*/request.json"):
            run(request.parent)
    return above / "to-run"


def environment(above: Path) -> dict[str, str]:
    """That of this process, with a store of the tests' own."""
    return os.environ | {"REFDEM_STORE": str(above / "store.sqlite")}


@pytest.fixture
def folder(returned: Path, tmp_path: Path) -> Path:
    """A copy of the export."""
    return shutil.copytree(returned, tmp_path / "to-run")


@pytest.fixture
def judge(returned: Path, folder: Path, command_line: Done) -> Done:
    """The command on that copy."""
    called = partial(command_line, cwd=folder.parent, env=environment(returned.parent))
    return partial(called, "judge", "to-run", "--out", "report")


def findings(folder: Path) -> dict[str, dict[str, object]]:
    """What the report says of each check and quantity."""
    lines = (folder.parent / "report" / "records.jsonl").read_text().splitlines()
    records = [document for line in lines if "findings" in (document := json.loads(line))]
    return {f"{f['check']}/{f['quantity']}": f for record in records for f in record["findings"]}


def run_that_goes_on(folder: Path) -> Path:
    """The folder of the reversed run, the only one that the second export wrote."""
    (later,) = (folder / "runs.txt").read_text().split()
    return folder / later


def plant(trajectory: Path, amount: float) -> None:
    """Moves the body along x by an amount [m] at the last sample."""
    rows = list(csv.reader(trajectory.read_text().splitlines()))
    column = rows[0].index("x")
    rows[-1][column] = repr(float(rows[-1][column]) + amount)
    trajectory.write_text("".join(",".join(row) + "\n" for row in rows))


def test_without_a_baseline_truth_alone_judges_and_one_line_says_so(
    judge: Done, folder: Path
) -> None:
    done = judge()
    assert done.returncode == 0, done.stdout
    (line,) = (line for line in done.stdout.splitlines() if "baseline" in line)
    assert line.startswith(f"there is no baseline to-run/{PLACE} yet")
    assert "refdem judge to-run --bless --why" in line
    assert not (folder / PLACE).exists()


def test_after_a_blessing_the_gate_is_open(judge: Done, folder: Path) -> None:
    blessed = judge(*WHY)
    assert blessed.returncode == 0, blessed.stdout
    header, accepted = baseline.read(folder / PLACE, "far")
    assert header.why == "it was looked at"
    assert f"baseline to-run/{PLACE}: {len(accepted)} findings accepted" in blessed.stdout
    again = judge()
    assert again.returncode == 0, again.stdout
    assert "the gate of far is open" in again.stdout.splitlines()
    assert {finding["outcome"] for finding in findings(folder).values()} == {"pass"}


def test_an_error_of_a_tenth_of_its_bound_is_worse(judge: Done, folder: Path) -> None:
    judge(*WHY)
    bound = findings(folder)["reversal/reversed"]["bound"]
    assert isinstance(bound, float)
    plant(run_that_goes_on(folder) / "trajectory.csv", 0.1 * bound)
    done = judge()
    assert done.returncode == 1, done.stdout
    assert "WORSE  harmonic-oscillator/far/leapfrog/reversal/reversed" in done.stdout
    assert "the gate of far is closed" in done.stdout.splitlines()
    found = findings(folder)["reversal/reversed"]
    value = found["value"]
    assert isinstance(value, float)
    assert value < bound
    assert "more than the factor 1.5 allows" in str(found["sentence"])
    # Truth alone lets it pass.
    (folder / PLACE).unlink()
    assert judge().returncode == 0


def test_what_a_removed_trajectory_had_shown_is_named(judge: Done, folder: Path) -> None:
    judge(*WHY)
    later = run_that_goes_on(folder)
    (later / "trajectory.csv").unlink()
    done = judge()
    assert done.returncode == 3, done.stdout
    assert f"{later.name}/trajectory.csv is missing" in done.stdout
    assert "Therefore 1 finding of the baseline could not be made: reversal/reversed" in done.stdout
    assert "the gate of far is closed" in done.stdout.splitlines()


def test_what_trajectories_had_shown_is_lost_where_the_program_refuses_now(
    judge: Done, folder: Path
) -> None:
    judge(*WHY)
    for request in folder.glob("*/request.json"):
        (request.parent / "trajectory.csv").unlink()
        (request.parent / "unsupported.txt").write_text("no springs any more\n")
    done = judge()
    assert done.returncode == 1, done.stdout
    assert "LOST" in done.stdout
    assert "no springs any more" in done.stdout
    assert "the gate of far is closed" in done.stdout.splitlines()


def test_a_finding_that_the_baseline_lacks_is_listed(judge: Done, folder: Path) -> None:
    answer = run_that_goes_on(folder) / "trajectory.csv"
    kept = answer.read_bytes()
    answer.unlink()
    assert judge(*WHY).returncode == 3
    answer.write_bytes(kept)
    done = judge()
    assert done.returncode == 0, done.stdout
    new = "+ harmonic-oscillator/far/leapfrog/reversal/reversed: pass"
    assert [line for line in done.stdout.splitlines() if line.startswith("+")] == [
        f"{new}, which the baseline does not contain"
    ]
    assert new in judge(*WHY).stdout.splitlines()


def test_a_reason_without_a_blessing_is_refused(judge: Done, folder: Path) -> None:
    done = judge("--why", "it was looked at")
    assert done.returncode == 2
    assert "got --why without --bless" in done.stderr
    assert not (folder / PLACE).exists()


def test_a_blessing_says_what_it_leaves_out_where_a_run_is_missing(
    judge: Done, folder: Path
) -> None:
    words = "what their runs would have shown is not in the baseline"
    assert words not in judge(*WHY).stdout
    next(folder.glob("*/trajectory.csv")).unlink()
    assert words in judge(*WHY).stdout


def test_a_blessing_needs_a_reason(judge: Done, folder: Path) -> None:
    done = judge("--bless")
    assert done.returncode == 2
    assert "--bless requires --why" in done.stderr
    assert not (folder / PLACE).exists()


def test_a_blessing_writes_through_no_link(judge: Done, folder: Path) -> None:
    outside = folder.parent / "outside.txt"
    outside.write_text("mine")
    (folder / PLACE).symlink_to(outside)
    done = judge(*WHY)
    assert done.returncode == 2
    assert f"{PLACE} is a link" in done.stderr or "cannot be read" in done.stderr
    assert outside.read_text() == "mine"


def test_a_baseline_that_cannot_be_read_is_refused_before_anything_is_judged(
    judge: Done, folder: Path
) -> None:
    judge(*WHY)
    text = (folder / PLACE).read_bytes()
    (folder / PLACE).write_bytes(text[: len(text) // 2])
    done = judge()
    assert (done.returncode, done.stdout) == (2, "")
    assert f"to-run/{PLACE}" in done.stderr
