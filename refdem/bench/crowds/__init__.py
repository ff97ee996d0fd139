"""Codes that move many spheres, to compare the cost of a step: one per file, each with a CROWD.
Their results are not judged.
"""

from importlib import import_module
from pathlib import Path

from refdem.bench.crowds._crowd import Crowd


def crowds() -> list[Crowd]:
    """The crowds whose packages are installed here, the reference first."""
    names = sorted(
        path.stem for path in Path(__file__).parent.glob("*.py") if not path.name.startswith("_")
    )
    installed: list[Crowd] = [import_module(f"refdem.bench.crowds.{name}").CROWD for name in names]
    return sorted(
        (crowd for crowd in installed if crowd.missing() is None),
        key=lambda crowd: not crowd.is_reference,
    )
