"""refdem init: writes a driver that works, to be changed into that of another program."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    folder: Annotated[Path, typer.Argument(help="Folder to which the files are written.")] = Path(
        "."
    ),
    language: Annotated[
        str,
        typer.Option(help="Language of the driver: python, c, cpp, fortran, javascript or rust."),
    ] = "python",
    name: Annotated[
        str, typer.Option(help="Name of the program; default: that of the folder.")
    ] = "",
) -> None:
    """Writes the files to start a gate for a program.

    These are a driver with springs, rotation and contact with friction, the helper file that it
    needs, a refdem.toml that explains every claim, and a workflow for GitHub.

    Example: refdem init mydem --language c
    """
    import shlex

    from refdem.cli.starter import name_of, next_commands, written
    from refdem.core.outside import one_line

    for path in written(language, name or name_of(folder), folder):
        print(f"wrote {one_line(str(path))}")
    print("The files work unchanged. Put your own code into the driver, and then run:")
    if folder.resolve() != Path.cwd():
        print(f"    cd {one_line(shlex.quote(str(folder)))}")
    for line in next_commands(language):
        print(f"    {line}")
