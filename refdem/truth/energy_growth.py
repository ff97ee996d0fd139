"""S(t) of a motion x'' = f(x), v = x', for all times, in closed form.

In scales X of x and V of v, with rho = X/V, let Z = (v/X, f/V) be the rate of the state, W = |Z|, e
= Z/W along the motion and n = (-f/V, v/X)/W across it, where H = v^2/2 + U(x) grows by X V W per
unit. An error is gamma e + beta n.

Theorem (errors): what an error made at s has become at t is

    beta(t)  = beta(s) W(s)/W(t)                                           H is kept
    gamma(t) = W(t) (gamma(s)/W(s) + W(s) (k(t) - k(s)) beta(s))

Proof: Z is a solution of the variational equation, and so is n/W + k Z, for which H is larger by X
V, with k' = (1/rho + rho f'(x)) ((v/X)^2 - (f/V)^2)/W^4 by the component of the equation along e.
Both span all errors. If a family of motions is known whose derivative by its parameter is P + K Z,
then k = (K + P . Z/W^2) X V/H', up to a constant, H' being the derivative of H by the parameter.

Theorem (all times): with a period all but k repeat, and k grows by the same amount in each. So the
matrix is linear in the number n of periods between s and t; its norm is convex, and largest for the
fewest or the most.

Theorem (cell): an error changes at most at the rate `quick` = max(1/rho, rho |f'|), both ways in
time, in the norm that is the larger of both coordinates: |D(t, s)| <= |D(t, c)| exp(quick h) for |s
- c| <= h.

Hypotheses, and where each is checked:

* the motion is no equilibrium, so that W > 0: families make a `Line` of no equilibrium; `known`
  raises UnsharpError where W is not known;
* P, K and H' are those of the family: `Line.neighbour`, in closed form, which the families derive;
* |f'| is at most `Line.steepest` all along the motion: an exact number of each family;
* the cells cover all times at which errors are made: `unrounded_at`, with a last cell up to t;
* the bound of rounding errors is a small part of S: `grown` compares it with MAX_ROUNDING_PART.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import frexp, inf, isfinite

import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from refdem.truth.balls import arb_of, ball_of
from refdem.truth.growth import (
    KNOWN,
    MAX_ROUNDING_PART,
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
"""A bound of the error of the sum of a row of the product of readings, axes, D and axes in doubles,
as a part of the product of the Euclidean norms of readings and D.

