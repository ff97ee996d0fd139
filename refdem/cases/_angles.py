"""Directions of angles as they are written, of however many turns."""

from fractions import Fraction
from typing import Any

import numpy as np

from refdem.core.parameters import Parameters
from refdem.truth.exact import number

TURN = Fraction("6.283185307179586476925286766559005768394338798750211641949889")
"""2 pi, to so many digits that 1e30 turns are known to 1e-29 rad."""


def sine_and_cosine(p: Parameters, name: str) -> tuple[Any, Any]:
    """Sine and cosine of a parameter that is an angle [rad], or a vector of angles.

    Whole turns are taken off the exact angle before it is a double: the double of 1000 rad may be
    off by 1e-13 rad, that of what is left by 2e-16.
    """
    exact = p[name]
    theta: Any
    if isinstance(exact, tuple):
        theta = np.array([_within_a_turn(angle) for angle in exact])
    else:
        theta = _within_a_turn(number(p, name))
    return np.sin(theta), np.cos(theta)


def _within_a_turn(angle: Fraction) -> float:
    """The angle [rad] less whole turns, in [-pi, pi]."""
    return float(angle - round(angle / TURN) * TURN)
