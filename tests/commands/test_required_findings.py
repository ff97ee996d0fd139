"""A campaign holds the list of what it must decide: the command writes it, and what vanishes from
it fails.
"""

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., "subprocess.CompletedProcess[str]"]
MINE = """
levels = 3
most_steps = 2e3
[[case]]
id = "harmonic-oscillator"
set = { samples = "8" }
[[case]]
id = "viscous-oscillator"
set = { duration = "1", samples = "8" }
"""


@pytest.fixture
def refdem(tmp_path: Path, command_line: Run) -> Run:
    (tmp_path / "mine.toml").write_text(MINE)
    environment = os.environ | {"REFDEM_STORE": str(tmp_path / "store.sqlite")}

    def called(*arguments: str) -> "subprocess.CompletedProcess[str]":
        return command_line(
            "run",
            *arguments,
            "--campaign",
            "mine.toml",
            "--engine",
            "reference",
            cwd=tmp_path,
            env=environment,
        )

    return called


def test_what_a_campaign_decided_is_written_down_and_must_be_decided_again(
    refdem: Run, tmp_path: Path
) -> None:
    first = refdem("--bless")
    assert first.returncode == 0, first.stdout + first.stderr
    assert "+ harmonic-oscillator[samples=8]/reference/velocity-verlet/error/x" in first.stdout
    kept = tmp_path / "mine" / "reference.txt"
    text = kept.read_text()
    assert refdem().returncode == 0

    # A finding that is not made any more is absent; one of another method is a whole record that is
    # gone.
    before, section, after = text.partition("harmonic-oscillator[samples=8]/velocity-verlet\n")
    more = after.replace("  error: ", "  error: another, ", 1)
    kept.write_text(
        before + section + more + "viscous-oscillator[duration=1 samples=8]/gone\n  error: x\n"
    )
    done = refdem()
    assert done.returncode == 1
    assert done.stdout.count("ABSENT") == 2
    assert (
        "The list of campaign mine contains this finding, and this run did not produce it"
        in done.stdout
    )

    # Of a campaign of which only some cases were named, their share alone is required.
    assert refdem("viscous-oscillator").stdout.count("ABSENT") == 1
    assert refdem("harmonic-oscillator").stdout.count("ABSENT") == 1
    assert refdem("--method", "velocity-verlet").stdout.count("ABSENT") == 1
    assert refdem("--method", "velocity-verlet", "--steps-per-tau", "8").returncode == 0

    again = refdem("--bless")
    assert "- viscous-oscillator[duration=1 samples=8]/reference/gone/error/x" in again.stdout
    assert kept.read_text() == text


def test_a_broken_list_is_said_so(refdem: Run, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "reference.txt").write_text("  order: x\n")
    done = refdem()
    assert done.returncode == 2
    assert "reference.txt:1" in done.stderr
