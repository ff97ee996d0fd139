"""The resolution of verdicts as text and as Markdown: for each case, method and number the smallest
misreading that would close the gate.
"""

from collections.abc import Iterable
from itertools import groupby
from pathlib import Path

from refdem.core.finding import Record, Sheet
from refdem.core.outside import markdown_text, one_line
from refdem.core.resolution import Resolution, size_of
from refdem.report.files import written
from refdem.report.jsonl import lines as jsonl
from refdem.report.jsonl import sheets_in

PAGE = "resolution.md"
DATA = "resolution.jsonl"
"""Beside the page: what it shows, a line for each method on each case."""

INTRODUCTION = """# Resolution: the smallest misreading that a pass excludes

Each number of a scene was misread by a factor 1 + a in every request that an engine got, and its
runs were judged as if it had been read correctly. The table has the smallest a at which some
finding fails, and the finding that is farthest beyond its bound there. `refdem resolution CASE
--engine E` measures it anew; trials lie within a factor of 1.5 of each other.

Only runs of the scene itself were judged. A verdict also compares them with runs of the scene
shifted, boosted, relabelled or reversed, which may show a start or a number of one body that is
misread by less: a pass excludes at least what the table has.
"""


def write(folder: Path, found: Iterable[Resolution]) -> None:
    """Writes the page and its data; raises StoreError.

    The next report in this folder shows the data on the pages of its cases.
    """
    found = list(found)
    written(folder / DATA, jsonl(found))
    written(folder / PAGE, markdown(found))


def read(folder: Path) -> list[Resolution]:
    """What was measured for reports in a folder, nothing if nothing was; raises UsageError that
    names a malformed line.
    """
    if not (folder / DATA).is_file():
        return []
    return [sheet for sheet in sheets_in(folder, DATA) if isinstance(sheet, Resolution)]


def of_records(found: Iterable[Resolution], sheets: Iterable[Sheet]) -> list[Resolution]:
    """The resolutions of the methods and cases of which some sheet is the record."""
    judged = {
        (sheet.label, sheet.engine, sheet.method) for sheet in sheets if isinstance(sheet, Record)
    }
    return [one for one in found if (one.label, one.engine, one.method) in judged]


def lines(found: Iterable[Resolution]) -> list[str]:
    """Lines for a terminal: a heading for each method on each case, and a line for each number."""
    printed = []
    for one in found:
        printed.append(one_line(f"{one.label} in {one.engine}, {one.method}, would have noticed"))
        for entry in one.numbers:
            if entry.smallest is None:
                printed.append(
                    one_line(f"  no misreading of {entry.number}, because {entry.reason}")
                )
            else:
                printed.append(one_line(f"  {entry.number:36}{entry.size:>10}  {entry.by}"))
            if entry.computed_by:
                computed = "-"
                if entry.computed is not None:
                    computed = size_of(entry.computed)
                printed.append(one_line(f"  {'computed':36}{computed:>10}  {entry.computed_by}"))
    return printed


def markdown(found: Iterable[Resolution]) -> str:
    """The page: for each case a table of its numbers, with a column for each method."""
    parts = [INTRODUCTION]
    for label, of_case in groupby(found, key=lambda one: one.label):
        parts.append(_table(label, list(of_case)))
    return "\n".join(parts)


def _table(label: str, found: list[Resolution]) -> str:
    """The table of one case, and why some misreadings are not detected."""
    # Imports jinja2, which reading what was measured does not need.
    from refdem.report.markdown import table

    names = list(dict.fromkeys(entry.number for one in found for entry in one.numbers))
    by_method = [{entry.number: entry for entry in one.numbers} for one in found]
    rows = []
    for name in names:
        cells = []
        for numbers in by_method:
            entry = numbers.get(name)
            if entry is None:
                cells.append("")
            elif entry.smallest is None:
                cells.append("nothing")
            else:
                cells.append(f"{entry.size} ({markdown_text(entry.by)})")
        rows.append([markdown_text(name), *cells])
    head = ["number", *(markdown_text(f"{one.engine} {one.method}") for one in found)]
    parts = [f"## {markdown_text(label)}", "", table(head, rows)]
    reasons = _reasons(found)
    if reasons:
        parts += ["", *reasons]
    return "\n".join([*parts, ""])


def _reasons(found: list[Resolution]) -> list[str]:
    """A line for each number and each reason why no misreading is detected, with the methods."""
    blind: dict[tuple[str, str], list[str]] = {}
    for one in found:
        for entry in one.numbers:
            if entry.smallest is None:
                methods = blind.setdefault((entry.number, entry.reason), [])
                methods.append(f"{one.engine} {one.method}")
    lines = []
    for (number, reason), methods in blind.items():
        where = markdown_text(", ".join(methods))
        lines.append(
            f"- {markdown_text(number)}: no misreading, because {markdown_text(reason)} ({where})."
        )
    return lines
