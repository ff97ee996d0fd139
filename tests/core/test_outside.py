"""What comes from outside becomes one printable line."""

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from refdem.core.outside import MOST, one_line, opened
from refdem.errors import EngineError


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("plain", "plain"),
        ("first\nsecond\r\n\n third ", "first / second / third"),
        ("\x1b[31mred\x07", "?[31mred?"),
        ("::add-mask::secret", ": :add-mask::secret"),
        ("\n  ::stop-commands::x", ": :stop-commands::x"),
        ("a ##[error]b", "a # #[error]b"),
        ("std::runtime_error", "std::runtime_error"),
        ("right\u202eto left", "right?to left"),
        ("next\u2028line", "next / line"),
    ],
)
def test_a_text_becomes_a_line(text: str, line: str) -> None:
    assert one_line(text) == line


@given(st.text(max_size=5000))
def test_any_text_is_one_printable_line_without_a_command(text: str) -> None:
    line = one_line(text)
    assert line.isprintable()
    assert len(line) <= MOST
    assert "##[" not in line
    assert not line.startswith("::")


def test_only_a_plain_file_of_ones_own_is_opened(tmp_path: Path) -> None:
    plain = tmp_path / "plain.csv"
    plain.write_text("text")
    file = opened(plain)
    assert file is not None
    with file:
        assert file.read() == b"text"
    assert opened(tmp_path / "none.csv") is None
    (tmp_path / "link.csv").symlink_to(plain)
    os.mkfifo(tmp_path / "pipe.csv")
    for name in ("link.csv", "pipe.csv"):
        with pytest.raises(EngineError, match="plain file"):
            opened(tmp_path / name)
    os.link(plain, tmp_path / "twin.csv")
    with pytest.raises(EngineError, match="is a link"):
        opened(plain)
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(EngineError, match="plain file"):
        opened(tmp_path / "folder.csv")
