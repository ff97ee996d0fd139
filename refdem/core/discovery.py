"""Finding cases, checks and engines: one file each in its folder, or an entry point of another
package; an engine may also be a code that has a folder of its own (core/codes.py).
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any

from refdem.core import codes
from refdem.core.parameters import nearest, text_of
from refdem.errors import UsageError

if TYPE_CHECKING:
    from refdem.core.case import Canonical
    from refdem.core.check import Check
    from refdem.core.engine import Engine
    from refdem.core.truth import Truth

ROOT = Path(__file__).parents[1]
DESCRIBED = "external"
"""The module in engines/ that is no engine itself: it adapts any program that has a refdem.toml."""
WORD = re.compile(r"[a-z]+")
"""A word in lower case; spaces, hyphens and apostrophes stand between words."""


_HERE: "dict[str, Engine]" = {}
"""Engines that exist in this process only, by name (`engine_here`)."""


@contextmanager
def engine_here(engine: "Engine") -> Iterator[None]:
    """Within this context `engine(name)` finds the given object, an engine of this process only."""
    _HERE[engine.name] = engine
    try:
        yield
    finally:
        del _HERE[engine.name]


@cache
def _names(folder: str) -> tuple[str, ...]:
    """Module names in refdem/<folder>: files and small folders; underscores mark private ones."""
    modules = [
        path
        for path in sorted((ROOT / folder).iterdir())
        if path.suffix == ".py" or (path / "__init__.py").exists()
    ]
    return tuple(
        path.stem for path in modules if not path.name.startswith("_") and path.stem != DESCRIBED
    )


@cache
def _others() -> dict[str, dict[str, EntryPoint]]:
    """Entry points of other packages in `refdem.<folder>`, by folder and name.

    The metadata of all installed packages are read once for all folders.
    """
    of_all_packages = entry_points()
    return {
        folder: {point.name: point for point in of_all_packages.select(group=f"refdem.{folder}")}
        for folder in ("cases", "checks", "engines")
    }


def _load(folder: str, attribute: str, name: str) -> Any:
    """The object of the public id `name`: `attribute` of its module in refdem/<folder>, or that of
    an entry point.

    Raises UsageError with the nearest known name.
    """
    modules = {module.replace("_", "-"): module for module in _names(folder)}
    if name in modules:
        return getattr(import_module(f"refdem.{folder}.{modules[name]}"), attribute)
    entry_points_by_name = _others()[folder]
    if name in entry_points_by_name:
        return entry_points_by_name[name].load()
    others: list[str] = []
    if folder == "engines":
        others = list(codes.descriptions())
    hint = nearest(name, [*modules, *entry_points_by_name, *others])
    if folder == "engines":
        hint += f" ({codes.searched()})"
    if folder == "cases" and (about := cases_about(name)):
        hint = f"cases that are about it: {', '.join(about)}"
    raise UsageError(f"no {folder[:-1]} {name!r}; {hint}")


def names(folder: str) -> list[str]:
    """Ids of all `cases`, `checks` or `engines`, without importing them."""
    return sorted({*(module.replace("_", "-") for module in _names(folder)), *_others()[folder]})


def own_names(folder: str) -> list[str]:
    """Ids of the `cases`, `checks` or `engines` that are files of refdem itself."""
    return sorted(module.replace("_", "-") for module in _names(folder))


def has_others(folder: str) -> bool:
    """True if another package brings cases, checks or engines."""
    return bool(_others()[folder])


def package_of(folder: str, name: str) -> str | None:
    """The distribution of another package that brings the case, check or engine of that name, or
    None.
    """
    point = _others()[folder].get(name)
    if point is None or point.dist is None:
        return None
    return str(point.dist.name)


def case(name: str) -> "Canonical":
    """The case (or selection) of that id."""
    canonical: Canonical = _load("cases", "CASE", name)
    return canonical


def cases_about(text: str) -> list[str]:
    """Ids of the cases and selections that have all words of a text; none for a text without words.

    A case has a word if one of its id, of its title, of its `words` or of what happens in it
    begins with the word. A plural finds the singular.
    """
    wanted = [word.removesuffix("s") for word in WORD.findall(text.lower())]
    if not wanted:
        return []
    return [name for name in names("cases") if _has(name, wanted)]


def _has(name: str, wanted: list[str]) -> bool:
    """True if the case with this id has all of the words."""
    own_case = case(name)
    # A selection of cases has no motion of its own.
    motion = getattr(own_case, "motion", "")
    own = WORD.findall(" ".join((name, own_case.title, motion, *own_case.words)).lower())
    return all(any(word.startswith(beginning) for word in own) for beginning in wanted)


def check(name: str) -> "Check":
    """The check that has the given name."""
    check_object: Check = _load("checks", "CHECK", name)
    return check_object


def engine(name: str) -> "Engine":
    """The engine of that name, or the program that the refdem.toml at that path describes; the
    engine itself is not imported.

    A code of `codes.descriptions` is found by the name of its folder, unless an engine has it.
    """
    if name in _HERE:
        return _HERE[name]
    if name.endswith(".toml"):
        return _described(Path(name))
    if name not in names("engines"):
        description = codes.descriptions().get(name)
        if description is not None:
            return _described(description)
    engine_object: Engine = _load("engines", "ENGINE", name)
    return engine_object


def _described(path: Path) -> "Engine":
    """The program that a refdem.toml describes."""
    program: Engine = import_module(f"refdem.engines.{DESCRIBED}").load(path)
    return program


def truth_of(name: str, **given: Any) -> "Truth":
    """The certified truth of a case at the given parameters, each as text, a number or several:
    `truth_of("pendulum", theta0="1/3")`. A float stands for its exact value.
    """
    return case(name).at(**{key: text_of(value) for key, value in given.items()}).truth()
