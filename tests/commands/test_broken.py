"""What nobody caught is never a verdict, and a place that cannot be written is bad input.

Commands run in another folder than that of the sources, whose kernels need not be built.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest


def test_an_exception_that_nobody_caught_has_its_own_status_and_says_where_its_details_are(
    tmp_path: Path,
) -> None:
    code = (
        "import refdem.cli.list as it, refdem.cli; from refdem.core import discovery\n"
        "def broken(*_): raise KeyError('lost\\x1b[31m')\n"
        "discovery.names = broken\n"
        "refdem.cli.main()"
    )
    environment = os.environ | {"REFDEM_STORE": str(tmp_path / "store.sqlite")}
    done = subprocess.run(
        [sys.executable, "-c", code, "list", "cases"],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 70
    assert done.stderr.count("\n") == 1
    assert "no verdict was reached" in done.stderr
    assert "\x1b" not in done.stderr
    assert "KeyError" in (tmp_path / "refdem-broke.txt").read_text()


@pytest.mark.parametrize(
    "arguments", [["list", "cases"], ["schema", "request"], ["truth", "pendulum"], ["--help"]]
)
def test_a_full_disk_under_standard_output_is_bad_input(arguments: list[str]) -> None:
    command = [sys.executable, "-c", "from refdem.cli import main; main()", *arguments]
    with open("/dev/full", "wb") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert "No space left on device" in done.stderr


def test_a_closed_standard_error_changes_no_verdict(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-c",
        "from refdem.cli import main; main()",
        "run",
        "harmonic-oscillator",
        "--engine",
        "reference",
    ]
    environment = os.environ | {"REFDEM_STORE": str(tmp_path / "store.sqlite")}
    closed = ["sh", "-c", 'exec "$@" 2>&-', "sh", *command, "--out", str(tmp_path / "out")]
    done = subprocess.run(closed, cwd=tmp_path, env=environment, capture_output=True, check=False)
    assert done.returncode == 0, done.stdout


def test_without_a_home_folder_the_store_is_elsewhere_or_nowhere(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-c",
        "from refdem.cli import main; main()",
        "run",
        "harmonic-oscillator",
        "--engine",
        "reference",
    ]
    environment = {
        name: value
        for name, value in os.environ.items()
        if name not in ("XDG_CACHE_HOME", "REFDEM_STORE")
    }
    environment |= {"HOME": "/proc/nowhere"}
    there = [*command, "--out", str(tmp_path / "out")]
    done = subprocess.run(
        there, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "cannot be used" in done.stderr
