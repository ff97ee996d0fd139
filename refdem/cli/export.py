"""refdem export: writes the requests of a campaign for programs that run elsewhere."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from refdem.cli import completion
from refdem.core.outside import one_line
from refdem.errors import UsageError

if TYPE_CHECKING:
    from refdem.engines.external import External


def command(
    folder: Annotated[
        Path, typer.Argument(help="Folder for the requests; each run gets a subfolder.")
    ],
    case: Annotated[
        list[str] | None,
        typer.Argument(
            autocompletion=completion.cases,
            help=(
                "Cases; default: those of the table [gate] of refdem.toml, or all that the"
                " program supports."
            ),
        ),
    ] = None,
    engine: Annotated[
        list[Path] | None, typer.Option(help="Path to the refdem.toml of a program.")
    ] = None,
    levels: Annotated[
        int | None,
        typer.Option(
            help="Number of refinement levels; default: that of the table [gate] of refdem.toml.",
            min=1,
            max=10,
        ),
    ] = None,
) -> None:
    """Writes requests for programs that run elsewhere.

    This serves, for example, programs on a batch system.

    Run the program in each folder that FOLDER/runs.txt lists, so that it writes trajectory.csv
    there; then run `refdem judge FOLDER`. A program with `serve = true` runs once, in FOLDER, and
    reads its requests from a file there. Some runs continue from the final state of others: when
    the trajectories of these exist, a second export into the same folder writes the requests that
    follow.

    Example: refdem export to-run free-rigid-body --engine refdem.toml
    """
    from refdem.cli.outputs import refuse_unwritable
    from refdem.cli.progress import Progress
    from refdem.core.parameters import labelled
    from refdem.core.store import Store, default_path
    from refdem.engines.external import load
    from refdem.gate.gate import supported
    from refdem.planning.exchange import exported
    from refdem.planning.specification import Entry

    tomls = engine or [Path("refdem.toml")]
    programs = [load(path) for path in tomls]
    named = case or list(
        dict.fromkeys(label for program in programs for label in program.description.gate.cases)
    )
    entries = [Entry(*labelled(label)) for label in named] or [
        entry for program in programs for entry in supported(program)
    ]
    entries = [entry for n, entry in enumerate(entries) if entry not in entries[:n]]
    if not entries:
        raise UsageError(
            "no case is supported by any of the programs; name features in engine.supports"
        )
    refuse_unwritable(folder, "FOLDER")
    most = levels or max(program.description.gate.levels for program in programs)
    waiting = exported(folder, tomls, entries, most, Store(default_path()), Progress())
    if not waiting:
        print(f"nothing is left to run; judge with: refdem judge {folder}")
        return
    print(
        f"{len(waiting)} runs to make, in the folders that {folder / 'runs.txt'} lists; in each of"
        " them:"
    )
    for program in programs:
        print(f"    {program.name}: {one_line(command_of(program, folder))}")


def command_of(program: "External", folder: Path) -> str:
    """What runs a program elsewhere; one that stays alive reads all of its requests from a file."""
    from refdem.planning.exchange import requests_of

    table = program.description.engine
    if not table.serve:
        return shlex.join(table.command)
    words = shlex.join(map(program.program.placed, table.command))
    requests = shlex.quote(requests_of(program.name))
    answers = shlex.quote(f"{program.name}-answers.jsonl")
    return f"once, in {folder}: {words} < {requests} > {answers}"
