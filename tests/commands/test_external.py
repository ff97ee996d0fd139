"""The command line with programs: schemas, export and judge, and what goes wrong in one clear
sentence.
"""

import json
import os
from pathlib import Path

import pytest

TOML = """
[engine]
name = "far"
command = ["./far", "{request}", "{trajectory}"]
supports = ["spring"]
[[engine.methods]]
name = "leapfrog"
order = 2
"""


@pytest.fixture
def refdem(tmp_path, command_line):
    """The command line in a folder of its own, with a refdem.toml in it."""
    (tmp_path / "refdem.toml").write_text(TOML)

    def called(*arguments):
        return command_line(
            *arguments,
            cwd=tmp_path,
            env=os.environ | {"REFDEM_STORE": str(tmp_path / "store.sqlite")},
        )

    return called


@pytest.mark.parametrize(
    ("what", "shows"),
    [
        ("request", "times"),
        ("request", "hollow"),
        ("trajectory", "qw"),
        ("solids", "xy"),
        ("records", "findings"),
        ("scene", "bodies"),
        ("toml", "answers"),
    ],
)
def test_a_schema_is_json_that_names_the_fields(refdem, what, shows):
    done = refdem("schema", what)
    assert done.returncode == 0, done.stderr
    assert f'"{shows}"' in done.stdout
    assert json.loads(done.stdout)


def test_the_schema_of_trajectories_has_every_column_that_is_read():
    from refdem.cli.schema import trajectory
    from refdem.core.trajectory import CHANNELS
    from refdem.core.trajectory_csv import COLUMNS

    row = trajectory()["items"]
    assert list(row["properties"])[: len(COLUMNS)] == list(COLUMNS)
    assert set(row["properties"]) == {*COLUMNS, *CHANNELS}


def test_export_writes_requests_and_judge_misses_what_has_not_come_back(refdem, tmp_path):
    done = refdem("export", "to-run", "harmonic-oscillator")
    assert done.returncode == 0, done.stderr
    names = (tmp_path / "to-run" / "runs.txt").read_text().split()
    assert f"{len(names)} runs to make" in done.stdout
    assert "./far '{request}' '{trajectory}'" in done.stdout
    assert all((tmp_path / "to-run" / name / "request.txt").is_file() for name in names)
    judged = refdem("judge", "to-run")
    assert judged.returncode == 3
    assert "trajectory.csv is missing" in judged.stdout
    assert (tmp_path / "refdem-report" / "index.html").is_file()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["judge", "nowhere"], "expected a folder that `refdem export` wrote"),
        (["export", "x", "harmonic-oscilator"], "did you mean 'harmonic-oscillator'"),
        (["export", "x", "--engine", "nowhere.toml"], "nowhere.toml: No such file"),
        (["export", "/proc/x", "harmonic-oscillator"], "cannot be written"),
        (
            ["run", "harmonic-oscillator", "--engine", "nowhere/refdem.toml"],
            "expected a refdem.toml",
        ),
        (
            ["run", "harmonic-oscillator", "--engine", "refdem.toml"],
            "./far does not exist or is not executable",
        ),
        (["smoke", "refdem.toml"], "./far does not exist or is not executable"),
        (["schema", "everything"], "expected trajectory"),
    ],
)
def test_bad_input_is_one_clear_sentence(refdem, arguments, says):
    done = refdem(*arguments)
    assert done.returncode == 2, done.stdout + done.stderr
    assert says in done.stderr
    assert "Traceback" not in done.stderr


def test_export_without_a_case_takes_those_of_the_gate(refdem, tmp_path: Path):
    (tmp_path / "refdem.toml").write_text(
        TOML + '[gate]\ncases = ["harmonic-oscillator[x0=2]"]\nlevels = 3\n'
    )
    assert refdem("export", "to-run").returncode == 0
    manifest = json.loads((tmp_path / "to-run" / "manifest.json").read_text())
    assert manifest["case"] == [{"id": "harmonic-oscillator", "set": {"x0": "2"}}]
    assert manifest["levels"] == 3
