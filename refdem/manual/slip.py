"""What a slip of the source chapter is made of, and how the numbers that settle it are written."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from refdem.core.truth import Ball

Measured = tuple[tuple[str, str], ...]
"""Lines of a measurement: what was measured, and the number found."""


@dataclass(frozen=True, kw_only=True)
class KnownSlip:
    """A slip: the cases that it concerns, where it is in the chapter, what the chapter says, what
    holds, and the measurement that settles it.
    """

    cases: tuple[str, ...]
    where: str
    says: str
    holds: str
    measure: Callable[[], Measured]


def vector_of(balls: Mapping[str, Ball], name: str, axes: str) -> np.ndarray:
    """The middles of the certified components of a vector, `name.axis` for every axis."""
    return np.array([float(balls[f"{name}.{axis}"].mid) for axis in axes])


def phase_point(balls: Mapping[str, Ball]) -> tuple[float, float]:
    """The middles of the certified place [m] and velocity [m/s]."""
    return float(balls["x"].mid), float(balls["v"].mid)


def norm(values: np.ndarray) -> float:
    """The Euclidean length of a vector (n,)."""
    return float(np.linalg.norm(values))


def number(value: float) -> str:
    """Six significant digits; what is round-off is shown as 0."""
    if abs(value) < 1e-14:
        return "0"
    return f"{value:.6g}"


def vector(values: np.ndarray) -> str:
    """The components of a vector (n,), each with six significant digits, as (x, y, z)."""
    return f"({', '.join(number(float(value)) for value in values)})"
