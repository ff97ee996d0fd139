"""refdem report: makes the report again from records, on any machine."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from refdem.errors import UsageError

if TYPE_CHECKING:
    from refdem.core.store import Store


def command(folder: Annotated[Path, typer.Argument(help="Folder with records.jsonl.")]) -> None:
    """Makes a report from its records.jsonl.

    Writes index.html, validation.md and junit.xml.

    A report that is up to date is not written again.

    Example: refdem report reports
    """
    from refdem.core.store import Store, default_path
    from refdem.report import is_up_to_date

    store = Store(default_path())
    if not is_up_to_date(folder, store):
        _write(folder, store)
    print(f"report: {folder / 'index.html'}")


def _write(folder: Path, store: "Store") -> None:
    """Makes the report of the records in a folder; raises UsageError if there are none."""
    from refdem.cli.outputs import refuse_unwritable
    from refdem.report import read_records, write_report

    sheets = read_records(folder)
    if not sheets:
        raise UsageError(
            f"{folder / 'records.jsonl'} is empty, so there is nothing to report; judge again with"
            " `refdem run`"
        )
    refuse_unwritable(folder, "FOLDER")
    write_report(folder, sheets, store)
