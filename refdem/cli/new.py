"""refdem new: writes the files of a new case, check, element, engine or kernel."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    kind: Annotated[str, typer.Argument(help="case, check, element, engine or kernel")],
    name: Annotated[str, typer.Argument(help="Small letters, words joined by hyphens.")],
    package: Annotated[
        Path, typer.Option(help="Root of the tree of refdem that gets the files.")
    ] = Path("."),
) -> None:
    """Writes a small one that works, with its tests, to be changed into the one that is wanted.

    Example: refdem new case bouncing-ball
    """
    from refdem.cli.skeleton import next_commands, written

    for path in written(kind, name, package):
        print(f"wrote {path}")
    print("The files work unchanged. Edit them, and then run:")
    for line in next_commands(kind, name):
        print(f"    {line}")
