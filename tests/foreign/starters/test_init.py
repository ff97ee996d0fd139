"""refdem init: every starter compiles without warnings, is judged right, overwrites nothing."""

import json
import os
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from refdem.cli.starter import STARTERS, name_of, written
from refdem.engines.external import load
from refdem.errors import UsageError

PROBES = (
    "fall in space",
    "spring: position",
    "spring between points: position",
    "wobble about z: omega_body",
    "tumble: attitude",
    "knock in space: velocity",
    "surrounded: position",
)
"""Probes of forces, rotation and contact that a starter passes."""
GATED = ["harmonic-oscillator", "free-rigid-body", "two-spheres", "two-spheres"]
"""The cases of a starter's gate, the last with damping and friction."""
Command = Callable[..., "subprocess.CompletedProcess[str]"]
STRICT = {
    "CFLAGS": "-O1 -Wall -Wextra -Wconversion -Werror",
    "CXXFLAGS": "-O1 -Wall -Wextra -Werror",
    "FFLAGS": "-O1 -Wall -Wextra -Werror",
    "RUSTFLAGS": "-O -D warnings",
}


@pytest.fixture
def refdem(tmp_path: Path, command_line: Command) -> Command:
    """The command line, with a store of the test's own."""
    environment = os.environ | {"REFDEM_STORE": str(tmp_path / "store.sqlite")}

    def run(*words: str, cwd: Path) -> "subprocess.CompletedProcess[str]":
        return command_line(*words, env=environment, cwd=cwd)

    return run


def working(name: str) -> str:
    """The first program of a name on the path that starts: one that chooses a version by a file in
    the home folder does not start in an empty one.
    """
    for folder in os.environ["PATH"].split(os.pathsep):
        found = shutil.which(name, path=folder)
        if found and subprocess.run([found, "--version"], capture_output=True).returncode == 0:
            return found
    raise RuntimeError(
        f"no {name} that starts is on the path; ci/packaging/system-packages installs one"
    )


def built(folder: Path, language: str) -> None:
    """Compiles a starter, where its language needs it."""
    compiler = STARTERS[language].compiler
    if compiler:
        words = [f"{name}={flags}" for name, flags in STRICT.items()]
        words.append(f"RUSTC={working('rustc')}")
        done = subprocess.run(
            ["make", "-C", str(folder), *words], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("language", STARTERS)
def test_a_starter_passes_its_gate_as_it_stands(
    tmp_path: Path, refdem: Command, language: str
) -> None:
    folder = tmp_path / "my dem"
    done = refdem("init", str(folder), "--language", language, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert load(folder / "refdem.toml").name == "my-dem"
    built(folder, language)
    smoke = refdem("smoke", "refdem.toml", cwd=folder)
    assert smoke.returncode == 0, smoke.stdout
    for probe in PROBES:
        assert re.search(f"(?m)^pass +{probe}", smoke.stdout), smoke.stdout
    bless = refdem("gate", "--bless", "--why", "first baseline", "--out", "out", cwd=folder)
    assert bless.returncode == 0, bless.stdout + bless.stderr
    records = (folder / "out" / "records.jsonl").read_text().splitlines()
    sheets = [sheet for sheet in map(json.loads, records) if sheet["type"] == "record"]
    assert [sheet["case"] for sheet in sheets] == GATED
    outcomes = [finding["outcome"] for sheet in sheets for finding in sheet["findings"]]
    # Steps and forces, rotation, and each law that the method keeps, in each of the scenes.
    assert len(outcomes) > 100
    assert set(outcomes) == {"pass"}


@pytest.mark.parametrize(
    ("right", "wrong", "check"),
    [
        ("-limit / length(slip)", "limit / length(slip)", "two-spheres.*/energy/"),
        ("arm_b, torque)", "-arm_b, torque)", "two-spheres.*/angular-momentum/total"),
        ("share * in_body[i]", "-share * in_body[i]", "free-rigid-body.*/error/attitude"),
    ],
    ids=["friction drives", "torque of one sphere", "turns backwards"],
)
def test_a_mistake_in_the_mechanics_of_a_starter_closes_its_gate(
    tmp_path: Path, refdem: Command, right: str, wrong: str, check: str
) -> None:
    written("c", "mydem", tmp_path)
    driver = tmp_path / "driver.c"
    assert driver.read_text().count(right) == 1
    driver.write_text(driver.read_text().replace(right, wrong))
    built(tmp_path, "c")
    gate = refdem("gate", cwd=tmp_path)
    assert gate.returncode == 1
    assert re.search(f"(?m)^FAIL +{check}", gate.stdout), gate.stdout


@pytest.mark.parametrize("language", STARTERS)
def test_a_starter_refuses_and_makes_one_run_by_hand(
    tmp_path: Path, refdem: Command, language: str
) -> None:
    written(language, "mydem", tmp_path)
    built(tmp_path, language)
    command = list(STARTERS[language].command)
    asked = "--text"
    if not STARTERS[language].compiler:
        asked = "--json"
    for case, setting, status, says in (
        ("harmonic-oscillator", "mass=2", 0, ""),
        ("two-spheres", "friction=1/2", 0, ""),
        ("two-spheres", "cutoff=zero_force", 77, "another law of contact"),
        ("coulomb-oscillator", "mass=2", 77, "element"),
    ):
        request = refdem("request", case, "--set", setting, asked, cwd=tmp_path)
        assert request.returncode == 0, request.stderr
        (tmp_path / "request").write_text(request.stdout)
        done = subprocess.run(
            [*command, "request", "trajectory.csv"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == status, done.stderr
        assert says in done.stderr
    done = subprocess.run(command, cwd=tmp_path, input="", capture_output=True, text=True)
    assert (done.returncode, json.loads(done.stdout)) == (0, {"ready": True})


def test_a_file_that_is_there_is_not_overwritten(tmp_path: Path, refdem: Command) -> None:
    (tmp_path / "driver.py").write_text("mine")
    done = refdem("init", cwd=tmp_path)
    assert done.returncode == 2
    assert "driver.py exists already; choose another folder" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["driver.py"]


@pytest.mark.parametrize(
    ("language", "name", "says"),
    [
        ("pyton", "mydem", "did you mean 'python'"),
        ("c", "my dem", "'my dem' cannot be used; expected letters, digits"),
        ("c", '"]\n', "cannot be used"),
    ],
)
def test_a_language_and_a_name_that_there_are_not_are_refused(
    tmp_path: Path, language: str, name: str, says: str
) -> None:
    with pytest.raises(UsageError, match=says):
        written(language, name, tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("folder", "name"), [("a b", "a-b"), ("...", "mydem"), ("x" * 90, "x" * 64), ("dém", "d-m")]
)
def test_a_folder_gives_its_name(folder: str, name: str) -> None:
    assert name_of(Path("/tmp") / folder) == name


def test_the_workflow_is_yaml_whose_steps_build_what_is_compiled(tmp_path: Path) -> None:
    for language, starter in STARTERS.items():
        written(language, "mydem", tmp_path / language)
        text = (tmp_path / language / ".github" / "workflows" / "refdem-gate.yml").read_text()
        steps = yaml.safe_load(text)["jobs"]["gate"]["steps"]
        assert ("make" in [step["run"] for step in steps]) == bool(starter.compiler)
