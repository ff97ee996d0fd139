"""refdem judge: judges trajectories that programs wrote elsewhere, and compares them with the
accepted baselines beside them.
"""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from refdem.cli.blessing import accept, refuse_without_why, verdict
from refdem.core.outside import one_line

if TYPE_CHECKING:
    from refdem.core.finding import Sheet
    from refdem.gate.baseline import Accepted


def command(
    folder: Annotated[
        Path,
        typer.Argument(
            help=(
                "Folder that `refdem export` wrote and to which the programs added their"
                " trajectories."
            )
        ),
    ],
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("refdem-report"),
    bless: Annotated[
        bool,
        typer.Option(
            "--bless",
            help=(
                "Accept these findings as the baseline, FOLDER/NAME-baseline.jsonl for each"
                " program."
            ),
        ),
    ] = False,
    why: Annotated[
        str, typer.Option(help="With --bless: the reason why these findings are accepted.")
    ] = "",
) -> None:
    """Judges trajectories of programs that ran elsewhere.

    They are read from a folder that `refdem export` wrote. A missing trajectory is an error.

    If the folder contains a baseline, written with --bless, findings that are worse than in the
    baseline or are missing fail, and new ones are listed, as in `refdem gate`.

    Example: refdem judge to-run --out report
    """
    from refdem.cli.outputs import refuse_unwritable, refuse_unwritable_file
    from refdem.cli.progress import Progress
    from refdem.cli.summary import exit_status, lines
    from refdem.core.store import Store, default_path
    from refdem.gate import elsewhere
    from refdem.planning.exchange import judged
    from refdem.report import write_report

    refuse_without_why(why, is_requested=bless)
    refuse_unwritable(out)
    # A baseline that cannot be read is refused before anything is judged.
    baselines = elsewhere.baselines(folder)
    accepted = elsewhere.accepted(baselines)
    if bless:
        for path in baselines.values():
            refuse_unwritable_file(path, "FOLDER")
    store = Store(default_path())
    sheets = judged(folder, store, Progress())
    if not bless:
        sheets = elsewhere.against_baselines(sheets, accepted)
    write_report(out, sheets, store)
    print("\n".join(lines(sheets)))
    if bless:
        for name, path in baselines.items():
            accept(path, name, elsewhere.of_program(sheets, name), why)
    else:
        _print_additions(sheets, accepted)
        _print_absent(folder, [path for name, path in baselines.items() if name not in accepted])
    status = exit_status(sheets)
    compared = list(accepted)
    if bless:
        compared = list(baselines)
    if compared:
        print(verdict(compared, status))
    print(f"report: {out / 'index.html'}")
    raise typer.Exit(status)


def _print_additions(sheets: "list[Sheet]", accepted: "dict[str, dict[str, Accepted]]") -> None:
    """Prints the findings that are not in the baseline of their program."""
    from refdem.gate import baseline, elsewhere

    for name, findings in accepted.items():
        for line in baseline.additions(findings, elsewhere.of_program(sheets, name)):
            print(one_line(f"{line}, which the baseline does not contain"))


def _print_absent(folder: Path, paths: list[Path]) -> None:
    """Prints a line for each baseline that does not exist yet."""
    for path in paths:
        line = (
            f"there is no baseline {path} yet, so nothing is compared with one; accept these"
            f" findings with: refdem judge {shlex.quote(str(folder))} --bless --why"
            ' "first baseline"'
        )
        print(one_line(line))
