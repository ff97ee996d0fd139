"""Where a command writes is looked at before its work begins; and two of them may write one
folder.
"""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

REFDEM = [sys.executable, "-c", "from refdem.cli import main; main()"]
TOML = """
[engine]
name = "sleeper"
command = ["{python}", "program.py", "{{request}}", "{{trajectory}}"]
supports = ["spring"]
[[engine.methods]]
name = "sleeps"
order = 2
[gate]
cases = ["harmonic-oscillator"]
"""
WRITING = {
    "run": ["run", "harmonic-oscillator", "--engine", "refdem.toml", "--out"],
    "gate": ["gate", "--out"],
    "gate --junit": ["gate", "--junit"],
    "gate --sarif": ["gate", "--sarif"],
    "gate --markdown": ["gate", "--markdown"],
    "judge": ["judge", "exported", "--out"],
    "stress": ["stress", "two-spheres", "--engine", "reference", "--out"],
    "bench": ["bench", "pendulum", "--engine", "reference", "--out"],
    "gallery": ["gallery", "1.15", "--out"],
    "manual": ["manual"],
    "export": ["export", "--engine", "refdem.toml"],
}
"""Every command that writes, up to the place."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A program that tells when it is run, and places where nothing can be written."""
    (tmp_path / "program.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w').close()")
    (tmp_path / "refdem.toml").write_text(TOML.format(python=sys.executable))
    (tmp_path / "file").write_text("mine")
    (tmp_path / "loop").symlink_to("loop")
    return tmp_path


Done = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def done(folder: Path, command_line: Done) -> Done:
    """A command there, in this process."""
    environment = os.environ | {"REFDEM_STORE": str(folder / "store.sqlite")}
    return partial(command_line, cwd=folder, env=environment)


@pytest.mark.parametrize("place", ["file/there", "loop/there", "/dev/full/there", "/proc/there"])
@pytest.mark.parametrize("command", WRITING)
def test_a_place_that_cannot_be_written_is_said_before_any_work(
    folder: Path, done: Done, command: str, place: str
) -> None:
    found = done(*WRITING[command], place)
    assert found.returncode == 2, found.stderr
    assert "cannot be written" in found.stderr
    assert found.stderr.count("\n") == 1, found.stderr
    assert not (folder / "ran").exists()
    assert not (folder / "store.sqlite").exists()


@pytest.mark.parametrize("command", ["run", "gallery", "export", "gate --junit"])
def test_a_mount_that_is_read_only_is_such_a_place(folder: Path, command: str) -> None:
    words = [*WRITING[command], "read-only/there"]
    (folder / "read-only").mkdir()
    mounted = "mount -t tmpfs -o ro none read-only &&"
    inside = ["unshare", "--mount", "--map-root-user", "sh", "-c", f'{mounted} exec "$@"', "sh"]
    if shutil.which("unshare") is None or not is_mountable(folder):
        # A system that lets nobody mount has one at least: the files of the kernel.
        inside = []
        words = [*WRITING[command], "/sys/there"]
    environment = os.environ | {"REFDEM_STORE": str(folder / "store.sqlite")}
    found = subprocess.run(
        [*inside, *REFDEM, *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 2, found.stderr
    assert re.search(r"cannot be written: (Read-only|Operation not|Permission)", found.stderr)
    assert not (folder / "ran").exists()


def is_mountable(folder: Path) -> bool:
    """Whether this system lets a process mount in a name space of its own."""
    command = ["unshare", "--mount", "--map-root-user", "mount", "-t", "tmpfs", "none", "read-only"]
    return subprocess.run(command, cwd=folder, capture_output=True, check=False).returncode == 0


def test_a_report_that_cannot_be_written_says_so(folder: Path, done: Done) -> None:
    (folder / "records.jsonl").write_text("")
    (folder / "index.html").mkdir()
    found = done("report", ".")
    assert found.returncode == 2, found.stderr
    assert "Traceback" not in found.stderr


def test_a_baseline_that_cannot_be_read_is_said_before_any_program_runs(
    folder: Path, done: Done
) -> None:
    (folder / "refdem-baseline.jsonl").write_text('{"format":1,"engine":"a","version":"b"}\n')
    for words in (["gate"], ["gate", "--bless", "--why", "because"]):
        found = done(*words)
        assert found.returncode == 2
        assert "line 1" in found.stderr
        assert not (folder / "ran").exists()


def test_an_unknown_figure_is_said_before_any_is_made(folder: Path, done: Done) -> None:
    found = done("gallery", "1.15", "nope", "--out", "there")
    assert found.returncode == 2
    assert "no figure 'nope'" in found.stderr
    assert list((folder / "there").iterdir()) == []


def test_processes_that_write_one_folder_at_once_all_end_well(folder: Path, done: Done) -> None:
    environment = os.environ | {"REFDEM_STORE": str(folder / "store.sqlite")}
    words = ["run", "harmonic-oscillator", "--engine", "reference", "--jobs", "1", "--out", "there"]
    begun = [
        subprocess.Popen(
            [*REFDEM, *words],
            cwd=folder,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(3)
    ]
    said = [process.communicate()[1] for process in begun]
    assert [process.returncode for process in begun] == [0, 0, 0], said
    for text in said:
        assert "cannot be" not in text
        assert "Traceback" not in text
    found = done("report", "there")
    assert found.returncode == 0, found.stderr
