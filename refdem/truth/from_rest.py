"""Closed forms of x'' = a(x) from rest at x = amplitude: their derivative by the start from their
own rates.

Theorem: a start with a small velocity e is the start at rest, e/a(amplitude) later, so that
d(x, v)(t)/d v(0) = (v(t), a(x(t)))/a(amplitude). The derivative by the amplitude is a central
difference of the closed form.

Hypothesis: a(amplitude) is not zero, so that the start is no equilibrium. A family that has
equilibria answers for them in its own `rates`.
"""

from collections.abc import Mapping
from fractions import Fraction
from typing import Any, Protocol, Self, runtime_checkable

from flint import arb, arb_mat

from refdem.truth.balls import arb_of
from refdem.truth.closed_form import DISPLACEMENT
from refdem.truth.smooth_flow import scaled_changes


@runtime_checkable
class FromRest(Protocol):
    """A closed form whose motion starts at rest at `amplitude` [m], which is not zero; its `state`
    is (x, v).
    """

    @property
    def amplitude(self) -> Fraction: ...

    @property
    def state(self) -> tuple[str, ...]: ...

    @property
    def scale(self) -> Mapping[str, Fraction]: ...

    @property
    def kept(self) -> dict[Any, Any]: ...

    def displaced(self, axis: int, amount: Fraction, /) -> Self: ...

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The quantities x [m] and v [m/s] at t."""

    def acceleration(self, x: arb) -> arb:
        """The acceleration a(x) [m/s^2] at position x."""

    def rates(self, t: Fraction) -> tuple[arb, arb]:
        """d(x, v)(t)/d v(0) [s, 1]."""


def rates_from_rest(form: FromRest, t: Fraction) -> tuple[arb, arb]:
    """The `rates` where the start is no equilibrium: (v(t), a(x(t)))/a(amplitude)."""
    state = form.evaluate(arb_of(t))
    first = form.acceleration(arb_of(form.amplitude))
    return state["v"] / first, form.acceleration(state["x"]) / first


def derivative_from_rest(form: FromRest, t: Fraction) -> arb_mat:
    """The derivative (2, 2) of x and v at t by those at the start, all in scales: columns by
    amplitude and by speed. It is the method `jacobian` of a closed form.
    """
    # d(x, v)(t)/dA = ((x, v)(t; A + d) - (x, v)(t; A - d))/(2 d), d = DISPLACEMENT scales of x.
    changes = scaled_changes(form, 0, arb_of(t))
    by_amplitude = [change / arb_of(2 * DISPLACEMENT) for change in changes]
    scale_of_v = arb_of(form.scale["v"])
    # The derivative by v(0), of a quantity q in scales: dq/dv(0) scale(v)/scale(q).
    by_speed = [
        rate * scale_of_v / arb_of(form.scale[name])
        for name, rate in zip(form.state, form.rates(t), strict=True)
    ]
    return arb_mat([list(row) for row in zip(by_amplitude, by_speed, strict=True)])
