"""A file that a person named is written whole, and what is no plain file keeps being what it is."""

import errno
import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from refdem.core import named_file
from refdem.core.named_file import put, refuse_full
from refdem.report.files import written_to


def read_by(reader: Path) -> "tuple[threading.Thread, list[bytes]]":
    """A thread that reads what comes out of a pipe."""
    came: list[bytes] = []
    thread = threading.Thread(target=lambda: came.append(reader.read_bytes()))
    thread.start()
    return thread, came


@pytest.mark.parametrize("name", ["pipe", "link to it"])
def test_a_pipe_stays_a_pipe_and_its_reader_gets_the_text(tmp_path: Path, name: str) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link to it").symlink_to("pipe")
    thread, came = read_by(tmp_path / "pipe")
    refuse_full(tmp_path / name)
    written_to(tmp_path / name, "text", "--junit")
    thread.join(60)
    assert came == [b"text"]
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
    assert (tmp_path / "link to it").is_symlink()


def test_a_plain_file_is_replaced_as_a_whole_and_nothing_is_left_beside_it(tmp_path: Path) -> None:
    name = "n" * 250
    put(tmp_path / name, b"first")
    inode = (tmp_path / name).stat().st_ino
    put(tmp_path / name, b"second")
    assert (tmp_path / name).read_bytes() == b"second"
    assert (tmp_path / name).stat().st_ino != inode
    assert os.listdir(tmp_path) == [name]


def test_two_that_write_one_file_at_once_both_end_well(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = Path.replace

    def between(beside: Path, path: Path) -> None:
        monkeypatch.setattr(Path, "replace", replace)
        put(path, b"of the other")
        replace(beside, path)

    monkeypatch.setattr(Path, "replace", between)
    put(tmp_path / "file", b"mine")
    assert (tmp_path / "file").read_bytes() == b"mine"
    assert os.listdir(tmp_path) == ["file"]


@pytest.mark.parametrize("number", sorted(named_file.REPLACED_BY_NOBODY))
def test_a_file_that_cannot_be_replaced_is_written_in_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    def refused(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(Path, "replace", refused)
    (tmp_path / "mounted").write_bytes(b"before")
    put(tmp_path / "mounted", b"after")
    assert (tmp_path / "mounted").read_bytes() == b"after"
    with pytest.raises(OSError, match=os.strerror(number)):
        put(tmp_path / "new", b"after")
    assert os.listdir(tmp_path) == ["mounted"]


def test_a_full_disk_leaves_the_file_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    (tmp_path / "file").write_bytes(b"before")
    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OSError, match="No space left"):
        put(tmp_path / "file", b"after")
    assert (tmp_path / "file").read_bytes() == b"before"
    assert os.listdir(tmp_path) == ["file"]


def test_what_takes_nothing_is_found_before_anything_is_made() -> None:
    with pytest.raises(OSError, match="No space left"):
        refuse_full(Path("/dev/full"))
    refuse_full(Path(os.devnull))


def test_a_process_that_has_ended_is_gone_and_one_that_runs_is_not() -> None:
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    assert named_file.is_gone(str(ended.pid))
    assert not named_file.is_gone(str(os.getpid()))


@pytest.mark.parametrize("name", ["", "x", "1.5", "9" * 40])
def test_what_is_no_number_of_a_process_is_of_nobody_who_is_gone(name: str) -> None:
    assert not named_file.is_gone(name)
