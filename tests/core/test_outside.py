"""What comes from outside becomes one printable line."""

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from refdem.core.outside import (
    MOST,
    cell,
    in_file_name,
    markdown_text,
    one_line,
    opened,
    printable,
    put_new,
)
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


def test_a_new_file_is_made_at_no_name_that_is_taken(tmp_path: Path) -> None:
    target = tmp_path / "target"
    target.write_text("kept")
    (tmp_path / "link").symlink_to(target)
    (tmp_path / "loose").symlink_to(tmp_path / "nowhere")
    os.mkfifo(tmp_path / "pipe")
    for name in ("target", "link", "loose", "pipe"):
        with pytest.raises(EngineError, match=f"^{name} cannot be made: File exists"):
            put_new(tmp_path / name, b"lost")
    assert target.read_text() == "kept"
    assert not (tmp_path / "nowhere").exists()
    put_new(tmp_path / "new", b"text")
    assert (tmp_path / "new").read_bytes() == b"text"


@pytest.mark.parametrize(
    ("text", "markdown"),
    [
        ("a | b\nc", r"a \| b c"),
        ("<script>alert(1)</script>&amp;", "&lt;script&gt;alert(1)&lt;/script&gt;&amp;amp;"),
        ("ask @someone", "ask @&#8203;someone"),
        ("see https://example.org", "see https:&#8203;//example.org"),
        ("see www.example.org", "see www.&#8203;example.org"),
        ("as GH-12 or gh-7 and GHz-5", "as G&#8203;H-12 or g&#8203;h-7 and GHz-5"),
        ("like #12 and # 12", r"like \#&#8203;12 and \# 12"),
        ("[a](javascript:b)", r"\[a\](javascript:b)"),
        ("\x1b[31m", r"?\[31m"),
    ],
)
def test_a_text_in_markdown_is_text(text: str, markdown: str) -> None:
    assert markdown_text(text) == markdown


@pytest.mark.parametrize("text", ["=HYPERLINK(1)", "+1", "-cmd", "@SUM(A1)", "\t=1"])
def test_a_formula_in_a_cell_is_text(text: str) -> None:
    assert cell(text) == f"'{text}"


def test_numbers_and_names_in_cells_stay_as_they_are() -> None:
    assert [cell(value) for value in (-1.5, None, 3, "pendulum[a=-1]")] == [
        -1.5,
        None,
        3,
        "pendulum[a=-1]",
    ]


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("pendulum[theta0=2 gravity=9.81]", "pendulum-theta0=2-gravity=9.81"),
        ("../../etc/passwd", "etc-passwd"),
        ("-rf ~; C:\\CON \x1b[2J\u202e\n", "rf-c-con-2j"),
        ("A" * 100, "a" * 80),
    ],
)
def test_a_text_in_a_file_name_is_safe_on_any_file_system(text: str, name: str) -> None:
    assert in_file_name(text) == name


def test_lines_stay_lines_where_only_what_does_not_print_goes() -> None:
    assert printable("a\n\x1bb\u202ec") == "a\n?b?c"
