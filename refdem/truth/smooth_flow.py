"""Closed forms of smooth autonomous flows: S from every earlier sample, by Jacobians of the flow.

S(t) of the base is the growth of an error made at t = 0. An error made at s grows by D(t) D(s)^-1, D being the Jacobian from 0:
a pendulum let go near the top answers little to its first velocity, yet much to an error made at the bottom.
"""

from collections.abc import Sequence
from fractions import Fraction

from flint import arb, arb_mat

from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_form import DISPLACEMENT, SENSITIVITY_BITS, ClosedForm

ORIGINS = 32
"""At how many of the samples, evenly chosen, an error may be made."""
BEYOND_DOUBLES = 1e20
"""Once S is this large no double has a digit left, and the inverse of D would lose those of the differences."""


class SmoothFlow(ClosedForm):
    """A closed form whose state is among its quantities (`state`) and whose flow depends on the time elapsed only."""

    def jacobian(self, t: Fraction) -> arb_mat:
        """d quantity_i(t)/scale_i over d start_j/scale_j by central differences, with `state` as the first rows."""
        columns = [self.scaled_changes(axis, arb_of(t)) for axis in range(len(self.state))]
        found = arb_mat([[column[i] for column in columns] for i in range(len(columns[0]))]) / arb_of(2 * DISPLACEMENT)
        self.kept["jacobian", t] = found
        return found

    def scaled_changes(self, axis: int, t: arb) -> list[arb]:
        """Differences at t, each in its scale, of the two motions displaced along one coordinate; `state` first."""
        plus, minus = (displaced.evaluate(t) for displaced in self.pair(axis))
        names = [*self.state, *(name for name in plus if name not in self.state)]
        return [(plus[name] - minus[name]) / arb_of(self.scale[name]) for name in names]

    def sizes(self, jacobian: arb_mat) -> list[arb]:
        """How much each quantity may change when every coordinate moves by its scale: the row sums."""
        return [sum((abs(x) for x in row), arb(0)) for row in jacobian.table()]

    def response(self, t: Fraction) -> list[arb]:
        return self.sizes(self.jacobian(t))

    def sensitivities(self, times: Sequence[Fraction]) -> list[float]:
        """S at every time: the largest growth of an error made at t = 0 or at an earlier one of (up to 32 of) the times."""
        grown = [self.sensitivity(t) for t in times]
        every = max(1, -(-len(times) // ORIGINS))
        with precision(SENSITIVITY_BITS):
            for first in range(0, len(times), every):
                if grown[first] < BEYOND_DOUBLES:
                    self._grow(grown, times, first)
        return grown

    def _grow(self, grown: list[float], times: Sequence[Fraction], first: int) -> None:
        """Raises what is smaller than the growth of errors made at times[first]."""
        whole = self.kept["jacobian", times[first]].mid()
        back = arb_mat(whole.table()[: whole.ncols()]).inv()
        for i in range(first + 1, len(times)):
            rows = self.sizes(self.kept["jacobian", times[i]].mid() * back)
            grown[i] = max(grown[i], *(float(row.upper()) for row in rows))
