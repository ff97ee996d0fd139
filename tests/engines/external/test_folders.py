"""The folders of processes that are gone are taken away, and those of others are left alone."""

import os
import subprocess
import sys
from pathlib import Path

from refdem.engines.external import supervisor
from refdem.engines.external.folders import home
from refdem.engines.external.process import Supervised

CODE = (
    "import os, sys; from refdem.engines.external.folders import home, run_folder\n"
    "with run_folder() as folder: print(folder, flush=True); {end}"
)


def begun(place: Path, end: str) -> "subprocess.Popen[str]":
    """A process with a folder of a run in `place`, which then does something."""
    command = [sys.executable, "-c", CODE.format(end=end)]
    environment = {"TMPDIR": str(place), "PYTHONPATH": ":".join(sys.path)}
    return subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
    )


def test_what_a_killed_process_left_is_taken_away_at_the_next_start(tmp_path: Path) -> None:
    with begun(tmp_path, "os._exit(1)") as killed:
        assert killed.stdout is not None
        stale = Path(killed.stdout.readline().strip())
    assert stale.is_dir()
    with begun(tmp_path, "pass") as other:
        other.communicate()
    assert list(tmp_path.iterdir()) == []


def test_what_a_process_was_just_making_when_it_was_killed_is_taken_away(tmp_path: Path) -> None:
    killed = subprocess.Popen([sys.executable, "-c", "pass"])
    killed.wait()
    (tmp_path / f"refdem-new-{killed.pid}-abc").mkdir()
    (tmp_path / f"refdem-new-{os.getpid()}-abc").mkdir()
    with begun(tmp_path, "pass") as other:
        other.communicate()
    assert [path.name for path in tmp_path.iterdir()] == [f"refdem-new-{os.getpid()}-abc"]


def test_what_another_process_still_holds_is_left_alone(tmp_path: Path) -> None:
    with begun(tmp_path, "sys.stdin.read()") as working:
        assert working.stdout is not None
        held = Path(working.stdout.readline().strip())
        with begun(tmp_path, "pass") as other:
            other.communicate()
        assert held.is_dir()
        working.communicate()
    assert list(tmp_path.iterdir()) == []


def test_a_process_that_ends_slowly_is_waited_for(monkeypatch) -> None:
    """It closes its sockets before its children have another parent."""
    parents = iter([7, 7, 7, 1])
    monkeypatch.setattr(supervisor.os, "getppid", lambda: next(parents))
    monkeypatch.setattr(supervisor, "PAUSE", 0.0)
    assert supervisor.is_orphan(7)


def test_a_supervisor_that_is_sent_away_leaves_the_folder_of_its_process_alone() -> None:
    began = Supervised()
    began.close()
    assert began.process.returncode == 0
    assert home().is_dir()
