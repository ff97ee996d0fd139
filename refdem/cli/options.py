"""Options that several commands share, each with its help text."""

from typing import Annotated

import typer

from refdem.cli import completion
from refdem.errors import UsageError

Engines = Annotated[
    list[str] | None,
    typer.Option(
        autocompletion=completion.engines,
        help="Engines, codes, or paths to refdem.toml files; default: all installed engines.",
    ),
]
Settings = Annotated[list[str] | None, typer.Option(help="Parameter of the cases, name=value.")]
Jobs = Annotated[
    int | None, typer.Option(help="Number of worker processes; default: one per core.")
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help=(
            "Run the engines in the workers of the Dask scheduler at this address,"
            " tcp://HOST:PORT. --jobs is then the number of local processes, which prove truths."
        ),
    ),
]


def scheduler_address(given: str | None) -> str:
    """The given address of a scheduler, or "" if none was given.

    Raises UsageError for an empty address, which an unset shell variable would give.
    """
    if given is None:
        return ""
    if not given.strip():
        raise UsageError(
            "--scheduler is empty; expected the address that `dask scheduler` prints, as"
            " tcp://HOST:PORT, or no --scheduler for runs on this machine"
        )
    return given
