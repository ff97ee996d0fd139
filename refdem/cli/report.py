"""refdem report: makes the report again from records, on any machine."""

from pathlib import Path
from typing import Annotated

import typer

from refdem.errors import UsageError


def command(folder: Annotated[Path, typer.Argument(help="Folder with records.jsonl.")]) -> None:
    """Makes index.html, validation.md and junit.xml again from records.jsonl.

    Example: refdem report reports
    """
    from refdem.cli.outputs import refuse_unwritable
    from refdem.report import read_records, write_report

    sheets = read_records(folder)
    if not sheets:
        raise UsageError(
            f"{folder / 'records.jsonl'} is empty, so there is nothing to report; judge again with"
            " `refdem run`"
        )
    refuse_unwritable(folder, "FOLDER")
    write_report(folder, sheets)
    print(f"report: {folder / 'index.html'}")
