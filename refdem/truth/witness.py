"""A witness for closed forms: quadratic systems y' = B(y, y) by Taylor series with a proven
remainder.

With |B(y, y)| <= a |y|^2 in the maximum norm, the series is dominated by that of Y' = a Y^2: |y_k|
<= Y (a Y)^k, Y = |y(0)| (method of majorants). So N terms of a step h leave at most Y r^(N+1)/(1 -
r), r = a Y h < 1. Balls carry all else. It knows the equations of motion only, no solution of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from refdem.truth.balls import arb_of

RATIO = Fraction(1, 4)
"""r: a quarter gains two bits a term, at a step that is half as long as the quickest."""


@dataclass(frozen=True)
class Quadratic:
    """y_i' = sum of c y_j y_k over the terms (c, j, k) of component i."""

    terms: Sequence[Sequence[tuple[arb, int, int]]]

    def bound(self) -> arb:
        """a: the largest sum of |c| of a component."""
        return _largest([sum((abs(c) for c, _, _ in row), arb(0)) for row in self.terms])

    def flow(self, start: Sequence[arb], t: Fraction, *, order: int) -> list[arb]:
        """y(t) from y(0), in as few steps as `order` terms at RATIO allow; the balls contain the
        remainder.
        """
        y = list(start)
        left = arb_of(t)
        if t < 0:
            sign = -1
        else:
            sign = 1
        while True:
            speed = self.bound() * _largest([abs(x) for x in y])
            if speed > 0:
                step = (arb_of(RATIO) / speed).lower()
            else:
                step = abs(left) + 1
            if abs(left) <= step:
                return self._step(y, left, order)
            y = self._step(y, sign * step, order)
            left = left - sign * step

    def _step(self, y: Sequence[arb], h: arb, order: int) -> list[arb]:
        pairs = sorted({(j, k) for row in self.terms for _, j, k in row})
        series = [[x] for x in y]
        for n in range(order):
            products = {(j, k): _convolution(series[j], series[k], n) for j, k in pairs}
            for row, coefficients in zip(self.terms, series, strict=True):
                coefficients.append(
                    h / (n + 1) * sum((c * products[j, k] for c, j, k in row), arb(0))
                )
        size = _largest([abs(x) for x in y])
        ratio = (self.bound() * size * abs(h)).abs_upper()
        rest = size * ratio ** (order + 1) / (1 - ratio)
        return [sum(coefficients, arb(0, rest.abs_upper())) for coefficients in series]


def _convolution(a: Sequence[arb], b: Sequence[arb], n: int) -> arb:
    """The sum over i of a_i b_(n-i): one term of a Cauchy product."""
    return sum((x * y for x, y in zip(a[: n + 1], b[n::-1], strict=True)), arb(0))


def _largest(values: Sequence[arb]) -> arb:
    """An exact upper bound of the largest of them."""
    return max((arb(x.abs_upper()) for x in values), default=arb(0), key=float)


def body_flow(
    inertia: Sequence[Fraction],
    omega: Sequence[Fraction],
    attitude: Sequence[Fraction],
    t: Fraction,
    *,
    order: int,
) -> tuple[list[arb], list[arb]]:
    """omega in body axes and the attitude (of either sign) of a free rigid body at t: Euler's
    equations, q' = q omega/2.
    """
    j = inertia
    half = arb(1) / 2
    euler = [
        [(arb_of((j[(i + 1) % 3] - j[(i + 2) % 3]) / j[i]), (i + 1) % 3, (i + 2) % 3)]
        for i in range(3)
    ]
    w = 3
    x = 4
    y = 5
    z = 6
    turning = [
        [(-half, x, 0), (-half, y, 1), (-half, z, 2)],
        [(half, w, 0), (half, y, 2), (-half, z, 1)],
        [(half, w, 1), (half, z, 0), (-half, x, 2)],
        [(half, w, 2), (half, x, 1), (-half, y, 0)],
    ]
    unit = sum((v * v for v in attitude), Fraction(0))
    start = [arb_of(v) for v in omega] + [arb_of(v) / arb_of(unit).sqrt() for v in attitude]
    end = Quadratic([*euler, *turning]).flow(start, t, order=order)
    return end[:3], end[3:]


def pendulum_flow(
    theta: arb, thetadot: Fraction, gravity_over_length: Fraction, t: Fraction, *, order: int
) -> tuple[arb, arb, arb]:
    """cos theta, sin theta and thetadot of a pendulum at t: theta'' = -(g/l) sin theta, in units of
    w0.
    """
    w0 = arb_of(gravity_over_length).sqrt()
    one = 3
    field = Quadratic([[(-w0, 1, 2)], [(w0, 0, 2)], [(-w0, 1, one)], []])
    cosine, sine, rate, _ = field.flow(
        [theta.cos(), theta.sin(), arb_of(thetadot) / w0, arb(1)], t, order=order
    )
    return cosine, sine, rate * w0
