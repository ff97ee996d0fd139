"""Closed forms of x'' = a(x) from rest at x = amplitude: their derivative by the start from their
own rates.

Theorem: a start with a small velocity e is the start at rest, e/a(amplitude) later, so that
d(x, v)(t)/d v(0) = (v(t), a(x(t)))/a(amplitude). The derivative by the amplitude is a central
difference of the closed form.

Hypothesis: a(amplitude) is not zero, so that the start is no equilibrium. A family that has
equilibria answers for them in its own `rates`.
"""

from abc import ABC, abstractmethod
from copy import copy
from fractions import Fraction
from typing import Any, Self

from flint import arb, arb_mat

from refdem.truth.balls import Guarded, arb_of
from refdem.truth.closed_form import DISPLACEMENT
from refdem.truth.smooth_flow import scaled_changes


class FromRest(Guarded, ABC):
    """A part of closed forms whose motion starts at rest at `amplitude` [m], which is not zero: the
    displacement of the start, and the derivative of x [m] and v [m/s] by it.

    `state` is (x, v).
    """

    state: tuple[str, ...]
    amplitude: Fraction
    kept: dict[Any, Any]

    @abstractmethod
    def evaluate(self, t: arb) -> dict[str, arb]:
        """The quantities x [m] and v [m/s] at t."""

    @abstractmethod
    def acceleration(self, x: arb) -> arb:
        """The acceleration a(x) [m/s^2] at position x."""

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The motion from a neighbouring amplitude; ValueError for a start that is not at rest."""
        if axis != 0:
            raise ValueError(
                "a start that moves is no start from rest; its effect follows from the rates"
            )
        other = copy(self)
        other.kept = {}
        other.amplitude = self.amplitude + amount
        return other

    @abstractmethod
    def rates(self, t: Fraction) -> tuple[arb, arb]:
        """d(x, v)(t)/d v(0) [s, 1]."""

    def rates_of_the_motion(self, t: Fraction) -> tuple[arb, arb]:
        """`rates` where the start is no equilibrium: (v(t), a(x(t)))/a(amplitude)."""
        state = self.evaluate(arb_of(t))
        first = self.acceleration(arb_of(self.amplitude))
        return state["v"] / first, self.acceleration(state["x"]) / first

    def jacobian(self, t: Fraction) -> arb_mat:
        """The derivative (2, 2) of x and v at t by those at the start, all in scales: columns by
        amplitude and by speed.
        """
        form: Any = self
        changes = scaled_changes(form, 0, arb_of(t))
        by_amplitude = [change / arb_of(2 * DISPLACEMENT) for change in changes]
        scale_of_v = arb_of(form.scale["v"])
        by_speed = [
            rate * scale_of_v / arb_of(form.scale[name])
            for name, rate in zip(self.state, self.rates(t), strict=True)
        ]
        return arb_mat([list(row) for row in zip(by_amplitude, by_speed, strict=True)])
