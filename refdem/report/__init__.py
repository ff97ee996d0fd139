"""The report: a function of core's records, and nothing else; also the records themselves, as lines
and as tables.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from refdem.core.figure import Figure
    from refdem.core.finding import Sheet
    from refdem.core.manual import ChapterLine, ManualPage
    from refdem.core.store import Store
    from refdem.report.tables import Tables


def write_records(folder: Path, sheets: "Iterable[Sheet]") -> None:
    """Writes `records.jsonl`, a sheet a line; raises StoreError."""
    from refdem.report.files import written
    from refdem.report.jsonl import RECORDS, lines

    written(Path(folder) / RECORDS, lines(sheets))


def read_records(folder: Path) -> "list[Sheet]":
    """The sheets of `records.jsonl`; raises StoreError if there is none, UsageError that names a
    malformed line.
    """
    from refdem.report.jsonl import sheets_in

    return sheets_in(Path(folder))


def write_report(folder: Path, sheets: "Sequence[Sheet]", store: "Store | None" = None) -> None:
    """Writes the whole report: pages, Markdown with figures, JUnit, CSV and records; `store` keeps
    charts for next time.

    With a store, nothing is written if the folder already holds the unmodified report of the same
    findings. Raises StoreError if the folder cannot be written.
    """
    from refdem.report import unchanged

    if store and unchanged.is_current(Path(folder), sheets, store):
        return
    from refdem.report.writing import write_everything

    write_everything(Path(folder), sheets, store)
    if store:
        unchanged.keep_state(Path(folder), sheets, store)


def is_up_to_date(folder: Path, store: "Store") -> bool:
    """True if the report in a folder is up to date with the records there.

    The store holds what is compared: digests of the records, of the code and of the templates, and
    the size and modification time of every file. The records are not parsed.
    """
    from refdem.report import unchanged

    return unchanged.is_up_to_date(Path(folder), store)


def write_manual(
    folder: Path,
    pages: "Sequence[ManualPage]",
    *,
    version: str,
    chapter: "Sequence[ChapterLine]" = (),
) -> None:
    """Writes the verification manual into `folder`/manual, Markdown and HTML, with the table of the
    source chapter; raises StoreError if it cannot be written.
    """
    from refdem.report.manual import write_pages

    write_pages(Path(folder), pages, version=version, chapter=chapter)


def write_gallery(
    folder: Path,
    figures: "Sequence[Figure]",
    *,
    version: str,
    store: "Store | None" = None,
    every: "Sequence[str]" = (),
) -> None:
    """Writes gallery.html, gallery.md and one picture per figure into `folder`.

    Figures that the folder already holds are kept if their ids are among `every`.

    Raises StoreError if it cannot be written.
    """
    from refdem.report.gallery import write_figures

    write_figures(Path(folder), figures, version=version, store=store, every=every)


def write_junit(path: Path, sheets: "Iterable[Sheet]") -> None:
    """Writes the findings as JUnit XML; raises StoreError if the file cannot be written."""
    from refdem.report.contents import contents_of
    from refdem.report.files import written_to
    from refdem.report.junit import junit

    written_to(Path(path), junit(contents_of(sheets)), "--junit")


def write_sarif(path: Path, sheets: "Iterable[Sheet]", described_in: Path) -> None:
    """Writes the findings that close a gate as SARIF, at the refdem.toml that describes the
    program; raises StoreError if the file cannot be written.
    """
    from refdem.report.contents import contents_of
    from refdem.report.files import written_to
    from refdem.report.sarif import sarif

    written_to(Path(path), sarif(contents_of(sheets), described_in), "--sarif")


def records(folder: Path | str) -> "Tables":
    """DataFrames `findings`, `tolerance` and `levels` of the report in a folder."""
    from refdem.report.tables import tables

    return tables(read_records(Path(folder)))
