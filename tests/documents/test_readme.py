"""The gate of README.md in five minutes works as it stands, for a stranger with an empty folder."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

README = (Path(__file__).parents[2] / "README.md").read_text()


@pytest.fixture
def refdem(tmp_path):
    """`refdem` in a folder with the program and the refdem.toml that README.md shows."""
    section = README.split("## The gate for your own code")[1].split("\n## ")[0]
    blocks = dict(re.findall(r"```(python|toml)\n(.*?)```", section, re.DOTALL))
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
