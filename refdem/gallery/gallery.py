"""Finding the figures, and making them with the commands that show their runs."""

from collections.abc import Iterable
from dataclasses import replace
from importlib import import_module
from pathlib import Path

from refdem.core.figure import Figure
from refdem.core.parameters import nearest
from refdem.errors import UsageError
from refdem.gallery.runs import recorded

FOLDER = Path(__file__).with_name("figures")


def names() -> list[str]:
    """Ids of all figures: those of the chapter (1.15) in its order, then the others (co-4)."""
    stems = [path.stem.removeprefix("fig_") for path in FOLDER.glob("fig_*.py")]
    numbered = sorted(
        (s.replace("_", ".") for s in stems if s[0].isdigit()),
        key=lambda name: [int(part) for part in name.split(".")],
    )
    return numbered + sorted(s.replace("_", "-") for s in stems if not s[0].isdigit())


def refuse_unknown(name: str) -> None:
    """Raises UsageError with the nearest id unless a figure has that id."""
    if name not in names():
        raise UsageError(f"no figure {name!r}; {nearest(name, names())}")


def figure(name: str) -> Figure:
    """The figure of that id, computed now; raises UsageError with the nearest id."""
    refuse_unknown(name)
    with recorded() as commands:
        made: Figure = import_module(
            f"refdem.gallery.figures.fig_{name.replace('.', '_').replace('-', '_')}"
        ).figure()
    return replace(made, commands=(f"refdem gallery {name}", *dict.fromkeys(commands)))


def figures(chosen: Iterable[str] = ()) -> list[Figure]:
    """The figures chosen, or all of them."""
    asked = list(chosen) or names()
    for name in asked:
        refuse_unknown(name)
    return [figure(name) for name in asked]
