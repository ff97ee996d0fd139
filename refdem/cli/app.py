"""The application: every module of this folder with a function named `command` is a command of that
file's name.
"""

from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    name="refdem",
    help="Verifies rigid-body and discrete element codes against certified truth.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(is_requested: bool) -> None:
    """Prints the version and ends, if it was requested."""
    if is_requested:
        from refdem import __version__

        print(f"refdem {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool,
        typer.Option("--version", help="Print the version.", callback=_version, is_eager=True),
    ] = False,
) -> None:
    """Verifies rigid-body and discrete element codes against certified truth."""


_FRAME = (
    "__init__",
    "app",
    "blessing",
    "completion",
    "options",
    "outputs",
    "progress",
    "skeleton",
    "starter",
    "step_rules",
    "summary",
    "without_effect",
)

for _path in sorted(Path(__file__).parent.glob("*.py")):
    if _path.stem not in _FRAME:
        app.command(_path.stem.removesuffix("_"))(import_module(f"refdem.cli.{_path.stem}").command)
