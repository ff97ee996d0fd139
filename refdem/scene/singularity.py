"""Where a force is not smooth, and the largest order that fixed steps can have across it.

A force that goes as |s|^n through s = 0 is not smooth there. A method of fixed steps does not look
for the zero, which then lies somewhere within a step. That step has an error of h^(n+2) in velocity
times time, whatever the order of the method, and one such step in each passage leaves an error of
order n + 1 (Hairer, Norsett and Wanner 1993, section II.6). A force that jumps has n = 0, one with
a kink n = 1. Measured: RK4 has 2.26 for n = 5/4, 2.57 for n = 3/2 and 3.08 for n = 2.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

JUMP = 0.0
"""Exponent of a force that jumps at a place: |s|^0."""
KINK = 1.0
"""Exponent of a force whose first derivative jumps: |s|."""
SQUARE = 2.0
"""Exponent of a force whose second derivative jumps: |s| s."""


class Singularity(NamedTuple):
    """A force that goes as |s|^exponent somewhere.

    `feature` is the scene's name for it, which `order_with` may declare.
    """

    exponent: float
    feature: str

    @property
    def order(self) -> float:
        """The largest order of fixed steps across it."""
        return self.exponent + 1.0

    @property
    def key(self) -> str:
        """The line of `refdem.toml` by which a method declares this order."""
        return f'order_with = {{ "{self.feature}" = {math.floor(self.order)} }}'


def sharpest_exponent(singularities: Iterable[Singularity]) -> float:
    """The exponent n of the force |s|^n through the sharpest of some singularities; infinite
    without one.
    """
    return min((singular.exponent for singular in singularities), default=math.inf)
