"""Closed forms of x'' = a(x) from rest at x = amplitude: their derivative by the start from their
own rates.

A start with a small velocity e is the start at rest, e/a(amplitude) later: so d(x, v)(t)/d v(0) =
(v(t), a(x(t)))/a(amplitude). The derivative by the amplitude is a central difference of the closed
form.
"""

from abc import abstractmethod
from copy import copy
from fractions import Fraction
from typing import Self

from flint import arb, arb_mat

from refdem.truth.balls import arb_of
from refdem.truth.closed_form import DISPLACEMENT
from refdem.truth.smooth_flow import SmoothFlow


class FromRest(SmoothFlow):
    """x [m] and v [m/s] at t of the motion that starts at rest at `amplitude` [m], which is not
    zero.
    """

    state = ("x", "v")
    amplitude: Fraction

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

    def rates(self, t: Fraction) -> tuple[arb, arb]:
        """The derivatives of x(t) and v(t) by v(0) [s, 1]."""
        state = self.evaluate(arb_of(t))
        first = self.acceleration(arb_of(self.amplitude))
        return state["v"] / first, self.acceleration(state["x"]) / first

    def jacobian(self, t: Fraction) -> arb_mat:
        """d(x, v)(t)/scale over d(x, v)(0)/scale."""
        by_place = [
            change / arb_of(2 * DISPLACEMENT) for change in self.scaled_changes(0, arb_of(t))
        ]
        speed = arb_of(self.scale["v"])
        by_speed = [
            rate * speed / arb_of(self.scale[name])
            for name, rate in zip(self.state, self.rates(t), strict=True)
        ]
        return arb_mat([list(row) for row in zip(by_place, by_speed, strict=True)])
