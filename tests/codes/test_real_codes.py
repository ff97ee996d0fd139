"""Released DEM codes under the gate: open against the committed baseline, closed when their driver has a fault."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CODES = ROOT / "validation/codes"
INSTALLED = ("lammps", "lammps-debian")
"""What `make codes` and ci/system-packages install; the tests fail where one is not there."""


def gated(toml: Path, home: Path) -> "subprocess.CompletedProcess[str]":
    """The gate's exit status and what it says."""
    command = [sys.executable, "-c", "from refdem.cli import main; main()", "gate", str(toml)]
    environment = os.environ | {"REFDEM_STORE": str(home / "store.sqlite")}
    return subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment, cwd=home)


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """One store of truths for all gates."""
    return tmp_path_factory.mktemp("codes")


@pytest.mark.parametrize("code", INSTALLED)
def test_the_gate_of_a_released_code_is_open(code, home):
    done = gated(CODES / code / "refdem.toml", home)
    assert done.returncode == 0, done.stdout + done.stderr


FAULTS = {
    "a contact 1 % too stiff": (
        "lammps",
        "two-spheres",
        "order/state",
        "elements.py",
        "format(**c,",
        "format(**c | {'stiffness': 1.01 * c['stiffness']},",
    ),
    "a step 1 % too short": (
        "lammps-debian",
        "harmonic-oscillator[gravity=0.5]",
        "error/x",
        "driver.py",
        "timestep {step!r}",
        "timestep {0.99 * step!r}",
    ),
    "omega taken for angular momentum": (
        "lammps",
        "free-rigid-body",
        "error/omega_body.x",
        "driver.py",
        "sum(a * w for",
        "sum((a != 0) * w for",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_in_the_driver_closes_the_gate_and_is_named(name, home, tmp_path):
    code, case, seen, file, text, other = FAULTS[name]
    shutil.copytree(CODES, tmp_path / "codes")
    source, toml = tmp_path / "codes/lammps" / file, tmp_path / "codes" / code / "refdem.toml"
    assert source.read_text().count(text) == 1
    source.write_text(source.read_text().replace(text, other))
    head = toml.read_text().replace("../../../", f"{ROOT}/").partition("[gate]")[0]
    toml.write_text(f"{head}[gate]\ncases = {json.dumps([case])}\n")
    accepted = toml.with_name("refdem-baseline.jsonl")
    first, *rest = accepted.read_text().splitlines()
    accepted.write_text("\n".join([first, *(line for line in rest if json.loads(line)["id"].startswith(f"{case}/"))]) + "\n")
    done = gated(toml, home)
    assert done.returncode == 1, done.stdout + done.stderr
    assert any(line.startswith("FAIL ") and line.endswith(seen) for line in done.stdout.splitlines()), done.stdout
