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
    """Writes the verification manual as Markdown and HTML.

    The page of each case has its statement, the method of proof, the independent method that
    confirms it, the certified digits, the checks, and corrections to the source. A table lists the
    items of the source chapter.

    Example: refdem manual reports
    """
    import refdem
    from refdem.cli.outputs import refuse_unwritable
    from refdem.gallery import gallery
    from refdem.manual import inputs
    from refdem.manual.chapter import lines
    from refdem.manual.pages import pages
    from refdem.planning.kept_truth import truth_folder
    from refdem.report import write_manual

    refuse_unwritable(folder / "manual", "FOLDER")
    chapter = list(lines(gallery.names()))
    made = list(pages(truth_folder()))
    write_manual(folder, made, version=refdem.__version__, chapter=chapter)
    (folder / "manual" / inputs.NAME).write_text(inputs.text_of(inputs.digests(truth_folder())))
    print(f"manual: {folder / 'manual' / 'index.html'}")
