"""A Truth by validated integration: quantities of the state as balls, S(t) from the variational equation."""

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from fractions import Fraction
from typing import Any, Self

from flint import arb, arb_mat, ctx

from refdem.truth.balls import arb_of
from refdem.truth.closed_form import Size
from refdem.truth.smooth_flow import SmoothFlow
from refdem.truth.validated_ivp.field import Field, Program, traced
from refdem.truth.validated_ivp.integration import Integration

Quantities = Callable[[Sequence[Any]], Mapping[str, Any]]
"""Quantities by name of a state, by the operations of a field; the names of `state` among them."""


class ValidatedFlow(SmoothFlow):
    """The solution of y' = field(y), y(0) = start, for t >= 0.

    `start` has, for each coordinate, an exact number, or a function that gives its ball at the current precision (the cosine of a
    parameter). `moved` has the coordinates of the start that S displaces and `state`, one for each, the quantities in whose scales
    they are displaced. The precision is doubled until every radius is at most its target; pieces are kept for each precision.
    """

    method = "validated integration: Taylor series on proved complex discs, Cauchy remainder, Lohner frame (refdem/truth/validated_ivp)"
    witness = "none"

    def __init__(
        self,
        field: Field,
        start: Sequence[Fraction | Callable[[], arb]],
        quantities: Quantities,
        scale: Mapping[str, Size],
        *,
        state: Sequence[str],
        moved: Sequence[int],
        digits: int = 40,
    ) -> None:
        super().__init__(scale, digits=digits)
        self.field, self.begin, self.quantities = field, list(start), quantities
        self.state, self.moved = tuple(state), tuple(moved)
        self.names: list[str] = []
        outputs, slopes = traced(self.listed, len(self.begin))
        self.values, self.slopes = Program(outputs), Program([entry for row in slopes for entry in row])

    def listed(self, y: Sequence[Any]) -> list[Any]:
        """The quantities of a state one after another, as `names` lists them."""
        found = self.quantities(y)
        self.names = list(found)
        return list(found.values())

    def integration(self) -> Integration:
        """The solution at the current precision."""
        if ("integration", ctx.prec) not in self.kept:
            self.kept["integration", ctx.prec] = Integration(self.field, self.first, ctx.prec)
        found: Integration = self.kept["integration", ctx.prec]
        return found

    def first(self) -> list[arb]:
        """The start at the current precision."""
        return [value() if callable(value) else arb_of(value) for value in self.begin]

    def evaluate(self, t: arb) -> dict[str, arb]:
        return dict(zip(self.names, self.values.run(self.integration().at(t)), strict=True))

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The motion whose start has the coordinate `moved[axis]` larger by exactly `amount`: a witness of S, which needs none."""
        other = copy(self)
        other.kept, other.begin = {}, list(self.begin)
        before = self.begin[self.moved[axis]]
        other.begin[self.moved[axis]] = (lambda: before() + arb_of(amount)) if callable(before) else before + amount
        return other

    def jacobian(self, t: Fraction) -> arb_mat:
        """d quantity_i(t)/scale_i over d start_j/scale_j, with `state` as the first rows, from the variational equation."""
        integration = self.integration()
        time = arb_of(t)
        y, flow = integration.at(time), integration.jacobian(time)
        slopes = self.slopes.run(y)
        rows = [slopes[i : i + len(y)] for i in range(0, len(slopes), len(y))]
        whole = (arb_mat(rows) * flow).table()
        order = [*self.state, *(name for name in self.names if name not in self.state)]
        sizes = [arb_of(self.scale[name]) for name in self.state]
        found = arb_mat(
            [
                [whole[self.names.index(name)][j] * size / arb_of(self.scale[name]) for j, size in zip(self.moved, sizes, strict=True)]
                for name in order
            ]
        )
        self.kept["jacobian", t] = found
        return found
