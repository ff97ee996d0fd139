"""refdem manual: the verification manual, a page a case."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    folder: Annotated[
        Path,
        typer.Argument(
            help="Folder of the report; the pages are written to its subfolder manual/."
        ),
    ] = Path("reports"),
) -> None:
    """Writes statement, method, witness, digits, checks and settled slips of every case, as
    Markdown and HTML.

    Example: refdem manual reports
    """
    import refdem
    from refdem.campaign.kept_truth import truth_folder
    from refdem.cli.outputs import refuse_unwritable
    from refdem.manual import inputs
    from refdem.manual.pages import pages
    from refdem.report import write_manual

    refuse_unwritable(folder / "manual", "FOLDER")
    write_manual(folder, list(pages(truth_folder())), version=refdem.__version__)
    (folder / "manual" / inputs.NAME).write_text(inputs.text_of(inputs.digests(truth_folder())))
    print(f"manual: {folder / 'manual' / 'index.html'}")
