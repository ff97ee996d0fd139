"""The list of a folder's files counts them: a file that is gone with its line is missed."""

import shutil
import subprocess

import pytest

from refdem.truth.certified import reader
from refdem.truth.certified.listing import listing


def copied(folder):
    """A copy of the certified values that come with refdem."""
    shutil.copytree(reader.default_folder(), folder)
    return folder


def test_the_list_is_what_sha256sum_reads(tmp_path):
    files = {"b.jsonl": "2\n", "a.jsonl": "1\n"}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    (tmp_path / reader.LIST).write_text(listing(files))
    subprocess.run(["sha256sum", "--check", "--strict", reader.LIST], cwd=tmp_path, check=True)
    (tmp_path / "b.jsonl").write_text("3\n")
    found = subprocess.run(["sha256sum", "--check", reader.LIST], cwd=tmp_path, check=False)
    assert found.returncode == 1


def test_the_list_that_comes_with_refdem_is_as_it_is_written():
    home = reader.default_folder()
    files = {path.name: path.read_text(encoding="utf-8") for path in home.glob("*.jsonl")}
    assert (home / reader.LIST).read_text() == listing(files)


@pytest.mark.parametrize("case", ["", "pendulum"])
def test_a_file_that_is_gone_with_its_line_is_missed(tmp_path, case):
    home = copied(tmp_path / "certified")
    (home / "duffing.jsonl").unlink()
    lines = (home / reader.LIST).read_text().splitlines(keepends=True)
    (home / reader.LIST).write_text("".join(line for line in lines if "  duffing" not in line))
    # The first line has the number of files.
    before = len(lines) - 1
    message = f"{before - 1} files are listed, and its first line counts {before}"
    with pytest.raises(ValueError, match=message):
        reader.load(case, folder=home)


@pytest.mark.parametrize("head", ["", "# many files\n", "# 46 files \n", "46 files\n"])
def test_a_list_that_does_not_say_how_many_files_there_are_is_refused(tmp_path, head):
    home = copied(tmp_path / "certified")
    lines = (home / reader.LIST).read_text().splitlines(keepends=True)
    (home / reader.LIST).write_text("".join([head, *lines[1:]]))
    with pytest.raises(ValueError, match=r"line 1: got .*, expected the number of files"):
        reader.load(folder=home)


def test_an_empty_list_is_refused(tmp_path):
    (tmp_path / reader.LIST).write_text("")
    with pytest.raises(ValueError, match="line 1: got '', expected the number of files"):
        reader.load(folder=tmp_path)
