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
    numbered = [stem.replace("_", ".") for stem in stems if stem[0].isdigit()]
    others = [stem.replace("_", "-") for stem in stems if not stem[0].isdigit()]
    return sorted(numbered, key=_place_in_chapter) + sorted(others)


def _place_in_chapter(name: str) -> list[int]:
    """The numbers of a figure's id, so that 1.5 comes before 1.12."""
    return [int(part) for part in name.split(".")]


def refuse_unknown(name: str) -> None:
    """Raises UsageError with the nearest id unless a figure has that id."""
    if name not in names():
        raise UsageError(f"no figure {name!r}; {nearest(name, names())}")


def figure(name: str) -> Figure:
    """The figure of that id, computed now; raises UsageError with the nearest id."""
    refuse_unknown(name)
    stem = name.replace(".", "_").replace("-", "_")
    with recorded() as commands:
        drawn: Figure = import_module(f"refdem.gallery.figures.fig_{stem}").figure()
    return replace(drawn, commands=(f"refdem gallery {name}", *dict.fromkeys(commands)))


def figures(chosen: Iterable[str] = ()) -> list[Figure]:
    """The figures of these ids, or all of them; raises UsageError before any is made."""
    ids = list(chosen) or names()
    for name in ids:
        refuse_unknown(name)
    return [figure(name) for name in ids]
