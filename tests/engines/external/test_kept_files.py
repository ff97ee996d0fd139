"""Which files of a failed run are kept, how much of each, and what becomes of older runs."""

from pathlib import Path

import pytest

from refdem.engines.external import kept as kept_module
from refdem.engines.external.kept import kept


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where failed runs are kept."""
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "store" / "store.sqlite"))
    return tmp_path / "store" / "failed-runs"


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """The folder of a run."""
    folder = tmp_path / "run"
    folder.mkdir()
    return folder


def test_the_first_32_plain_files_are_kept_by_their_names(home: Path, run: Path) -> None:
    for number in range(40):
        (run / f"f{number:02}").write_text(str(number))
    (run / "a folder").mkdir()
    (run / "a folder" / "file").touch()
    (run / "a link").symlink_to(run / "f39")
    (run / "a link to nothing").symlink_to("nothing")
    place = kept(run, "small")
    assert place is not None
    assert place.parent == home
    assert {path.name: path.read_text() for path in place.iterdir()} == {
        f"f{number:02}": str(number) for number in range(32)
    }


@pytest.mark.parametrize("size", [0, 1, 2**20 - 1, 2**20, 2**20 + 1, 2**21])
def test_of_each_file_the_first_mebibyte_is_kept(home: Path, run: Path, size: int) -> None:
    text = bytes(number % 251 for number in range(1000)) * (size // 1000 + 1)
    (run / "long").write_bytes(text[:size])
    place = kept(run, "small")
    assert place is not None
    assert (place / "long").read_bytes() == text[: min(size, 2**20)]


def test_where_nothing_can_be_written_nothing_is_kept(
    tmp_path: Path, run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "file" / "store.sqlite"))
    assert kept(run, "small") is None


def test_what_was_kept_by_half_is_taken_away(home: Path, run: Path) -> None:
    """The folder of the run vanished in between."""
    assert kept(run / "gone", "small") is None
    assert list(home.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("small-7", 7),
        ("a-b-12", 12),
        ("small-007", 7),
        ("small", 0),
        ("small-", 0),
        ("small-7a", 0),
        ("small--7", 7),
        ("small-\u0667", 0),
        ("small-" + "9" * 5000, int("9" * 30)),
    ],
)
def test_the_number_of_a_folder_is_that_at_its_end(name: str, number: int) -> None:
    assert kept_module._stamp(Path(name)) == number


def test_a_run_is_newer_than_all_that_are_there(
    home: Path, run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where they come from a clock that was ahead; the sixteen newest stay."""
    monkeypatch.setattr(kept_module.time, "time_ns", lambda: 1000)
    for number in (5, 2000, *range(10, 24)):
        (home / f"other-{number}").mkdir(parents=True)
    place = kept(run, "small")
    assert place == home / "small-2001"
    numbers = sorted(kept_module._stamp(path) for path in home.iterdir())
    assert numbers == [*range(10, 24), 2000, 2001]
    monkeypatch.setattr(kept_module.time, "time_ns", lambda: 3000)
    assert kept(run, "small") == home / "small-3000"
