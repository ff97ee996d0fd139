"""Closed forms of smooth flows, whose derivative by the start is known by differences, and whose S
is that of their equation.
"""

from abc import abstractmethod
from collections.abc import Sequence
from fractions import Fraction
from typing import Protocol

from flint import arb, arb_mat

from refdem.truth.balls import arb_of
from refdem.truth.closed_form import DISPLACEMENT, ClosedForm, per_precision
from refdem.truth.energy_growth import EnergyGrowth, Line
from refdem.truth.growth import CLOSED_BITS, Grows, Growth, PeriodicGrowth


class Equation(Protocol):
    """A motion by the equation that it solves, as a closed form needs it (validated_flow.py)."""

    def growth(self) -> Growth:
        """S of the motion, from the variational equation."""

    def readings_at(self, y: Sequence[arb]) -> arb_mat:
        """d quantity_i/scale_i over d state_j/scale_j at a state y."""


class SmoothFlow(ClosedForm):
    """A closed form whose state is among its quantities (`state`)."""

    def jacobian(self, t: Fraction) -> arb_mat:
        """d quantity_i(t)/scale_i over d start_j/scale_j by central differences, with `state` as
        the first rows.
        """
        columns = [self.scaled_changes(axis, arb_of(t)) for axis in range(len(self.state))]
        return arb_mat(
            [[column[i] for column in columns] for i in range(len(columns[0]))]
        ) / arb_of(2 * DISPLACEMENT)

    def scaled_changes(self, axis: int, t: arb) -> list[arb]:
        """Differences at t, each in its scale, of the two motions displaced along one coordinate.

        `state` first.
        """
        plus, minus = (displaced.evaluate(t) for displaced in self.pair(axis))
        names = [*self.state, *(name for name in plus if name not in self.state)]
        return [(plus[name] - minus[name]) / arb_of(self.scale[name]) for name in names]


class OfAnEquation(SmoothFlow):
    """A closed form whose S comes from motions beside it, or from the equation that it solves,
    integrated to a low precision.
    """

    @abstractmethod
    def equation(self) -> Equation:
        """The same motion by its equation, with the same quantities."""

    def period(self) -> arb | None:
        """The time after which the motion repeats, if errors then drift apart in proportion to time
        (PeriodicGrowth).
        """
        return self.constants().get("period")

    def line(self) -> Line | None:
        """The motion and those beside it in closed form; None where S comes from the equation."""
        return None

    def steepest(self) -> arb:
        """Bound of |f'| along the motion, if it has a `line`."""
        raise NotImplementedError

    def growth_bits(self) -> Sequence[int]:
        return CLOSED_BITS

    @per_precision
    def growth(self) -> Grows:
        line = self.line()
        if line is not None:
            place, speed = (self.scale[name] for name in self.state)
            return EnergyGrowth(line, place, speed, self.steepest(), self.equation().readings_at)
        first = self.equation().growth()
        period = self.period()
        if period is None:
            return first
        return PeriodicGrowth(first, period)
