"""refdem judge: judges trajectories that programs wrote elsewhere."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    folder: Annotated[
        Path, typer.Argument(help="Folder that `refdem export` wrote, with trajectories in it.")
    ],
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("refdem-report"),
) -> None:
    """Judges the trajectories in a folder that `refdem export` wrote; one that is missing is an
    error.

    Example: refdem judge to-run --out report
    """
    from refdem.cli.outputs import refuse_unwritable
    from refdem.cli.progress import Progress
    from refdem.cli.summary import exit_status, lines
    from refdem.core.store import Store, default_path
    from refdem.planning.exchange import judged
    from refdem.report import write_report

    refuse_unwritable(out)
    store = Store(default_path())
    sheets = judged(folder, store, Progress())
    write_report(out, sheets, store)
    print("\n".join(lines(sheets)))
    print(f"report: {out / 'index.html'}")
    raise typer.Exit(exit_status(sheets))
