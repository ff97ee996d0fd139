"""A witness for closed forms: quadratic systems y' = B(y, y), solved by Taylor series with a proven
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
"""The ratio r of a step: a quarter gains two bits a term, at a step that is half as long as the
quickest.
"""


@dataclass(frozen=True)
class Quadratic:
    """The system y_i' = sum of c y_j y_k over the terms (c, j, k) of component i."""

    terms: Sequence[Sequence[tuple[arb, int, int]]]

    def bound(self) -> arb:
        """The bound a of |B(y, y)| <= a |y|^2: the largest sum of |c| of a component."""
        return _largest([sum((abs(c) for c, _, _ in row), arb(0)) for row in self.terms])

    def flow(self, start: Sequence[arb], t: Fraction, *, order: int) -> list[arb]:
        """y(t) from y(0), in as few steps as `order` terms at RATIO allow; the balls contain the
        remainder.
        """
        y = list(start)
        remaining = arb_of(t)
        if t < 0:
            sign = -1
        else:
            sign = 1
        while True:
            # h = r/(a Y).
            rate = self.bound() * _largest([abs(x) for x in y])
            if rate > 0:
                step = (arb_of(RATIO) / rate).lower()
            else:
                # The state is zero and stays: one step does it.
                step = abs(remaining) + 1
            if abs(remaining) <= step:
                return self._step(y, remaining, order)
            y = self._step(y, sign * step, order)
            remaining = remaining - sign * step

    def _step(self, y: Sequence[arb], h: arb, order: int) -> list[arb]:
        """The solution a step h (of either sign) after y: the sum of its series, and a ball of the
        remainder.

        `series` has the terms y_n h^n of each component: y_(n+1) = sum of c [y_j y_k]_n/(n + 1).
        """
        pairs = sorted({(j, k) for row in self.terms for _, j, k in row})
        series = [[x] for x in y]
        for n in range(order):
            products = {(j, k): _convolution(series[j], series[k], n) for j, k in pairs}
            for row, terms in zip(self.terms, series, strict=True):
                rate = sum((c * products[j, k] for c, j, k in row), arb(0))
                terms.append(h / (n + 1) * rate)
        # The remainder Y r^(N+1)/(1 - r), r = a Y h.
        largest = _largest([abs(x) for x in y])
        ratio = (self.bound() * largest * abs(h)).abs_upper()
        remainder = largest * ratio ** (order + 1) / (1 - ratio)
        return [sum(terms, arb(0, remainder.abs_upper())) for terms in series]


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
    """omega in body axes and the attitude (of either sign) of a free rigid body at t [s].

    The system is Euler's equations, J_i omega_i' = (J_j - J_k) omega_j omega_k for cyclic i, j, k,
    and q' = q omega/2. `inertia` has the principal moments; `attitude` need not have the length 1.
    """
    half = arb(1) / 2
    # The unknowns are omega (numbers 0, 1, 2) and the quaternion w, x, y, z.
    euler = []
    for i in range(3):
        j = (i + 1) % 3
        k = (i + 2) % 3
        coefficient = arb_of((inertia[j] - inertia[k]) / inertia[i])
        euler.append([(coefficient, j, k)])
    w = 3
    x = 4
    y = 5
    z = 6
    # q' = q (0, omega)/2: a row an unknown, an entry the coefficient and a product of two unknowns.
    w_rate = [(-half, x, 0), (-half, y, 1), (-half, z, 2)]
    x_rate = [(half, w, 0), (half, y, 2), (-half, z, 1)]
    y_rate = [(half, w, 1), (half, z, 0), (-half, x, 2)]
    z_rate = [(half, w, 2), (half, x, 1), (-half, y, 0)]
    attitude_rate = [w_rate, x_rate, y_rate, z_rate]
    length_squared = sum((v * v for v in attitude), Fraction(0))
    unit_attitude = [arb_of(v) / arb_of(length_squared).sqrt() for v in attitude]
    start = [arb_of(v) for v in omega] + unit_attitude
    end = Quadratic([*euler, *attitude_rate]).flow(start, t, order=order)
    return end[:3], end[3:]


def pendulum_flow(
    theta: arb, thetadot: Fraction, gravity_over_length: Fraction, t: Fraction, *, order: int
) -> tuple[arb, arb, arb]:
    """cos theta, sin theta and thetadot [1/s] of a pendulum at t [s]: theta'' = -w0^2 sin theta,
    w0^2 = g/l.

    The unknowns c = cos theta, s = sin theta, r = thetadot/w0 and 1 make it quadratic: c' = -w0 s
    r, s' = w0 c r, r' = -w0 s 1.
    """
    w0 = arb_of(gravity_over_length).sqrt()
    c = 0
    s = 1
    r = 2
    one = 3
    system = Quadratic([[(-w0, s, r)], [(w0, c, r)], [(-w0, s, one)], []])
    start = [theta.cos(), theta.sin(), arb_of(thetadot) / w0, arb(1)]
    cosine, sine, rate, _ = system.flow(start, t, order=order)
    return cosine, sine, rate * w0
