"""The example that reads certified values from C is compiled and run, and sees a value that is not
the pendulum's.
"""

import subprocess
from pathlib import Path

import pytest

from refdem.truth.certified.reader import default_folder

SOURCE = Path(__file__).parents[2] / "examples" / "certified.c"


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    built = tmp_path_factory.mktemp("certified") / "certified"
    subprocess.run(
        [
            "cc",
            "-std=c11",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-O2",
            str(SOURCE),
            "-lm",
            "-o",
            str(built),
        ],
        check=True,
    )
    return built


def test_it_finds_the_periods_to_the_last_bits(program: Path) -> None:
    done = subprocess.run(
        [program, default_folder() / "pendulum.jsonl"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "theta0 = 3      period 5.1574096338429728710596" in done.stdout
    assert done.stdout.startswith("theta0 = 1 ")


def test_it_sees_another_period(program: Path, tmp_path: Path) -> None:
    text = (default_folder() / "pendulum.jsonl").read_text()
    other = tmp_path / "pendulum.jsonl"
    other.write_text(text.replace("0x1.11c654bc009e8p+1", "0x1.11c654bc00a08p+1"))
    assert subprocess.run([program, other], capture_output=True, check=False).returncode == 1
    other.write_text("")
    assert subprocess.run([program, other], capture_output=True, check=False).returncode == 1
