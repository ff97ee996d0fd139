"""Exact arithmetic of vectors (3,) and quaternions (w, x, y, z), and random fractions; it shares no
line with refdem.
"""

import random
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any


def text(values: Iterable[Any]) -> str:
    """The values as the text of a parameter, with commas between them."""
    return ",".join(str(value) for value in values)


def cross(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """The vector product a x b."""
    x = a[1] * b[2] - a[2] * b[1]
    y = a[2] * b[0] - a[0] * b[2]
    z = a[0] * b[1] - a[1] * b[0]
    return [x, y, z]


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """The scalar product a . b."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def hamilton(p: Sequence[Any], q: Sequence[Any]) -> list[Any]:
    """Hamilton's product p q, component by component."""
    (a, b, c, d) = p
    (e, f, g, h) = q
    w = a * e - b * f - c * g - d * h
    x = a * f + b * e + c * h - d * g
    y = a * g - b * h + c * e + d * f
    z = a * h + b * g - c * f + d * e
    return [w, x, y, z]


class RandomFractions:
    """Random fractions whose denominators are drawn from `least` to `most`."""

    def __init__(self, rng: random.Random, least: int = 5, most: int = 13) -> None:
        self.rng = rng
        self.denominators = (least, most)

    def between(self, low: int, high: int) -> Fraction:
        """n/d with n drawn from `low` to `high`."""
        return Fraction(self.rng.randint(low, high), self.rng.randint(*self.denominators))

    def list_of(self, count: int, low: int, high: int) -> list[Fraction]:
        """`count` such fractions."""
        return [self.between(low, high) for _ in range(count)]
