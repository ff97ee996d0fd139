"""A Truth by validated integration: quantities of the state as balls, S(t) from the variational equation."""

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from fractions import Fraction
from math import ceil, log
from time import process_time
from typing import Any, Self

import numpy as np
from flint import arb, arb_mat, ctx

from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, ball_of, largest, precision
from refdem.truth.closed_form import Size
from refdem.truth.smooth_flow import ORIGINS, SmoothFlow
from refdem.truth.traced_field import Field, Program, traced
from refdem.truth.validated_ivp.integration import Integration

Quantities = Callable[[Sequence[Any]], Mapping[str, Any]]
"""Quantities by name of a state, by the operations of a field; the names of `state` among them."""
LOSS = 24
"""Bits that a quiet motion may lose; one that loses more is integrated anew with as many more."""
PROBE = 4
"""Pieces whose cost is measured for a forecast; as many as a second of CPU allows where that is above DEAR seconds."""
DEAR = 10.0


class ValidatedFlow(SmoothFlow):
    """The solution of y' = field(y), y(0) = start, for t >= 0; units do not matter, for norms are weighted (enclosure.py).

    `start` has, for each coordinate, an exact number, or a function that gives its ball at the current precision (the cosine of a
    parameter). `moved` has the coordinates of the start that S displaces and `state`, one for each, the quantities in whose scales
    they are displaced. Bits are those that the digits ask for, and more until every radius is met; pieces are kept for each number.
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

    def bits(self) -> int:
        """What `at` begins with: bits for the digits, or what they have needed so far."""
        asked = ceil(1 / self.target()).bit_length() + LOSS
        return int(self.kept.get(("bits", self.digits), asked + -asked % 32))

    sensitivity_bits = bits

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
        self.kept["bits", self.digits] = ctx.prec
        try:
            return dict(zip(self.names, self.values.run(self.integration().at(t)), strict=True))
        except NotCertifiedError as error:
            flow = self.integration()
            with precision(flow.bits):
                last = [value + arb(0, radius) for value, radius in zip(flow.centre, flow.spread.radii(), strict=True)]
                state = {name: ball_of(value) for name, value in zip(self.names, self.values.run(last), strict=True)}
            raise NotCertifiedError(str(error), code=error.code, time=error.time, state=state) from None

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The motion whose start has the coordinate `moved[axis]` larger by exactly `amount`: a witness of S, which needs none."""
        other = copy(self)
        other.kept, other.begin = {}, list(self.begin)
        before = self.begin[self.moved[axis]]
        other.begin[self.moved[axis]] = (lambda: before() + arb_of(amount)) if callable(before) else before + amount
        return other

    def jacobian(self, t: Fraction) -> arb_mat:
        """d quantity_i(t)/scale_i over d start_j/scale_j, with `state` as the first rows, from the variational equation."""
        flow = self.integration().jacobian(arb_of(t)).table()
        sizes = [(j, arb_of(self.scale[name])) for name, j in zip(self.state, self.moved, strict=True)]
        found = self.scaled_slopes(t) * arb_mat([[row[j] * size for j, size in sizes] for row in flow])
        self.kept["jacobian", t] = found
        return found

    def scaled_slopes(self, t: Fraction) -> arb_mat:
        """d quantity_i(t)/scale_i over d y_j(t), with `state` as the first rows."""
        slopes = self.slopes.run(self.integration().at(arb_of(t)))
        rows = dict(zip(self.names, np.array(slopes, dtype=object).reshape(len(self.names), -1), strict=True))
        order = [*self.state, *(name for name in self.names if name not in self.state)]
        return arb_mat([[entry / arb_of(self.scale[name]) for entry in rows[name]] for name in order])

    def sensitivities(self, times: Sequence[Fraction]) -> list[float]:
        """S at every time, the growth of errors made at t = 0 or at an earlier one of (up to 32 of) the times.

        The first is proved; the others are products of the steps' Jacobians in doubles, to about 1e-9.
        """
        grown = [self.sensitivity(t) for t in times]
        every = max(1, -(-len(times) // ORIGINS))
        made = np.zeros((1, len(self.begin), len(self.moved)))
        made[0, self.moved, range(len(self.moved))] = [float(self.scale[name]) for name in self.state]
        carried = made[:0]
        with precision(self.bits()):
            for i, t in enumerate(times):
                carried = self.integration().between(times[max(0, i - 1)], t) @ carried
                rows = np.array([[float(x.mid()) for x in row] for row in self.scaled_slopes(t).table()])
                grown[i] = max(grown[i], float(np.abs(rows @ carried).sum(axis=2).max(initial=0.0)) * (1 + 1e-9))
                carried = carried if i % every else np.concatenate([carried, made])
        return grown

    def forecast(self, t: Fraction, digits: int) -> float:
        """CPU seconds that `at(t)` to so many digits is about to cost, from a few pieces more than were made so far.

        A motion that loses more bits than LOSS by then at the rate seen so far is counted again with as many more.
        """
        asked = self.refined(digits)
        with precision(asked.bits()):
            flow, begun = asked.integration(), process_time()
            since, made, left, more = flow.end, len(flow.pieces), 0.0, 0.0
            while flow.end < t and (len(flow.pieces) < made + PROBE or (left > DEAR and process_time() < begun + 1)):
                flow.advance()
                left = (process_time() - begun) * float((t - flow.end) / (flow.end - since))
            if flow.end < t:
                half, last = flow.pieces[len(flow.pieces) // 2], flow.pieces[-1]
                lost = float((largest(last.spread.radii()) / largest(half.spread.radii())).log()) / log(2)
                more = max(0.0, lost * float(t / (last.begin - half.begin)) - LOSS) / flow.bits
        return left * (1 + (1 + more) ** 2 if more else 1)
