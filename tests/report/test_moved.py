"""The panel of what each number moves: the same cells in the page and in the Markdown of a report,
with nothing in them that a name could smuggle in.
"""

from pathlib import Path

import msgspec
import pytest

from refdem.core.finding import CaseSheet, Sheet
from refdem.core.moved import Moved, MovedLine
from refdem.report import read_records, write_report
from refdem.report.contents import page
from refdem.report.moved import cells_of
from tests.report import synthetic

NUMBERS = (
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
    MovedLine(number=synthetic.HOSTILE, value=0.5, unit=synthetic.HOSTILE),
)


def sheets_with(**told: object) -> tuple[str, list[Sheet]]:
    sheets = list(synthetic.sheets())
    label = next(sheet.label for sheet in sheets if isinstance(sheet, CaseSheet))
    moved = Moved(label=label, at="2.5", command="refdem truth top --sensitivities --at 2.5")
    return label, [*sheets, msgspec.structs.replace(moved, **told)]


@pytest.mark.parametrize("again", [False, True])
def test_the_page_and_the_markdown_have_a_line_for_each_number(tmp_path: Path, again: bool) -> None:
    label, sheets = sheets_with(numbers=NUMBERS)
    write_report(tmp_path, sheets)
    if again:
        write_report(tmp_path, read_records(tmp_path))
    shown = (tmp_path / "cases" / f"{page(label)}.html").read_text()
    panel = shown.partition('<h2 id="moved">')[2].partition("<h2")[0]
    assert "at t = 2.5 s" in panel
    assert "-0.25 m/kg" in panel
    assert "0.5 %" in panel
    assert "the motion is of another kind on one side" in panel
    assert "no quantity depends on it" in panel
    text = (tmp_path / "validation.md").read_text()
    assert "| `mass` | 2 kg | `x` | -0.25 m/kg | 0.5 % |" in text
    for written in (panel, text):
        assert "<script>alert" not in written


def test_without_lines_the_page_says_why_and_the_markdown_nothing(tmp_path: Path) -> None:
    label, sheets = sheets_with(reason="it was given up")
    write_report(tmp_path, sheets)
    shown = (tmp_path / "cases" / f"{page(label)}.html").read_text()
    assert "Not shown: it was given up." in shown
    assert "What each number moves" not in (tmp_path / "validation.md").read_text()


def test_a_number_that_is_zero_has_no_share_and_one_without_unit_no_unit() -> None:
    cells = cells_of(MovedLine(number="n", value=0.0, unit="1", quantity="x", slope=3.0))
    assert (cells.value, cells.share) == ("0", "")
    assert cells.slope.startswith("3")
