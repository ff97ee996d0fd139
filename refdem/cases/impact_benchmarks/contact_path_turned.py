"""The contact path once more, the whole pair turned in space by a rational rotation: the force
turns with it.
"""

from fractions import Fraction
from typing import Any

from refdem.cases.impact_benchmarks._path import Path
from refdem.cases.impact_benchmarks.contact_path import NUMBERS

THIRD = Fraction(1, 3)


class TurnedPath(Path):
    """The contact path in rotated axes, which are the columns of TURN."""

    frame: Any = tuple(
        tuple(THIRD * x for x in row) for row in ((2, -1, 2), (2, 2, -1), (-1, 2, 2))
    )


MEMBER = TurnedPath("Prescribed path of a contact, turned", NUMBERS)
