"""reports/stress.md: it has every sweep that `refdem stress` runs, and no other."""

import re
from pathlib import Path

from refdem.core.outside import markdown_text
from refdem.stress import selection

ROOT = Path(__file__).parents[2]
REPORTS = ROOT / "reports"
PAGE = (REPORTS / "stress.md").read_text()
SUMMARY, *SECTIONS = PAGE.split("\n## ")
SWEEPS = {
    (battery.id, markdown_text(sweep.name), markdown_text(sweep.along))
    for battery in selection.batteries([], [])
    for sweep in battery.sweeps
}


def rows_of(text: str) -> list[list[str]]:
    """The cells of all rows of a page's first table, its header first."""
    (table, *_) = re.findall(r"(?:^\|.*\n)+", text, flags=re.MULTILINE)
    rows = [re.split(r"(?<!\\)\|", line)[1:-1] for line in table.splitlines()]
    return [[cell.strip() for cell in row] for row in rows]


def test_the_page_has_every_sweep_and_no_other() -> None:
    _, _, *rows = rows_of(SUMMARY)
    assert {tuple(row[:3]) for row in rows} == SWEEPS


def test_the_page_has_a_column_for_every_engine_with_the_reference_first() -> None:
    header, *_ = rows_of(SUMMARY)
    judged = {path.stem for path in (ROOT / "validation" / "campaigns" / "main").glob("*.txt")}
    assert header[3:] == ["reference", *sorted(judged - {"reference"})]


def test_the_page_has_a_section_and_a_picture_for_every_battery() -> None:
    batteries = selection.batteries([], [])
    titles = [section.split("\n", 1)[0] for section in SECTIONS]
    assert sorted(titles) == sorted(markdown_text(battery.title) for battery in batteries)
    shown = {f"stress-{battery.id}.svg" for battery in batteries}
    assert {path.name for path in (REPORTS / "figures").glob("stress-*.svg")} == shown
    assert {f"stress-{name}.svg" for name in re.findall(r"stress-([\w-]+)\.svg", PAGE)} == shown
