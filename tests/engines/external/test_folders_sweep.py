"""What is swept away at a start, asked in this process: folders that nobody holds, and no other."""

import fcntl
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from refdem.engines.external.folders import run_folder, sweep


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder for temporary files."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def filled(folder: Path) -> Path:
    """A folder with a file and a folder in it."""
    (folder / "inner").mkdir(parents=True)
    (folder / "inner" / "file").touch()
    return folder


def left(place: Path) -> list[str]:
    """What is still there after a sweep."""
    sweep()
    return sorted(path.name for path in place.iterdir())


def test_folders_of_runs_that_nobody_holds_are_taken_away(place: Path) -> None:
    filled(place / "refdem-runs-a")
    (place / "refdem-runs-b").mkdir()
    filled(place / "of-somebody-else")
    assert left(place) == ["of-somebody-else"]


@pytest.mark.parametrize("kind", [fcntl.LOCK_SH, fcntl.LOCK_EX])
def test_a_folder_that_is_held_stays_until_it_is_not(place: Path, kind: int) -> None:
    holding = os.open(filled(place / "refdem-runs-a"), os.O_RDONLY)
    fcntl.flock(holding, kind)
    before = len(os.listdir("/proc/self/fd"))
    assert left(place) == ["refdem-runs-a"]
    assert (place / "refdem-runs-a" / "inner" / "file").exists()
    assert len(os.listdir("/proc/self/fd")) == before
    os.close(holding)
    assert left(place) == []
    assert len(os.listdir("/proc/self/fd")) == before - 1


def test_files_and_links_of_such_a_name_are_left_alone(place: Path, tmp_path: Path) -> None:
    filled(place / "outside")
    (place / "refdem-runs-file").touch()
    (place / "refdem-runs-link").symlink_to(place / "outside")
    assert left(place) == ["outside", "refdem-runs-file", "refdem-runs-link"]
    assert (place / "outside" / "inner" / "file").exists()


def test_folders_that_were_being_made_go_with_their_maker(place: Path) -> None:
    """Empty ones: whoever has put something there is not the maker."""
    gone = subprocess.Popen([sys.executable, "-I", "-S", "-c", "pass"])
    gone.wait()
    (place / f"refdem-new-{gone.pid}-a").mkdir()
    filled(place / f"refdem-new-{gone.pid}-b")
    (place / f"refdem-new-{os.getpid()}-c").mkdir()
    assert left(place) == sorted([f"refdem-new-{gone.pid}-b", f"refdem-new-{os.getpid()}-c"])


def test_the_folder_of_a_run_is_empty_and_gone_afterwards() -> None:
    with run_folder() as folder:
        assert list(folder.iterdir()) == []
        filled(folder / "more")
        with run_folder() as other:
            assert other.parent == folder.parent
            assert other != folder
    assert not folder.exists()
    assert not other.exists()
    with pytest.raises(KeyError), run_folder() as folder:
        raise KeyError
    assert not folder.exists()
