"""refdem new: writes the files of a new case, check, element, engine or kernel."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    kind: Annotated[
        str, typer.Argument(help="What to add: case, check, element, engine or kernel.")
    ],
    name: Annotated[str, typer.Argument(help="Name in lower case, words joined by hyphens.")],
    package: Annotated[
        Path, typer.Option(help="Root of the source tree of refdem to which the files are written.")
    ] = Path("."),
) -> None:
    """Writes a small new case, check, element or engine.

    It works, has tests, and is a starting point for your own. A kernel can be written as well.

    Example: refdem new case bouncing-ball
    """
    from refdem.cli.skeleton import next_commands, written

    for path in written(kind, name, package):
        print(f"wrote {path}")
    print("The files work unchanged. Edit them, and then run:")
    for line in next_commands(kind, name):
        print(f"    {line}")
