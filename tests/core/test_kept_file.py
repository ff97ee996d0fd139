"""What is kept in the user's cache folder is made once, and again where it is damaged."""

from pathlib import Path

import pytest

from refdem.core.kept_file import kept_file

CONTENT = b"first\nsecond\x00\n"


class Made:
    """Makes the content, and counts how often."""

    def __init__(self) -> None:
        self.times = 0

    def __call__(self) -> bytes:
        self.times += 1
        return CONTENT


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The cache folder of refdem, not there yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "refdem"


def test_it_is_made_once(home: Path) -> None:
    made = Made()
    assert [kept_file("one", made) for _ in range(3)] == [CONTENT] * 3
    assert made.times == 1
    assert [path.name for path in home.iterdir()] == ["one"]


def test_what_is_kept_under_another_name_is_not_taken(home: Path) -> None:
    made = Made()
    kept_file("one", made)
    (home / "one").rename(home / "two")
    assert kept_file("two", made) == CONTENT
    assert made.times == 2


def test_it_is_made_again_wherever_it_is_damaged(home: Path) -> None:
    made = Made()
    kept_file("one", made)
    sound = (home / "one").read_bytes()
    for place in range(len(sound)):
        (home / "one").write_bytes(sound[:place] + bytes([sound[place] ^ 1]) + sound[place + 1 :])
        assert kept_file("one", made) == CONTENT
    for length in range(len(sound)):
        (home / "one").write_bytes(sound[:length])
        assert kept_file("one", made) == CONTENT
    assert made.times == 1 + 2 * len(sound)
    assert (home / "one").read_bytes() == sound


@pytest.mark.parametrize("hurdle", ["a file in place of the folder", "a folder in its place"])
def test_where_nothing_can_be_kept_it_is_made_each_time(home: Path, hurdle: str) -> None:
    if hurdle == "a file in place of the folder":
        home.write_text("")
    else:
        (home / "one").mkdir(parents=True)
    made = Made()
    assert [kept_file("one", made) for _ in range(2)] == [CONTENT] * 2
    assert made.times == 2
