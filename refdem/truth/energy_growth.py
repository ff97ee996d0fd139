"""S(t) of a motion x'' = f(x), v = x', for all times, in closed form.

In scales X of x and V of v, with rho = X/V, let Z = (v/X, f/V) be the rate of the state, W = |Z|, e
= Z/W along the motion and n = (-f/V, v/X)/W across it, where H = v^2/2 + U(x) grows by X V W per
unit. An error is gamma e + beta n.

Theorem (errors): what an error made at s has become at t is

    beta(t)  = beta(s) W(s)/W(t)                                           H is kept
    gamma(t) = W(t) (gamma(s)/W(s) + W(s) (k(t) - k(s)) beta(s))

Proof: Z is a solution of the variational equation, and so is n/W + k Z, for which H is larger by X
V, with k' = (1/rho + rho f'(x)) ((v/X)^2 - (f/V)^2)/W^4: the equation along e says so. Both span
all errors. If a family of motions is known whose member changes as P + K Z by its parameter, then k
= (K + P . Z/W^2) X V/H', H' being the change of H, up to a constant.

Theorem (all times): with a period all but k repeat, and k grows by the same amount in each. So the
matrix is linear in the number n of periods between s and t; its norm is convex, and largest for the
fewest or the most.

Theorem (cell): an error changes at most at the rate `quick` = max(1/rho, rho |f'|), both ways in
time, in the norm that is the larger of both coordinates: |D(t, s)| <= |D(t, c)| exp(quick h) for |s
- c| <= h.

Hypotheses, and where each is checked:

* the motion is no equilibrium, so that W > 0: families tell a `Line` of no other motion; `known`
  raises UnsharpError where W is not known;
* P, K and H' are those of the family: `Line.neighbour`, in closed form, which the families derive;
* |f'| is at most `Line.steepest` all along the motion: an exact number of each family;
* the cells cover all times at which errors are made: `found_at`, whose last cell is `own`;
* what rounding may have lost is a small part of S: `grown` compares it with LOST.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from math import frexp, inf, isfinite

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from refdem.truth.balls import arb_of, ball_of
from refdem.truth.growth import (
    KNOWN,
    LOST,
    UPWARDS,
    WIDEST,
    UnsharpError,
    bounded,
    known,
    rounded,
    upper,
)

Array = NDArray[np.float64]

ROUNDED = 2.0**-46
"""Part of the product of their Euclidean norms by which the sum of a row of readings, axes, D and
axes is off, at most.