Errors are counted in units of KNOWN = 2^-50: a number that is known to 1 and truncated to a double
has the error 1.25, a rounding makes 1/8. Relative to the norm of each factor, a row of two readings
has the error sqrt(2) 1.25 < 1.8; each pair of axes, a cosine and a sine, as much; D that of its
entry with the most factors, 4 (two rates 2.5, two roundings 0.25, the lead 0.25 and its radius 1);
the three products, of two terms each, 2/8 each, times sqrt(2) where one factor is a pair of axes:
1. The sum is 1.8 + 2 x 1.8 + 4 + 1 = 10.4. The sum of a row of two numbers is at most sqrt(2) of
its norm: 14.8 < 16.
"""


@dataclass(frozen=True)
class Neighbour:
    """The derivative of a motion of a family by the family's parameter, at one time.

    It is P + K Z, with P = (`place`, `speed`) in the units of x and v, K (`along`) [s per unit of
    the parameter] and Z the rate of the motion; `energy` is H', the derivative of the energy.
    """

    place: arb
    speed: arb
    along: arb
    energy: arb


@dataclass(frozen=True)
class Line:
    """A motion x'' = f(x) of one degree of freedom.

    `state(t)` gives (x, v), `force(x)` f, `neighbour(t)` the derivative of the motion by the
    parameter of its family; `period` [s] is None if there is none; `steepest` bounds |f'| [1/s^2]
    along the motion.
    """

    state: Callable[[arb], tuple[arb, arb]]
    force: Callable[[arb], arb]
    neighbour: Callable[[arb], Neighbour]
    period: arb | None
    steepest: arb


@dataclass(frozen=True)
class Instant:
    """The axes e and n (columns of `axes`), W (`rate`) and k (`lead`) at a time."""

    axes: Array
    rate: float
    lead: arb


@dataclass(frozen=True)
class EnergyGrowth:
    """S of a motion of one degree of freedom.

    `scale_of_place` X and `scale_of_speed` V are the scales of x and v; `readings` gives the
    derivative (q, 2) of the quantities by a state (x, v), in scales. `instants` has those at the
    middles of the first cells, as far as requested.
    """

    line: Line
    scale_of_place: Fraction
    scale_of_speed: Fraction
    readings: Callable[[tuple[arb, arb]], arb_mat]
    instants: list[Instant] = field(default_factory=list, init=False, compare=False, repr=False)

    @cached_property
    def place(self) -> arb:
        """The scale X of x, as a ball."""
        return arb_of(self.scale_of_place)

    @cached_property
    def speed(self) -> arb:
        """The scale V of v, as a ball."""
        return arb_of(self.scale_of_speed)

    @cached_property
    def quick(self) -> float:
        """A bound of max(1/rho, rho |f'|) [1/s], of the theorem on cells."""
        # rho = X/V.
        rho = self.place / self.speed
        quick = arb.max(1 / rho, rho * self.line.steepest)
        return float(quick.upper()) * UPWARDS

    @cached_property
    def half(self) -> Fraction:
        """Half the width [s] of a cell: in this time an error changes by the part WIDEST at most,
        to first order.
        """
        # A power of two between WIDEST/2 and WIDEST over `quick`, which is m 2^e with 1/2 <= m < 1.
        exponent = frexp(self.quick)[1]
        return Fraction(WIDEST) * Fraction(2) ** -exponent

    @cached_property
    def gained(self) -> arb:
        """The increase of the lead k in a period; 0 for a motion without a period."""
        if self.line.period is None:
            return arb(0)
        return self.lead(self.line.period) - self.lead(arb(0))

    def at(self, t: Fraction) -> float:
        """S(t) >= 1; BOUNDLESS where it leaves the range of doubles."""
        with np.errstate(over="ignore", invalid="ignore"):
            return bounded(self.unrounded_at(t))

    def unrounded_at(self, t: Fraction) -> float:
        """S(t) before it is rounded up; not finite where it leaves the range of doubles."""
        period = self.line.period
        # t = since + periods P.
        since = arb_of(t)
        periods = 0
        if period is not None:
            periods = int(ball_of(since / period).mid)
            since = since - periods * period
        now = self.instant(since)
        read = self.read(since)
        elapsed = max(upper(since), Fraction(0))
        # Errors of this period: those of whole cells, and those that are made since the last of
        # them, which grow by exp(quick rest) at most (theorem on cells).
        ended = int(elapsed // (2 * self.half))
        rest = float(elapsed - ended * 2 * self.half)
        of_last_cell = float(np.abs(read).sum(axis=1).max() * np.exp(self.quick * rest)) * UPWARDS
        bound = max(of_last_cell, self.grown(read, now, ended, 0))
        if periods and period is not None:
            # All cells of a period. By the theorem on all times the norm is largest for the fewest
            # or the most periods between.
            count = -int(-upper(period) // (2 * self.half))
            bound = max(bound, *(self.grown(read, now, count, n) for n in {1, periods}))
        return bound

    def read(self, since: arb) -> Array:
        """The readings (q, 2) as doubles; UnsharpError where they are not known to doubles."""
        table = self.readings(self.line.state(since)).table()
        largest = max(float(entry.abs_upper()) for row in table for entry in row)
        return np.array([[known(entry, largest) for entry in row] for row in table])

    def rates(self, t: arb) -> tuple[arb, arb]:
        """The rate Z = (v/X, f/V) [1/s] of the state at time t."""
        x, v = self.line.state(t)
        return v / self.place, self.line.force(x) / self.speed

    def lead(self, t: arb) -> arb:
        """The lead k = (K + P . Z/W^2) X V/H', up to a constant."""
        neighbour = self.line.neighbour(t)
        z_x, z_v = self.rates(t)
        # k = (K + P . Z/W^2) X V/H', with P in scales and W^2 = Z . Z.
        along_motion = neighbour.place / self.place * z_x + neighbour.speed / self.speed * z_v
        ahead = neighbour.along + along_motion / (z_x * z_x + z_v * z_v)
        return ahead * self.place * self.speed / neighbour.energy

    def instant(self, t: arb) -> Instant:
        """The axes, W and k at the time t; UnsharpError where they are not known to doubles."""
        z_x, z_v = self.rates(t)
        rate = (z_x * z_x + z_v * z_v).sqrt()
        # e = Z/W, and n is e turned by 90 degrees.
        cosine = known(z_x / rate, 1.0)
        sine = known(z_v / rate, 1.0)
        axes = np.array([[cosine, -sine], [sine, cosine]])
        return Instant(axes, known(rate), self.lead(t))

    def instants_of(self, count: int) -> list[Instant]:
        """The instants at the middles of the first `count` cells; kept for later calls."""
        while len(self.instants) < count:
            middle = (2 * len(self.instants) + 1) * self.half
            self.instants.append(self.instant(arb_of(middle)))
        return self.instants[:count]

    def grown(self, read: Array, now: Instant, count: int, periods: int) -> float:
        """The growth of errors of the first `count` cells, made `periods` periods ago.

        `read` (q, 2) are the readings at the instant `now`. Infinite where it leaves the range of
        doubles; UnsharpError where the bound of rounding errors is above the part
        MAX_ROUNDING_PART.
        """
        if count == 0:
            return 0.0
        instants = self.instants_of(count)
        # k(t) - k(s) of each cell, and the largest radius of these balls.
        leads, radius = rounded(
            [now.lead - instant.lead + periods * self.gained for instant in instants]
        )
        rates = np.array([instant.rate for instant in instants])
        # Theorem on errors, (gamma, beta) at t by those at s:
        # gamma(t) = W(t) (gamma(s)/W(s) + W(s) (k(t) - k(s)) beta(s)), beta(t) = beta(s) W(s)/W(t).
        matrices = np.zeros((count, 2, 2))
        matrices[:, 0, 0] = now.rate / rates
        matrices[:, 0, 1] = now.rate * rates * leads
        matrices[:, 1, 1] = rates / now.rate
        if radius * now.rate * rates.max() > float(KNOWN) * np.abs(matrices).max():
            raise UnsharpError("how errors grow is not known well enough at this precision")
        # readings A(t) D A(s)^T, with the axes e and n as columns of A and D in these axes; errors
        # made elsewhere in a cell grow by exp(quick half) more at most (theorem on cells).
        to_axes = np.array([instant.axes.T for instant in instants])
        answers = read @ now.axes @ matrices @ to_axes
        within_cell = np.exp(self.quick * float(self.half))
        largest = np.abs(answers).sum(axis=-1).max() * within_cell * UPWARDS
        largest_matrix = float(np.linalg.norm(matrices, axis=(-2, -1)).max())
        rounding = ROUNDED * float(np.linalg.norm(read)) * largest_matrix
        if not isfinite(largest):
            return inf
        if rounding > MAX_ROUNDING_PART * largest:
            raise UnsharpError(
                "rounding has a larger part in how errors grow than doubles allow", final=True
            )
        return float(largest) + rounding
