"""Standard streams that are closed or full, folders that are gone or whose names are no text."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).parents[1] / "foreign" / "hostile" / "program.py"
TOML = """
[engine]
name = "small"
command = ["{python}", "{program}", "{{request}}", "{{trajectory}}", "{{events}}"]
supports = ["spring", "dimension:1"]
timeout = 300
[[engine.methods]]
name = "good"
order = 2
[gate]
cases = ["harmonic-oscillator"]
levels = 3
"""
REFDEM = "{python} -c 'from refdem.cli import main; main()' {words}"
UNACCEPTED = 1
"""Exit status of a gate without a baseline."""
PATIENCE = 600.0


def done(folder: Path, words: str, before: str = "") -> "subprocess.CompletedProcess[str]":
    """A command line in a shell, after something that the shell does."""
    text = REFDEM.format(python=sys.executable, words=words)
    environment = os.environ | {"REFDEM_STORE": str(folder / "store.sqlite")}
    return subprocess.run(
        ["sh", "-c", f"{before} {text}"],
        cwd=folder,
        env=environment,
        capture_output=True,
        encoding="utf-8",
        errors="replace",
        timeout=PATIENCE,
        check=False,
    )


@pytest.fixture
def toml(tmp_path: Path) -> Path:
    """The description of a program that does what it should."""
    path = tmp_path / "refdem.toml"
    path.write_text(TOML.format(python=sys.executable, program=PROGRAM))
    return path


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_a_gate_whose_streams_are_closed_judges_as_ever(
    tmp_path: Path, toml: Path, closed: str
) -> None:
    found = done(tmp_path, f"gate {toml} --jobs 1 --markdown told.md {closed}")
    assert found.returncode == UNACCEPTED, found.stdout + found.stderr
    told = (tmp_path / "told.md").read_text()
    assert "is open" in told, told
    assert list(tmp_path.glob("failed-runs/*")) == []


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_standard_error_that_is_full_costs_what_it_would_say(
    tmp_path: Path, toml: Path, unbuffered: str
) -> None:
    before = f"export PYTHONUNBUFFERED={unbuffered};"
    found = done(tmp_path, f"gate {toml} --jobs 1 2>/dev/full", before)
    assert found.returncode == UNACCEPTED
    assert "pass" in found.stdout


@pytest.mark.parametrize("words", ["gate", "smoke refdem.toml"])
def test_a_folder_that_is_gone_is_bad_input(tmp_path: Path, words: str) -> None:
    gone = tmp_path / "gone"
    found = done(tmp_path, words, f"mkdir {gone}; cd {gone}; rmdir {gone};")
    assert found.returncode == 2, found.stderr
    assert found.stderr.count("\n") == 1, found.stderr


def test_a_file_without_an_end_is_bad_input(tmp_path: Path) -> None:
    found = done(tmp_path, "gate /dev/zero", "ulimit -v 8000000;")
    assert found.returncode == 2, found.stderr
    assert "/dev/zero: a pipe or a device, not a file" in found.stderr


def test_a_folder_whose_name_is_no_text_is_a_folder(tmp_path: Path, toml: Path) -> None:
    name = tmp_path / os.fsdecode(b"b\xff\xe9")
    name.mkdir()
    (name / "refdem.toml").write_text(toml.read_text())
    (name / PROGRAM.name).write_bytes(PROGRAM.read_bytes())
    gate = "gate b*/refdem.toml --jobs 1 --markdown $(echo b*)/told.md --out $(echo b*)/report"
    run = "run harmonic-oscillator --engine b*/refdem.toml --jobs 1 --out $(echo b*)/report"
    for words, status in ((gate, UNACCEPTED), (run, 0)):
        found = done(tmp_path, words)
        assert found.returncode == status, found.stderr
    assert "is open" in (name / "told.md").read_text()
