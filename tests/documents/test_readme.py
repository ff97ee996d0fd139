"""The gate of README.md in five minutes works as it stands, for a stranger with an empty folder."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

README = (Path(__file__).parents[2] / "README.md").read_text()
SECTION = README.split("## The gate for your own code")[1].split("\n## ")[0]


@pytest.fixture
def refdem(tmp_path):
    """`refdem` in a folder with the program and the refdem.toml that README.md shows."""
    blocks = dict(re.findall(r"```(python|toml)\n(.*?)```", SECTION, re.DOTALL))
    (tmp_path / "springs.py").write_text(blocks["python"])
    (tmp_path / "refdem.toml").write_text(blocks["toml"])

    def run(*arguments):
        command = [sys.executable, "-c", "from refdem.cli import main; main()", *arguments]
        environment = os.environ | {
            "REFDEM_STORE": str(tmp_path / "store.sqlite"),
            "GITHUB_ACTIONS": "false",
        }
        return subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300
        )

    return run


def test_the_gate_of_the_readme_opens_and_closes_as_it_says(refdem, tmp_path):
    assert refdem("smoke", "refdem.toml").returncode == 0
    first = refdem("gate")
    assert first.returncode == 1
    assert "16 pass" in first.stdout
    assert refdem("gate", "--bless", "--why", "first baseline").returncode == 0
    assert refdem("gate").stdout.splitlines()[-1] == "the gate of springs is open"
    program = (tmp_path / "springs.py").read_text()
    (tmp_path / "springs.py").write_text(program.replace("h / 2)", "h)"))
    closed = refdem("gate")
    assert closed.returncode == 1
    assert closed.stdout.splitlines()[-1] == "the gate of springs is closed"
    for said in ("/error/x", "/energy/", "/order/state"):
        assert said in closed.stdout


def test_a_clock_that_adds_up_its_steps_is_caught_first_and_told_to_count_them(refdem, tmp_path):
    program = (tmp_path / "springs.py").read_text()
    loop = "for _ in range(stride if n > 0 else 0):\n"
    assert program.count(loop) == 1
    clock = (
        "t = start if n == 0 else t\n        while t < float(asked[f'times.{n}']):\n            t"
        " += h\n"
    )
    (tmp_path / "springs.py").write_text(program.replace(loop, clock))
    told = refdem("smoke", "refdem.toml")
    assert told.returncode == 1
    first, *others = told.stdout.splitlines()
    assert "count `stride` steps from each sample to the next and never compare times" in first
    assert not [line for line in others if not line.startswith(("pass", "unsupported"))]


def test_the_driver_with_rotation_and_friction_opens_its_gate_as_the_readme_says(refdem, tmp_path):
    assert "$ refdem init dem --language cpp\n$ cd dem && make\n" in SECTION
    assert refdem("init", "dem", "--language", "cpp").returncode == 0
    subprocess.run(["make"], cwd=tmp_path / "dem", check=True)
    smoke = refdem("smoke", "dem/refdem.toml")
    assert smoke.returncode == 0
    for probe in ("tumble: attitude", "tumble: omega", "knock in space: velocity"):
        assert re.search(f"(?m)^pass +{probe}", smoke.stdout)
    (shown,) = re.findall(r"# (\d+) pass, the gate of dem is open", SECTION)
    bless = ("gate", "dem/refdem.toml", "--bless", "--why", "first baseline")
    opened = refdem(*bless).stdout.splitlines()
    assert f"{shown} pass" in opened
    assert opened[-1] == "the gate of dem is open"