Counted in units of KNOWN = 2^-50. A number known to 1 and cut off to a double is off by 1.25, a
rounding is 1/8. Each in parts of its own norm, a row of two readings is off by sqrt(2) 1.25 < 1.8,
each pair of axes, a cosine and a sine, by as much, D by the 4 of its longest entry (two rates 2.5,
two roundings 0.25, the lead 0.25 and its blur 1), and the three products, of two terms, by 2/8
each, times sqrt(2) where one factor is a pair of axes: 1. In all 1.8 + 2 x 1.8 + 4 + 1 = 10.4. The
sum of a row of two is at most sqrt(2) of its norm: 14.8 < 16.
"""


@dataclass(frozen=True)
class Neighbour:
    """How a motion of a family changes by its parameter at a time: P = (place, speed), K [s] along
    the motion, and H' of its energy.
    """

    place: arb
    speed: arb
    along: arb
    energy: arb


@dataclass(frozen=True)
class Line:
    """A motion of one degree of freedom: (x, v) and f(x) at a time, its family, a period [s] if
    there is one, and a bound of |f'| along it.
    """

    state: Callable[[arb], tuple[arb, arb]]
    force: Callable[[arb], arb]
    neighbour: Callable[[arb], Neighbour]
    period: arb | None
    steepest: arb


@dataclass(frozen=True)
class Instant:
    """The axes e and n (columns), W and k at a time."""

    axes: Array
    rate: float
    lead: arb


class EnergyGrowth:
    """S of a motion of one degree of freedom, whose readings (q, 2) by the state are in scales."""

    def __init__(
        self,
        line: Line,
        place: Fraction,
        speed: Fraction,
        readings: Callable[[tuple[arb, arb]], arb_mat],
    ) -> None:
        self.line = line
        self.readings = readings
        self.place, self.speed = arb_of(place), arb_of(speed)
        ratio = self.place / self.speed
        quick = arb.max(1 / ratio, ratio * line.steepest)
        self.quick = float(quick.upper()) * UPWARDS
        # Cells of a width at whose ends an error has changed by the part WIDEST, at most.
        # A power of two between WIDEST/2 and WIDEST over `quick`, which is m 2^e with 1/2 <= m < 1.
        exponent = frexp(self.quick)[1]
        self.half = Fraction(WIDEST) * Fraction(2) ** -exponent
        self.instants: list[Instant] = []
        self.gained = arb(0)
        if line.period is not None:
            self.gained = self.lead(line.period) - self.lead(arb(0))

    def at(self, t: Fraction) -> float:
        """S(t) >= 1; BOUNDLESS where doubles end."""
        with np.errstate(over="ignore", invalid="ignore"):
            return bounded(self.found_at(t))

    def found_at(self, t: Fraction) -> float:
        """S(t), or what is not finite."""
        period = self.line.period
        since = arb_of(t)
        periods = 0
        if period is not None:
            periods = int(ball_of(since / period).mid)
            since = since - periods * period
        now = self.instant(since)
        read = self.read(since)
        passed = max(upper(since), Fraction(0))
        # Errors of this period: those of whole cells, and those that are made since the last of
        # them.
        ended = int(passed // (2 * self.half))
        rest = float(passed - ended * 2 * self.half)
        own = float(np.abs(read).sum(axis=1).max() * np.exp(self.quick * rest)) * UPWARDS
        found = max(own, self.grown(read, now, ended, 0))
        if periods and period is not None:
            count = -int(-upper(period) // (2 * self.half))
            found = max(found, *(self.grown(read, now, count, n) for n in {1, periods}))
        return found

    def read(self, since: arb) -> Array:
        """The readings as an array of doubles."""
        table = self.readings(self.line.state(since)).table()
        size = max(float(entry.abs_upper()) for row in table for entry in row)
        return np.array([[known(entry, size) for entry in row] for row in table])

    def rates(self, t: arb) -> tuple[arb, arb]:
        """The vector Z of scaled rates (dx/dt, dv/dt) at time t."""
        x, v = self.line.state(t)
        return v / self.place, self.line.force(x) / self.speed

    def lead(self, t: arb) -> arb:
        """The lead k of a neighbour, up to a constant."""
        beside = self.line.neighbour(t)
        first, second = self.rates(t)
        across = beside.place / self.place * first + beside.speed / self.speed * second
        ahead = beside.along + across / (first * first + second * second)
        return ahead * self.place * self.speed / beside.energy

    def instant(self, t: arb) -> Instant:
        """The axes and numbers of a time; UnsharpError where they are not known to doubles."""
        first, second = self.rates(t)
        rate = (first * first + second * second).sqrt()
        cosine = known(first / rate, 1.0)
        sine = known(second / rate, 1.0)
        axes = np.array([[cosine, -sine], [sine, cosine]])
        return Instant(axes, known(rate), self.lead(t))

    def instants_of(self, count: int) -> list[Instant]:
        """The instants at the middles of the first cells."""
        while len(self.instants) < count:
            middle = (2 * len(self.instants) + 1) * self.half
            self.instants.append(self.instant(arb_of(middle)))
        return self.instants[:count]

    def grown(self, read: Array, now: Instant, count: int, periods: int) -> float:
        """The growth of errors of the first `count` cells, made so many periods ago."""
        if count == 0:
            return 0.0
        instants = self.instants_of(count)
        leads, blur = rounded(
            [now.lead - instant.lead + periods * self.gained for instant in instants]
        )
        rates = np.array([instant.rate for instant in instants])
        changed = np.zeros((count, 2, 2))
        changed[:, 0, 0] = now.rate / rates
        changed[:, 0, 1] = now.rate * rates * leads
        changed[:, 1, 1] = rates / now.rate
        if blur * now.rate * rates.max() > float(KNOWN) * np.abs(changed).max():
            raise UnsharpError("how errors grow is not known well enough at this precision")
        back = np.array([instant.axes.T for instant in instants])
        answers = read @ now.axes @ changed @ back
        largest = (
            np.abs(answers).sum(axis=-1).max() * np.exp(self.quick * float(self.half)) * UPWARDS
        )
        lost = (
            ROUNDED
            * float(np.linalg.norm(read))
            * float(np.linalg.norm(changed, axis=(-2, -1)).max())
        )
        if not isfinite(largest):
            return inf
        if lost > LOST * largest:
            raise UnsharpError(
                "rounding has a larger part in how errors grow than doubles allow", final=True
            )
        return float(largest) + lost
