"""Writing the whole report into a folder."""

from collections.abc import Sequence
from itertools import chain
from pathlib import Path

from refdem.core.finding import CaseSheet, Record, Sheet
from refdem.core.named_file import sweep
from refdem.core.store import Store
from refdem.errors import RefdemError
from refdem.report import chart_data, figures, html, index, markdown, replays, tables
from refdem.report.contents import Contents, contents_of, page
from refdem.report.files import removed, written
from refdem.report.jsonl import RECORDS, lines, sheets_in
from refdem.report.junit import junit
from refdem.report.tolerance import Row, rows_of

FOLDERS = ("assets", "cases", "figures")
"""Subfolders that hold files of a report."""


def write_everything(folder: Path, sheets: Sequence[Sheet], store: Store | None) -> None:
    """Writes all files of a report: records first, index.html last.

    If a later file cannot be written, the report can be made again from the records.
    """
    contents = contents_of(sheets)
    rows = {sheet.label: rows_of(contents, sheet.label) for sheet in contents.cases}
    for place in (folder, *(folder / name for name in FOLDERS)):
        sweep(place.glob(".*"))
    _clear(folder, set(rows))
    written(folder / RECORDS, lines(sheets))
    findings = tables.csv_text(tables.FINDING, tables.finding_rows(contents))
    written(folder / "findings.csv", findings)
    everything = list(chain.from_iterable(rows.values()))
    tolerance = tables.csv_text(tables.TOLERANCE, tables.tolerance_rows(everything))
    written(folder / "tolerance.csv", tolerance)
    written(folder / "junit.xml", junit(contents))
    figures.equip(folder, store)
    pictures, specs = _charts(folder, contents, rows, store)
    written(folder / "validation.md", markdown.validation(contents, rows, pictures))
    written(folder / "figures.md", markdown.figures(contents, pictures))
    has_gallery = (folder / "gallery" / "gallery.html").exists()
    has_site = (folder / "site" / "index.html").exists()
    names = set()
    for name, text in replays.files(contents):
        written(folder / name, text)
        names.add(name)
    for name, text in html.pages(contents, rows, specs, has_gallery=has_gallery, has_site=has_site):
        written(folder / name, text)
        names.add(name)
    for path in (folder / "assets").iterdir():
        is_ours = index.is_part(path.name) or replays.is_replay(path.name)
        if is_ours and f"assets/{path.name}" not in names:
            removed(path)


def _clear(folder: Path, labels: set[str]) -> None:
    """Removes pages and pictures of instances that are not in the new report."""
    try:
        before = {
            sheet.label for sheet in sheets_in(folder) if isinstance(sheet, CaseSheet | Record)
        }
    except RefdemError:
        return  # no report here, or one that does not list its files
    for label in before - labels:
        removed(folder / "cases" / f"{page(label)}.html")
        removed(folder / "figures" / f"{page(label)}.svg")


def _charts(
    folder: Path, contents: Contents, rows: dict[str, list[Row]], store: Store | None
) -> tuple[set[str], dict[str, dict[str, str]]]:
    """Names of the pictures drawn in figures/, and the specifications of every page by kind."""
    everything = list(chain.from_iterable(rows.values()))
    # The charts of every page by kind; the page "" is the index.
    charts: dict[str, dict[str, chart_data.ChartData | None]] = {
        "": {"tolerance": chart_data.overview(contents, everything)}
    }
    for label, mine in rows.items():
        charts[label] = {
            "errors": chart_data.errors(contents, mine),
            "drifts": chart_data.drifts(contents, label),
            "costs": chart_data.costs(contents, mine),
        }
    specs: dict[str, dict[str, str]] = {}
    for label, of_page in charts.items():
        specs[label] = {kind: figures.specification(data) for kind, data in of_page.items() if data}
    drawn = {}
    for label, mine_specs in specs.items():
        # Costs hold times, which a committed file must not; curves over time are in the pages.
        for kind in ("tolerance", "errors"):
            if kind in mine_specs:
                if label:
                    name = f"{page(label)}.svg"
                else:
                    name = f"{kind}.svg"
                drawn[name] = mine_specs[kind]
    pictures = figures.pictures(list(drawn.values()), store)
    for name, picture in zip(drawn, pictures, strict=True):
        written(folder / "figures" / name, picture)
    return set(drawn), specs
