"""A kernel's source is part of the fingerprint: touched and rebuilt, what it affects runs again,
and a fault in it is found.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CASE = ("intermediate-axis[duration=60]", "--engine", "rebound", "--engine", "reference")


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the tracked tree with kernels built in place."""
    place = tmp_path_factory.mktemp("tree")
    listed = subprocess.run(
        ["git", "ls-files", "refdem", "validation", "ci", "meson.build"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    for name in listed.stdout.split():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, place / name)
    build(place)
    return place


def build(place):
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    }
    subprocess.run(
        [str(place / "ci" / "develop" / "build-in-place"), sys.executable],
        env=environment,
        check=True,
        capture_output=True,
    )


def run(place):
    environment = os.environ | {
        "PYTHONPATH": str(place),
        "REFDEM_STORE": str(place / "store.sqlite"),
    }
    command = [
        sys.executable,
        "-P",
        "-c",
        "from refdem.cli import main; main()",
        "run",
        *CASE,
        "--out",
        str(place / "report"),
    ]
    done = subprocess.run(
        command, cwd=place, env=environment, capture_output=True, text=True, timeout=300
    )
    made = re.search(r"(\d+) runs made, (\d+) read", done.stdout)
    assert made, done.stdout + done.stderr
    return done, int(made[1]), int(made[2])


def test_a_gyroscopic_term_lost_in_a_kernel_is_run_again_and_found(tree):
    done, made, read = run(tree)
    assert done.returncode == 0, done.stdout
    assert read == 0
    source = tree / "refdem" / "kernels" / "rebound_forces.c"
    sound = source.read_text()
    assert sound.count("(j[1] - j[2]) * w[1] * w[2] / j[0]") == 1
    source.write_text(
        sound.replace("(j[1] - j[2]) * w[1] * w[2] / j[0]", "0.0 * w[1] * w[2] / j[0]")
    )
    build(tree)
    done, again, kept = run(tree)
    assert done.returncode == 1
    assert re.search(
        r"FAIL +intermediate-axis.*/rebound/bs/(error/omega_body|flips|angular-momentum)",
        done.stdout,
    ), done.stdout
    assert 0 < again < made
    assert kept > 0
    assert not re.search(r"FAIL .*/reference/", done.stdout)
