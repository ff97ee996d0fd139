"""What is kept of parsed files is found by content alone, and is never wrong."""

import os
import sys
from pathlib import Path

import pytest

from refdem.truth.certified import parsed as kept
from refdem.truth.certified import sources

SOURCE = b"import math\nx = 1\n"
OTHER = b"import math\nx = 2\n"


class Counted:
    """What is read from a file, counting how often that is asked for."""

    def __init__(self) -> None:
        self.times = 0

    def __call__(self, source: bytes) -> kept.Parsed:
        self.times += 1
        return sources.digest_and_imports(source)


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file that entries are kept in, not there yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    forget()
    return tmp_path / "refdem" / "parsed-sources.txt"


def forget() -> None:
    """As in another process."""
    kept._entries.cache_clear()


def test_another_process_parses_nothing_again_and_reads_the_same(file: Path) -> None:
    parse = Counted()
    first = kept.parsed(SOURCE, "one", parse)
    forget()
    assert kept.parsed(SOURCE, "one", parse) == first == sources.digest_and_imports(SOURCE)
    assert parse.times == 1
    assert file.exists()


@pytest.mark.parametrize(("source", "reader"), [(OTHER, "one"), (SOURCE, "two")])
def test_other_content_and_another_reader_are_read_anew(
    file: Path, source: bytes, reader: str
) -> None:
    parse = Counted()
    kept.parsed(SOURCE, "one", parse)
    forget()
    assert kept.parsed(source, reader, parse) == sources.digest_and_imports(source)
    assert parse.times == 2


def test_content_counts_where_name_size_and_date_are_the_same(file: Path, tmp_path: Path) -> None:
    path = tmp_path / "module.py"
    read = []
    for source in (SOURCE, OTHER):
        path.write_bytes(source)
        os.utime(path, (0, 0))
        forget()
        sources._read.cache_clear()
        read.append(sources._read(path))
    sources._read.cache_clear()
    assert read == [sources.digest_and_imports(SOURCE), sources.digest_and_imports(OTHER)]
    assert read[0] != read[1]


def test_a_damaged_entry_is_dropped_wherever_it_is_damaged(file: Path) -> None:
    right = kept.parsed(SOURCE, "one", Counted())
    sound = file.read_bytes()
    for place in range(len(sound)):
        file.write_bytes(sound[:place] + bytes([sound[place] ^ 1]) + sound[place + 1 :])
        forget()
        assert kept.parsed(SOURCE, "one", Counted()) == right


def test_a_torn_line_spoils_no_other(file: Path) -> None:
    parse = Counted()
    kept.parsed(SOURCE, "one", parse)
    with file.open("ab") as torn:
        torn.write(b"0123456789abcdef [")
    forget()
    other = kept.parsed(OTHER, "one", parse)
    forget()
    assert kept.parsed(SOURCE, "one", parse) == sources.digest_and_imports(SOURCE)
    assert kept.parsed(OTHER, "one", parse) == other
    assert parse.times == 2


def test_a_file_that_has_grown_large_is_begun_anew(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kept, "MOST", 1000)
    for number in range(100):
        kept.parsed(b"x = %d" % number, "one", sources.digest_and_imports)
    assert file.stat().st_size < 2000


@pytest.mark.parametrize("hurdle", ["a file in its place", "no right to write"])
def test_where_nothing_can_be_kept_all_is_read(file: Path, hurdle: str) -> None:
    if hurdle == "a file in its place":
        file.parent.write_text("")
    else:
        file.parent.mkdir()
        file.mkdir()
    assert kept.parsed(SOURCE, "one", Counted()) == sources.digest_and_imports(SOURCE)


def test_the_reader_is_this_code_and_this_python(monkeypatch: pytest.MonkeyPatch) -> None:
    before = sources._reader()
    sources._reader.cache_clear()
    monkeypatch.setattr(sys, "version", "3.99")
    other = sources._reader()
    sources._reader.cache_clear()
    assert other != before
