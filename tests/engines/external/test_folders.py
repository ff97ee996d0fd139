"""The folders of processes that are gone are taken away, and those of others are left alone."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from refdem.core import discovery
from refdem.core.finding import CampaignSheet
from refdem.core.store import Store
from refdem.engines.external import folders, supervisor
from refdem.engines.external.folders import (
    engine_home,
    home,
    is_there,
    made_in_home,
    run_folder,
)
from refdem.engines.external.process import Supervised
from refdem.errors import EngineError
from refdem.planning import unchanged
from refdem.planning.campaign import Campaign
from refdem.planning.specification import Entry, Specification

DEEP = 1100
"""Folders in folders: more than Python recurses."""
KILLED = """
import os, signal, socket, subprocess, sys
ours, its = socket.socketpair()
command = [sys.executable, "-I", "-S", *sys.argv[1:3], str(os.getpid())]
subprocess.Popen(command, stdin=its, pass_fds=[int(sys.argv[3])])
os.kill(os.getpid(), signal.SIGKILL)
"""
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


def test_a_campaign_in_which_nothing_is_run_takes_it_away_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    (tmp_path / "refdem-runs-stale").mkdir()
    (tmp_path / "refdem-runs-stale" / "trajectory.csv").touch()
    specification = Specification(name="t", case=[Entry("newtons-first-law")], engines=["mujoco"])
    kept = unchanged.key_of(specification, [discovery.engine("mujoco")])
    assert kept is not None
    sheet = CampaignSheet(name="t", refdem="", runs_made=1, runs_read=0, seconds=0.0)
    store = Store(tmp_path / "store.sqlite")
    unchanged.keep(store, kept, [sheet])
    assert Campaign(specification, store).sheets()
    store.close()
    assert list(tmp_path.glob("refdem-*")) == []


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


def nested(folder: Path, *, is_locked: bool) -> None:
    """Leaves folders in a folder, deeper than Python recurses; the innermost may be locked."""
    here = os.open(folder, os.O_RDONLY)
    for _ in range(DEEP):
        os.mkdir("deep", dir_fd=here)
        inner = os.open("deep", os.O_RDONLY, dir_fd=here)
        os.close(here)
        here = inner
    os.close(os.open("file", os.O_WRONLY | os.O_CREAT, dir_fd=here))
    if is_locked:
        os.fchmod(here, 0)
    os.close(here)


@pytest.mark.parametrize("is_locked", [False, True])
def test_the_supervisor_of_a_killed_process_takes_away_folders_however_deep(
    tmp_path: Path, is_locked: bool
) -> None:
    left = tmp_path / "refdem-runs-of-a-killed-process"
    left.mkdir()
    nested(left, is_locked=is_locked)
    heard, held = os.pipe()
    process = [sys.executable, "-c", KILLED, supervisor.__file__, str(left), str(held)]
    subprocess.run(process, pass_fds=[held], check=False)
    os.close(held)
    # The pipe ends when the supervisor does.
    with os.fdopen(heard, "rb") as ended:
        assert ended.read() == b""
    assert not left.exists()


def test_each_engine_has_a_home_of_its_own_which_is_made_anew_where_it_was_taken_away() -> None:
    first = engine_home("first")
    assert engine_home("first") == first
    other = engine_home("other")
    assert other != first
    assert other.parent == first.parent == home()
    first.rename(first.with_name(f"{first.name}-moved"))
    first.symlink_to("/")
    again = engine_home("first")
    assert is_there(again)
    assert again != first
    assert engine_home("other") == other


def test_a_run_finds_a_folder_after_all_folders_were_taken_away() -> None:
    before = home()
    supervisor.remove(before)
    with run_folder("first") as folder:
        assert is_there(folder)
    assert home() != before


def test_a_folder_that_is_taken_away_each_time_is_an_error_that_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(folders, "engine_home", lambda _: tmp_path / "gone")
    with pytest.raises(EngineError, match="is cleared while refdem runs"):
        made_in_home("first")
