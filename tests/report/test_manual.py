"""The manual's files: one page a case of both kinds, nothing in them that a name could smuggle in,
pages of lost cases removed.
"""

import re
from pathlib import Path

import msgspec
import pytest

from refdem.core.manual import (
    ChapterLine,
    CheckLine,
    ManualPage,
    ParameterLine,
    QuantityLine,
    Slip,
    TruthLine,
)
from refdem.core.moved import MovedLine
from refdem.report import write_manual

NASTY = '<script>alert("x")</script> | *a* [b](c)'
TRUTH = TruthLine(
    method="closed form",
    own_witness="none",
    witness="none",
    witnessed=0,
    agreed=None,
    sets=0,
    values=0,
    digits=None,
    has_no_witness=True,
)
PAGE = ManualPage(
    case="top",
    title=NASTY,
    words=("swing", "rod"),
    statement=NASTY,
    latex=r"\ddot x=-x",
    source=NASTY,
    convention=NASTY,
    kind="a motion",
    features=("spring",),
    parameters=(ParameterLine(name="mass", default="", unit="kg", bounds="> 0", doc=NASTY),),
    quantities=(QuantityLine(name="x", unit="m", scale=1.5),),
    scalars=(QuantityLine(name="period", mid="6.28", radius="3.2e-3"),),
    moved=(
        MovedLine(
            number="mass",
            value=2.0,
            unit="kg",
            quantity="x",
            unit_of_quantity="m",
            slope=-0.25,
            share=0.5,
        ),
        MovedLine(number="v0", value=0.0, unit="m/s", has_derivative=False),
        MovedLine(number="ratio", value=0.5, unit="1"),
    ),
    moved_at="2.5",
    truth=TRUTH,
    checks=(
        CheckLine(name="error", title="Error", kills=NASTY),
        CheckLine(name="stop", title=NASTY, kills="k"),
    ),
    slips=(Slip(where="(1.1)", says=NASTY, holds="h", measured=((NASTY, "1"),)),),
    reproduce=("refdem truth top",),
)

CHAPTER = (
    ChapterLine(
        where="(1.1)",
        states=NASTY,
        case="top",
        parameters="--set mass=2",
        engines=("reference", NASTY),
        check="error",
        kills=NASTY,
        pictures=("1.15",),
    ),
)


@pytest.fixture
def home(tmp_path: Path) -> Path:
    proved = msgspec.structs.replace(
        TRUTH,
        witness="Taylor",
        witnessed=3,
        agreed=34,
        sets=1,
        values=3,
        digits=34,
        has_no_witness=False,
    )
    other = msgspec.structs.replace(PAGE, case="bottom", title="Bottom", words=(), truth=proved)
    write_manual(tmp_path, [other, PAGE], version="9.9", chapter=CHAPTER)
    return tmp_path / "manual"


def test_there_is_a_page_of_both_kinds_for_each_case_and_an_index(home: Path) -> None:
    assert sorted(p.name for p in home.iterdir()) == [
        "bottom.html",
        "bottom.md",
        "chapter.html",
        "chapter.md",
        "index.html",
        "index.md",
        "top.html",
        "top.md",
    ]
    assert (home.parent / "assets" / "report.css").is_file()


def test_a_case_without_a_witness_is_red_and_the_other_is_not(home: Path) -> None:
    assert "no witness" in (home / "top.html").read_text()
    assert "no witness" not in (home / "bottom.html").read_text()
    lines = {
        line.split("|")[1].strip(): line
        for line in (home / "index.md").read_text().splitlines()
        if line.startswith("| [")
    }
    assert "**none**" in lines["[top](top.md)"]
    assert "**none**" not in lines["[bottom](bottom.md)"]
    assert (home / "index.html").read_text().count('class="outcome fail"') == 1


@pytest.mark.parametrize("kind", ["html", "md"])
def test_words_that_find_a_case_are_told_where_it_has_some(home: Path, kind: str) -> None:
    assert "Found by: swing, rod." in (home / f"top.{kind}").read_text()
    assert "Found by" not in (home / f"bottom.{kind}").read_text()


def test_no_text_becomes_markup(home: Path) -> None:
    for path in home.iterdir():
        text = path.read_text()
        assert "<script" not in text
        if path.suffix == ".md":
            assert re.search(r"(?<!\\)\*a(?<!\\)\*", text) is None
            rows = [
                re.split(r"(?<!\\)\|", line) for line in text.splitlines() if line.startswith("|")
            ]
            assert all(len(row) in (4, 5, 7, 8, 9) for row in rows)


def test_pages_load_nothing_from_elsewhere(home: Path) -> None:
    for path in home.glob("*.html"):
        assert not re.search(r"""(src|href)=["']?(https?:)?//""", path.read_text())


def test_pages_of_cases_that_are_gone_are_removed(home: Path) -> None:
    write_manual(home.parent, [PAGE], version="9.9")
    assert not (home / "bottom.md").exists()
    assert not (home / "bottom.html").exists()


def test_the_text_is_the_same_each_time(home: Path) -> None:
    before = {path.name: path.read_bytes() for path in home.iterdir()}
    write_manual(
        home.parent,
        [msgspec.structs.replace(PAGE, case="bottom", title="Bottom"), PAGE],
        version="9.9",
    )
    assert (home / "top.md").read_bytes() == before["top.md"]


def test_what_each_number_moves_is_a_table(home: Path) -> None:
    text = (home / "top.md").read_text()
    assert "| `mass` | 2 kg | `x` | -0.25 m/kg | 0.5 % |" in text
    assert "| `v0` | 0 m/s | no derivative: the motion is of another kind on one side |" in text
    assert "| `ratio` | 0.5 | no quantity depends on it |" in text
    assert "refdem truth top --sensitivities --at 2.5" in text


def test_the_chapter_is_a_table_that_the_index_leads_to(home: Path) -> None:
    assert "(chapter.md)" in (home / "index.md").read_text()
    assert 'href="chapter.html"' in (home / "index.html").read_text()
    (line,) = (
        line
        for line in (home / "chapter.md").read_text().splitlines()
        if line.startswith("| (1.1)")
    )
    assert "[top](top.md) --set mass=2" in line
    assert "1.15" in line
    assert (
        '<a href="top.html">top</a> <code>--set mass=2</code>'
        in (home / "chapter.html").read_text()
    )
