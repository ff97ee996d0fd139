"""Vectors (3,) of any numbers that add and multiply: exact ones, balls, and numbers of a trace."""

from collections.abc import Sequence
from typing import Any

Vector = Sequence[Any]


def dot(a: Vector, b: Vector) -> Any:
    """The scalar product a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> list[Any]:
    """The vector product a x b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
