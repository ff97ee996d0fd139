"""Random parameters of settings: dyadic numbers, lists of them, and values computed from earlier
draws.

A draw is a function of the random generator and of the values of the rows above it.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np

Drawn = Mapping[str, Any]
"""Values by the names of their rows."""
Draw = Callable[[np.random.Generator, Drawn], Any]
Rows = tuple[tuple[str, Draw | str], ...]
"""Names of parameters, each with its draw or with its text, in the order in which they are drawn.

Of several rows with the same name the last one counts. A name that begins with _ is not a parameter
but an auxiliary value for the rows below.
"""


def parameters(rows: Rows, rng: np.random.Generator) -> dict[str, str]:
    """The parameters of some rows, as text."""
    drawn: dict[str, Any] = {}
    for name, draw in rows:
        if isinstance(draw, str):
            drawn[name] = draw
        else:
            drawn[name] = draw(rng, drawn)
    return {name: str(value) for name, value in drawn.items() if not name.startswith("_")}


def between(low: float, high: float, unit: int = 32) -> Draw:
    """A multiple of 1/unit in [low, high]."""
    first = int(low * unit)
    last = int(high * unit)
    return lambda rng, _: Fraction(int(rng.integers(first, last, endpoint=True)), unit)


def either(*values: Any) -> Draw:
    """One of these values, each as likely as the others."""
    return lambda rng, _: values[int(rng.integers(len(values)))]


def signed(low: float, high: float, unit: int = 32) -> Draw:
    """A multiple of 1/unit with a size in [low, high] and a random sign."""
    size = between(low, high, unit)

    def draw(rng: np.random.Generator, drawn: Drawn) -> Fraction:
        sign = int(rng.choice((-1, 1)))
        return Fraction(sign * size(rng, drawn))

    return draw


def listed(*draws: Draw) -> Draw:
    """Several numbers, with commas between them."""
    return lambda rng, drawn: ",".join(str(draw(rng, drawn)) for draw in draws)


def unequal(low: float, high: float) -> Draw:
    """Two numbers in random order: one in [low, high], and 1.5 to 2.5 times it."""
    small = between(low, high)
    factor = between(1.5, 2.5, 4)

    def draw(rng: np.random.Generator, drawn: Drawn) -> str:
        first = small(rng, drawn)
        both = [first, first * factor(rng, drawn)]
        if rng.integers(2):
            both.reverse()
        return ",".join(map(str, both))

    return draw


def box_moments(rng: np.random.Generator, drawn: Drawn) -> str:
    """Moments of inertia of a box with well separated sides, in any order."""
    sides = [between(length, length + 0.25)(rng, drawn) for length in (1, 2, 3)]
    squares = sum(side * side for side in sides)
    # J_i = (b^2 + c^2)/8 with the other two sides b and c, rounded to a multiple of 1/64.
    moments = [float(squares - side * side) for side in sides]
    return ",".join(str(Fraction(round(moments[i] * 8), 64)) for i in rng.permutation(3))


def computed(value: Callable[[Drawn], Any]) -> Draw:
    """A value computed from those of the rows above."""
    return lambda _, drawn: value(drawn)
