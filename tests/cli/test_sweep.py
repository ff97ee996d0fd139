"""`refdem sweep`: the table of a study, what it keeps, and its exit status."""

import csv
import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from refdem.cli import progress
from refdem.cli.app import app
from refdem.errors import ClusterError, UsageError
from refdem.execution import cluster

SHORT = ("sweep", "pendulum[duration=2 samples=8]", "--engine", "reference", "--jobs", "1")


@pytest.fixture(autouse=True)
def _own_store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "store.sqlite"))
    monkeypatch.chdir(tmp_path)


def called(*arguments: str) -> Any:
    """The result of the command; raises what it raises."""
    done = CliRunner().invoke(app, list(arguments), catch_exceptions=False)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done


def test_every_setting_and_step_has_its_error_cost_and_verdict(tmp_path: Path) -> None:
    asked = ("--set", "theta0=0.5:1:0.5", "--method", "rattle", "--levels", "2")
    done = called(*SHORT, *asked, "--out", "study")
    assert done.exit_code == 0
    head, *lines = done.stdout.splitlines()
    assert head.split()[:5] == ["theta0", "engine", "method", "step", "error"]
    assert [line.split()[0] for line in lines[:4]] == ["0.5", "0.5", "1", "1"]
    assert lines[4] == "4 runs made, 0 read from the store"
    points = json.loads((tmp_path / "study/sweep.json").read_text())["points"]
    for coarse, fine in (points[:2], points[2:]):
        assert coarse["setting"] == fine["setting"]
        assert coarse["level"] == 2 * fine["level"]
        # RATTLE is of order 2.
        assert 3 < coarse["error"] / fine["error"] < 5
        assert coarse["cost"] is not None
        assert coarse["verdict"] == "pass"
        assert coarse["error"] <= coarse["bound"]
    rows = list(csv.DictReader((tmp_path / "study/sweep.csv").read_text().splitlines()))
    assert [float(row["error"]) for row in rows] == [point["error"] for point in points]
    assert (tmp_path / "study/sweep.md").read_text().count("\n| 0.5 |") == 2


def test_a_sweep_with_one_more_value_runs_only_that() -> None:
    method = ("--method", "rattle", "--levels", "2")
    called(*SHORT, *method, "--set", "theta0=0.5,1")
    done = called(*SHORT, *method, "--set", "theta0=0.5,1,2")
    assert "2 runs made, 4 read from the store" in done.stdout


def test_a_sweep_that_was_interrupted_goes_on_where_it_was(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = (*SHORT, "--method", "rattle", "--levels", "2", "--set", "theta0=0.5,1,2")

    def interrupted(self: object, stage: str, done: int, total: int) -> None:
        if stage == "runs" and done == 3:
            raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(progress.Progress, "__call__", interrupted)
        assert CliRunner().invoke(app, asked).exit_code != 0
    assert "3 runs made, 3 read from the store" in called(*asked).stdout


def test_what_an_engine_does_not_support_has_its_reason_and_is_exit_status_2() -> None:
    asked = ("sweep", "heavy-top", "--engine", "pymunk", "--jobs", "1", "--set", "spin=1,2")
    done = called(*asked, "--json")
    assert done.exit_code == 2
    answer = json.loads(done.stdout)
    assert [point["verdict"] for point in answer["points"]] == ["unsupported"] * 2
    assert answer["points"][0]["error"] is None
    text = called(*asked).stdout
    assert "unsupported, pymunk/semi-implicit-euler: The engine does not support " in text
    assert "(2 of 2 rows)" in text


def test_two_first_steps_are_refused() -> None:
    with pytest.raises(UsageError, match="expected at most one of them"):
        called(*SHORT, "--set", "theta0=1", "--step", "0.1", "--steps-per-tau", "3")


def test_a_scheduler_makes_the_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "CONNECT", 0.2)
    with pytest.raises(ClusterError, match="no scheduler answers at 'nowhere'"):
        called(*SHORT, "--set", "theta0=1", "--scheduler", "nowhere")


def test_an_empty_scheduler_is_refused() -> None:
    for empty in ("", " "):
        with pytest.raises(UsageError, match="--scheduler is empty; expected the address"):
            called(*SHORT, "--set", "theta0=1", "--scheduler", empty)


def test_two_parameters_have_a_heat_map_and_one_has_none(tmp_path: Path) -> None:
    asked = ("--method", "rattle", "--levels", "1", "--set", "theta0=0.5,1", "--out")
    one = called(*SHORT, *asked, "one")
    assert "heat map" not in one.stdout
    assert not (tmp_path / "one/sweep.html").exists()
    two = called(*SHORT, *asked, "two", "--set", "length=1,2")
    assert two.stdout.splitlines()[-1] == f"heat map: {Path('two/sweep.html')}"
    assert "(sweep.svg)" in (tmp_path / "two/sweep.md").read_text()
    assert "reference rattle" in (tmp_path / "two/sweep.html").read_text()


def test_the_page_of_an_earlier_sweep_does_not_stay_beside_another(tmp_path: Path) -> None:
    asked = ("--method", "rattle", "--levels", "1", "--set", "theta0=0.5,1", "--out", "study")
    called(*SHORT, *asked, "--set", "length=1,2")
    assert {"sweep.html", "sweep.svg"} < {path.name for path in (tmp_path / "study").iterdir()}
    called(*SHORT, *asked)
    left = {path.name for path in (tmp_path / "study").iterdir() if path.is_file()}
    assert left == {"sweep.csv", "sweep.json", "sweep.md"}
