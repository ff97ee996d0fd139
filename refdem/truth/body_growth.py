"""S(t) of a free rigid body for all times, in closed form: J omega' = J omega x omega, q' = q
omega/2.

An error at any time is psi, a small turn, and d, a change of omega, both in body axes: psi' = d -
omega x psi. Each is measured by Euclid in its scale. M = J omega is the momentum, L = |M|, E the
energy, m a unit vector along M, w one along the part of omega across M, whose length is W, and b =
m x w, so that M' = M x omega = L W b. Changes of M, J d = L (alpha m + beta w + gamma b), and psi =
p m + psi_w w + psi_b b, are counted along these moving axes.

Theorem (errors): what an error made at s has become at t, with tau = t - s, is

    alpha(t) = alpha(s)                                                    |M| is kept
    beta(t)  = beta(s) W(s)/W(t)                                           E is kept
    gamma(t) = W(t) (alpha(s) tau + L W(s) (k(t) - k(s)) beta(s) + gamma(s)/W(s))
    p(t)     = p(s) + tau (omega.m alpha(s) + W(s) beta(s))
    psi_w(t) + i psi_b(t) = gamma(t) - i beta(t) + i q (lambda_w + i lambda_b)(s),  lambda = J d/L +
    psi x m

Proof: d|M|^2/2 = L^2 alpha and dE = omega . J d are constants. The variational equation of Euler's
equations is solved by M', by M + t M' (the motion scaled in time) and by w/W + k M' (more energy,
the same |M|), where k' = (w J^-1 w - b J^-1 b)/W^2: this follows from the component of the equation
along b. These three span all changes, which gives alpha, beta, gamma. (psi . M)' = d . M = dE gives
p. In space the change of the momentum, R (J d + psi x M), is constant: in body axes lambda turns
about m as axes fixed in space do, by the unit number q, and psi across M is m x (lambda - J d/L).

Theorem (all times): omega has a period P in body axes. W and the axes repeat, k grows by the same
kappa and q by the same factor in each period, so that with n periods more between s and t

    D(t, s) = A + n N + q^n B,  N linear, B that of i q lambda alone.

A norm is convex in n: over n >= RECENT that of A + n N is largest at an end. What is read of lambda
has r . (q lambda), with r of two numbers, which is at most |r| |lambda| whatever the unit number q.
So S is at most the largest of |A + n N| at both ends plus |r| |lambda|. Fewer periods are taken one
by one. The first of the far ones exceeds B so much that this loses nothing. So one period of cells
is S for ever.

Theorem (cell): for |s - c| <= h a change of omega grows by at most g = exp(a h), a bounding the
Jacobian of Euler's equations, and turns the body by at most h g. So |D(t, s)| <= |D(t, c)_psi| (1 +
h g) + |D(t, c)_omega| g.

A steady spin has W = 0: J d across M obeys an equation of constant coefficients, all else stays,
and D depends on tau alone.

All of this is known in balls. What is read, D and what errors are made of are then doubles with the
bounds of midpoint_radius.py, entry by entry: D of a needle has entries of 1e12 that meet others of
1e-12, and a bound by norms would be too large to show that little is lost.

Hypotheses, and where each is checked:

* W is not 0, so that the axes exist: the exact start shows which bodies spin steadily
  (free_body.kind, RigidCluster.is_steady), and these are `Spinning`; a W whose ball holds 0 makes
  what follows not finite, which `near` refuses with UndecidedError;
* k is that of the motion: `FreeBody.lead`, in closed form for each kind of motion;
* omega repeats after P: `FreeBody.period`, which is None on the separatrix;
* a bounds the Jacobian of Euler's equations along the whole motion: `quickness`, from
  `FreeBody.fastest`;
* the cells cover all times at which errors are made: `BodyGrowth.cover`; errors of the cell that
  holds t are those of `Tumbling.of_cell_of_now`;
* what doubles may have lost is a small part of S: `BodyGrowth.largest` compares it with
  MAX_ROUNDING_PART.
"""

from abc import ABC, abstractmethod
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import inf, isfinite
from typing import Any

import numpy as np
from flint import acb, arb
from numpy.typing import NDArray

from refdem.truth import rotation
from refdem.truth.balls import arb_of, ball_of
from refdem.truth.free_body import FreeBody, dot_exact
from refdem.truth.growth import (
    BOUNDLESS,
    MAX_ROUNDING_PART,
    UPWARDS,
    WIDEST,
    Grows,
    Told,
    UnsharpError,
    bounded,
    spectral,
    upper,
)
from refdem.truth.midpoint_radius import MidpointRadius, exact, from_balls, together
from refdem.truth.reals import Number

Array = NDArray[np.float64]
Tensor = Sequence[Sequence[Number]]
Balls = Sequence[Sequence[arb]]
Attitude = Callable[[arb], Sequence[arb]]
"""The quaternion at a time, of either sign."""
AXES = range(3)
TURN = slice(0, 3)
SPIN = slice(3, 6)
"""Columns of errors, and the rows of what they become along the moving axes."""
BODY = slice(3, 6)
SPACE = slice(6, 9)
"""Rows that are read besides the turn: omega in body axes and in space."""
READ = (TURN, BODY, SPACE)
"""The vectors that are read: each is measured by Euclid, as errors are when they are made."""
TRANSVERSE = slice(1, 3)
"""Components along w and b."""

RECENT = 4
"""The number of periods between an error and its effect from which on the angle q is bounded; fewer
are taken one by one.
"""
TURNS = 16
"""The turns of a steady spin that are followed cell by cell; after them its drift exceeds all that
turns.
"""
SHARE = Fraction(1, 16)
"""The width of a late cell as a part of its time: a change of omega made at 0 has turned the body
16 times as much as one made in the cell.
"""


@dataclass(frozen=True)
class Scales:
    """The scales in which errors are counted: of a turn [rad] and of omega [rad/s].

    `jacobian` [1/s] bounds the norm of the Jacobian of Euler's equations along the motion: a of the
    theorem on cells.
    """

    turn: Fraction
    spin: Fraction
    jacobian: float

    @property
    def shear(self) -> float:
        """The rate [1/s] at which a change of omega of one scale turns the body, in scales of a
        turn.
        """
        return float(self.spin / self.turn)


@dataclass(frozen=True)
class Cell:
    """An interval [low, high] of times [s] at which errors are made, or that have elapsed since."""

    low: Fraction
    high: Fraction

    @property
    def middle(self) -> Fraction:
        """The middle of the interval, at which D is evaluated."""
        return (self.low + self.high) / 2

    @property
    def half(self) -> float:
        """Half the width [s], rounded up: h of the theorem on cells."""
        return float(self.high - self.low) / 2 * UPWARDS


def next_cell(low: Fraction, scales: Scales) -> Cell:
    """The next cell from `low` on, so narrow that the theorem on cells loses little.

    In it g = exp(a h) <= exp(WIDEST), and the turn h g is small beside 1, or beside what errors of
    omega made at 0 have turned the body by at `low`.
    """
    narrow = Fraction(2 * WIDEST / max(scales.jacobian, scales.shear))
    # Errors of omega made at 0 have turned the body in proportion to the time: a cell may be as
    # wide as the part SHARE of its time.
    width = max(narrow, low * SHARE)
    if scales.jacobian > 0:
        # a h <= WIDEST, with the width 2 h.
        width = min(width, Fraction(2 * WIDEST / scales.jacobian))
    return Cell(low, low + dyadic(width))


def dyadic(width: Fraction) -> Fraction:
    """The width rounded down to a number of about 8 bits, so that the ends of cells stay short."""
    exponent = width.numerator.bit_length() - width.denominator.bit_length() - 8
    unit = Fraction(2) ** exponent
    return width // unit * unit


class BodyGrowth(ABC):
    """S of a free rigid body: what tumbling and spinning bodies have in common.

    The quantities that are read are the attitude and omega in body axes and in space axes.
    """

    def begin(self, tensor: Balls, scales: Scales, attitude: Attitude) -> None:
        """Sets the inertia `tensor` [kg m^2], the scales and the quaternion `attitude(t)`, from
        which omega in space axes follows.
        """
        self.scales = scales
        self.attitude = attitude
        self.tensor = tensor
        self.inverse = inverse(tensor)
        self.cells: list[Cell] = []

    def at(self, t: Fraction) -> float:
        """S(t) >= 1; BOUNDLESS where doubles end."""
        with np.errstate(over="ignore", invalid="ignore"):
            return bounded(self.unrounded_at(t))

    @abstractmethod
    def unrounded_at(self, t: Fraction) -> float:
        """S(t) before it is rounded up; not finite where doubles end."""

    def read(self, t: Fraction, axes: Balls, omega: Sequence[arb], length: arb) -> MidpointRadius:
        """The derivative (9, 6) of the quantities, in scales, by an error (psi, J d/L) that is
        given along `axes`.

        `axes` are three unit vectors in body axes, as rows; `length` is L = |M|. Rows of the
        result: the turn, omega in body axes, omega in space axes (TURN, BODY, SPACE).
        """
        to_body = rotation.transposed(axes)
        to_space = rotation.matrix(self.attitude(arb_of(t)))
        spin = arb_of(self.scales.spin)
        turn = arb_of(self.scales.turn)
        # In body axes d = J^-1 (J d); in space the change of omega is R (d - omega x psi).
        omega_change = scaled(rotation.product(self.inverse, to_body), length / spin)
        x, y, z = omega
        omega_cross = [[arb(0), -z, y], [z, arb(0), -x], [-y, x, arb(0)]]
        swept = rotation.product(rotation.product(to_space, omega_cross), to_body)
        derivative = [[arb(0)] * 6 for _ in range(9)]
        put(derivative, TURN, TURN, scaled(diagonal([arb(1)] * 3), 1 / turn))
        put(derivative, BODY, SPIN, omega_change)
        put(derivative, SPACE, TURN, scaled(swept, -1 / spin))
        put(derivative, SPACE, SPIN, rotation.product(to_space, omega_change))
        return from_balls(derivative)

    def sources(self, axes: Balls, length: arb) -> MidpointRadius:
        """J d/L along `axes` (3, 3), for a change d of omega by one scale in each body axis."""
        momentum_changes = rotation.product(axes, self.tensor)
        return from_balls(scaled(momentum_changes, arb_of(self.scales.spin) / length))

    def largest(
        self,
        read: MidpointRadius,
        parts: Sequence[MidpointRadius],
        sources: MidpointRadius,
        halves: Array,
        *,
        turns_anyhow: bool = False,
    ) -> float:
        """The largest growth of the errors of cells, whose matrix D at the middle of each is the
        sum of `parts`.

        `read` (9, 6) is that of `read`; each part is (cells, 6, 6), and the norm of the sum is
        bounded by the sum of the norms; `sources` (cells, 3, 3) is what a change of omega is made
        of there; `halves` (cells,) [s] is h, half the width of each cell. `turns_anyhow` adds the
        bound of i q lambda for any unit number q. Infinite where doubles end; UnsharpError where
        rounding may have lost more than the part MAX_ROUNDING_PART.
        """
        one_turn = from_balls([arb_of(self.scales.turn)])
        # |D_psi| and |D_omega| of the theorem on cells, by vector that is read.
        by_turn = exact(np.zeros((1, len(READ))))
        by_spin = exact(np.zeros((1, len(READ))))
        for part in parts:
            response = read @ part
            by_turn = by_turn + norms_of_read(response[..., TURN] * one_turn)
            by_spin = by_spin + norms_of_read(response[..., SPIN] @ sources)
        if turns_anyhow:
            # |r . (q lambda)| <= |r| |lambda|, with lambda = J d/L + psi x m across m.
            reach = norms_of_read(read[None, :, TRANSVERSE])
            by_turn = by_turn + reach * one_turn
            by_spin = by_spin + reach * spectral_norms(sources[:, TRANSVERSE])[:, None]
        # |D(t, s)| <= |D_psi| (1 + h g) + |D_omega| g with g = exp(a h) (theorem on cells).
        omega_growth = np.exp(self.scales.jacobian * halves)[:, None]
        turn_growth = halves[:, None] * self.scales.shear * omega_growth
        growth = by_turn.midpoint * (1 + turn_growth) + by_spin.midpoint * omega_growth
        rounding = by_turn.radius * (1 + turn_growth) + by_spin.radius * omega_growth
        bound = float((growth + rounding).max(initial=0.0)) * UPWARDS
        if not isfinite(bound):
            return inf
        if float(rounding.max(initial=0.0)) > MAX_ROUNDING_PART * bound:
            raise UnsharpError("how errors of a body grow is not known well at this precision")
        return bound

    def cover(self, until: Fraction) -> None:
        """Makes the cells that cover [0, until]."""
        while not self.cells or self.cells[-1].high < until:
            if self.cells:
                low = self.cells[-1].high
            else:
                low = Fraction(0)
            self.cells.append(next_cell(low, self.scales))

    def ended_by(self, time: Fraction) -> int:
        """The number of cells that end at a time or before, up to which they must be made."""
        return bisect_right([cell.high for cell in self.cells], time)

    def end_of(self, count: int) -> Fraction:
        """The time [s] at which the first `count` cells end."""
        if count:
            return self.cells[count - 1].high
        return Fraction(0)


@dataclass(frozen=True)
class Instant:
    """The numbers of the theorem on errors at one time.

    `axes` are the moving axes m, w, b (rows, in body axes), `across` is W [rad/s], `lead` k [s/J],
    `angle` the unit number exp(i phi) by which w has turned about M in space since the start.
    `sources` (3, 3) is J d/L along the axes for changes d of omega by one scale.
    """

    time: arb
    axes: Balls
    across: arb
    lead: arb
    angle: acb
    sources: MidpointRadius


class Tumbling(BodyGrowth):
    """S of a body whose momentum is not along its omega.

    `length` is L, `along` omega.m. Over one `period` (None on the separatrix) k grows by `gained`,
    and w turns about M by the unit number `swing`.
    """

    def __init__(self, tensor: Balls, body: FreeBody, scales: Scales, attitude: Attitude) -> None:
        self.begin(tensor, scales, attitude)
        self.body = body
        omega = body.omega(arb(0))
        momentum = rotation.applied(tensor, omega)
        self.length = rotation.dot(momentum, momentum).sqrt()
        self.along = rotation.dot(momentum, omega) / self.length
        self.first = self.axes(arb(0))
        self.instants: list[Instant] = []
        self.period = body.period()
        self.gained = arb(0)
        self.swing = acb(1)
        if self.period is not None:
            self.gained = body.lead(self.period) - body.lead(arb(0))
            self.swing = self.angle(self.period, self.axes(self.period))

    def axes(self, t: arb) -> list[list[arb]]:
        """Unit vectors m, w and b in body axes, as three rows."""
        omega = self.body.omega(t)
        momentum = rotation.applied(self.tensor, omega)
        # m = M/L, b = M x omega/|M x omega|, and w = b x m completes a right-handed frame.
        rate = rotation.cross(momentum, omega)
        magnitude = rotation.dot(rate, rate).sqrt()
        m = [x / self.length for x in momentum]
        b = [x / magnitude for x in rate]
        w = rotation.cross(b, m)
        return [m, w, b]

    def across(self, t: arb) -> arb:
        """The length W = |M x omega|/L [rad/s] of the part of omega across M."""
        omega = self.body.omega(t)
        rate = rotation.cross(rotation.applied(self.tensor, omega), omega)
        return rotation.dot(rate, rate).sqrt() / self.length

    def angle(self, t: arb, axes: Balls) -> acb:
        """The unit number exp(i phi), phi being the angle by which w has turned about M in space.

        `axes` are those of the time t. The start's axes are w0 and b0: exp(i phi) = w.w0 + i w.b0.
        """
        w_now = rotation.rotated(self.body.turn(t), axes[1])
        cosine = rotation.dot(w_now, self.first[1])
        sine = rotation.dot(w_now, self.first[2])
        return acb(cosine, sine)

    def instant(self, t: arb) -> Instant:
        """The axes, W, k, angle and sources at the time t [s]."""
        axes = self.axes(t)
        angle = self.angle(t, axes)
        sources = self.sources(axes, self.length)
        return Instant(t, axes, self.across(t), self.body.lead(t), angle, sources)

    def instants_of(self, count: int) -> list[Instant]:
        """The instants at the middles of the first `count` cells; kept for later calls."""
        while len(self.instants) < count:
            middle = self.cells[len(self.instants)].middle
            self.instants.append(self.instant(arb_of(middle)))
        return self.instants[:count]

    def unrounded_at(self, t: Fraction) -> float:
        """S(t) before it is rounded up: the largest growth of the errors of this period (whole
        cells, and the last one) and of earlier ones.
        """
        time = arb_of(t)
        periods = 0
        since = time
        if self.period is not None:
            periods = int(ball_of(time / self.period).mid)
            since = time - periods * self.period
        elif self.has_parted(time):
            return inf
        now = self.instant(since)
        read = self.read(t, now.axes, self.body.omega(since), self.length)
        elapsed = upper(since)
        self.cover(elapsed)
        # Errors of this period: those of whole cells, and those that are made since the last of
        # them.
        ended = self.ended_by(elapsed)
        rest = max(elapsed - self.end_of(ended), Fraction(0))
        of_last_cell = self.of_cell_of_now(read, now, float(rest))
        bound = max(of_last_cell, self.grown(read, now, since, ended, 0))
        if periods:
            bound = max(bound, self.of_earlier(read, now, since, periods))
        return bound

    def has_parted(self, time: arb) -> bool:
        """True if W(0)/W(t), by which errors of a motion without a period grow, exceeds the range
        of doubles.
        """
        return bool(self.across(arb(0)) / self.across(time) > BOUNDLESS)

    def of_cell_of_now(self, read: MidpointRadius, now: Instant, since: float) -> float:
        """The growth of errors made during the last `since` seconds, for which D(t, t) = 1."""
        unit = exact(np.eye(6)[None])
        return self.largest(read, [unit], now.sources[None], np.array([since * UPWARDS]))

    def of_earlier(self, read: MidpointRadius, now: Instant, since: arb, periods: int) -> float:
        """The growth of errors made in all earlier periods (theorem on all times).

        The most recent ones are taken one by one; of the far ones the norm of A + n N is largest at
        an end.
        """
        assert self.period is not None
        end = upper(self.period)
        self.cover(end)
        # All cells that start before the end of the period.
        count = 1 + bisect_left([cell.high for cell in self.cells], end)
        recent = range(1, min(periods, RECENT - 1) + 1)
        growths = [self.grown(read, now, since, count, n) for n in recent]
        if periods >= RECENT:
            for n in (RECENT, periods):
                growths.append(self.grown(read, now, since, count, n, is_far=True))
        return max(growths)

    def grown(
        self,
        read: MidpointRadius,
        now: Instant,
        since: arb,
        count: int,
        periods: int,
        *,
        is_far: bool = False,
    ) -> float:
        """The growth of errors of the first `count` cells, made `periods` periods ago.

        `now` is the instant `since` its period began, at which the errors are read. Errors of far
        periods (`is_far`) are bounded whatever the angle q is.
        """
        if count == 0:
            return 0.0
        instants = self.instants_of(count)
        if self.period is None:
            whole_periods = arb(0)
        else:
            whole_periods = periods * self.period
        # tau = t - s, and k(t) - k(s), of each cell.
        elapsed = from_balls([since - instant.time + whole_periods for instant in instants])
        gained = periods * self.gained
        leads = from_balls([now.lead - instant.lead + gained for instant in instants])
        across = [instant.across for instant in instants]
        matrices = self.kept_part(now.across, across, elapsed, leads)
        if not is_far:
            # q turns from s to t: exp(i phi(s)) conj(exp(i phi(t))), as exp(i phi) is a unit
            # number.
            back = now.angle.conjugate() * self.swing.conjugate() ** periods
            matrices = matrices + rotating([instant.angle * back for instant in instants])
        sources = together([instant.sources for instant in instants])
        halves = np.array([cell.half for cell in self.cells[:count]])
        return self.largest(read, [matrices], sources, halves, turns_anyhow=is_far)

    def kept_part(
        self, now: arb, across: Sequence[arb], elapsed: MidpointRadius, leads: MidpointRadius
    ) -> MidpointRadius:
        """A + n N of the theorem on all times (cells, 6, 6): D without the part that turns with q.

        `now` is W(t), `across` has W(s) of each cell, `elapsed` t - s, `leads` k(t) - k(s). Rows
        and columns: p, psi_w, psi_b, alpha, beta, gamma.
        """
        # p(t) = p(s) + tau (omega.m alpha(s) + W(s) beta(s)).
        p_by_alpha = elapsed * from_balls([self.along])
        p_by_beta = elapsed * from_balls(across)
        # beta(t) = beta(s) W(s)/W(t).
        beta = from_balls([then / now for then in across])
        # gamma(t) = W(t) (alpha(s) tau + L W(s) (k(t) - k(s)) beta(s) + gamma(s)/W(s)).
        gamma_by_alpha = elapsed * from_balls([now])
        gamma_by_beta = leads * from_balls([self.length * now * then for then in across])
        gamma = from_balls([now / then for then in across])
        one = exact(np.ones(len(across)))
        # psi_w + i psi_b has gamma - i beta, besides what turns.
        return filled(
            {
                (0, 0): one,
                (0, 3): p_by_alpha,
                (0, 4): p_by_beta,
                (1, 3): gamma_by_alpha,
                (1, 4): gamma_by_beta,
                (1, 5): gamma,
                (2, 4): -beta,
                (3, 3): one,
                (4, 4): beta,
                (5, 3): gamma_by_alpha,
                (5, 4): gamma_by_beta,
                (5, 5): gamma,
            }
        )


class Spinning(BodyGrowth):
    """S of a body that spins steadily about its momentum.

    With v the part of J d/L across M, v' = C v, C^2 = -c with a constant c: v(t) = x v(s) + y C
    v(s), where x and y are the cosine of sqrt(c) tau and its sine over sqrt(c), or those of
    hyperbolas. So D depends on tau = t - s alone. The first TURNS are followed cell by cell; later
    |x| and |y| are bounded by what does not fall in time, and the rest is linear in tau.
    """

    def __init__(
        self, tensor: Tensor, omega: Sequence[Number], scales: Scales, attitude: Attitude
    ) -> None:
        self.begin([[arb_of(x) for x in row] for row in tensor], scales, attitude)
        self.omega = [arb_of(x) for x in omega]
        self.rate = rotation.dot(self.omega, self.omega).sqrt()
        moment = moment_about(tensor, omega)
        self.length = arb_of(moment) * self.rate
        self.axes = axes_about([x / self.rate for x in self.omega])
        # C of v' = C v along the two axes across M: M x J^-1 - omega x, with J^-1 = g in the axes.
        to_body = rotation.transposed(self.axes)
        g = rotation.product(rotation.product(self.axes, self.inverse), to_body)
        self.matrix = [
            [-self.length * g[1][2], self.rate - self.length * g[2][2]],
            [self.length * g[1][1] - self.rate, self.length * g[1][2]],
        ]
        # c, and its sign, which is exact where the tensor is.
        share = squared_frequency(tensor, moment)
        self.square = arb_of(share) * self.rate * self.rate
        # The time [s] of TURNS turns.
        self.followed = Fraction(float(2 * arb.pi() * TURNS / self.rate))

    def unrounded_at(self, t: Fraction) -> float:
        """S(t) before it is rounded up: the largest growth over elapsed times of up to TURNS, cell
        by cell, and over longer ones.

        D(tau) = along + x across + y across C + what turns with exp(-i omega tau).
        """
        read = self.read(t, self.axes, self.omega, self.length)
        elapsed = min(t, self.followed)
        self.cover(elapsed)
        ended = self.ended_by(elapsed)
        cells = self.cells[:ended]
        rest = float(elapsed - self.end_of(ended)) * UPWARDS
        # Each cell of elapsed times by its middle, the last one by its end.
        times = [arb_of(cell.middle) for cell in cells] + [arb_of(elapsed)]
        halves = np.array([cell.half for cell in cells] + [rest])
        waves = [self.waves(time) for time in times]
        cosines = [cosine for cosine, _ in waves]
        sines = [sine for _, sine in waves]
        by_cosine, by_sine = self.across_parts(cosines, sines)
        turning = rotating([acb(0, -self.rate * time).exp() for time in times])
        matrices = self.along_part(times) + by_cosine + by_sine + turning
        bound = self.largest(read, [matrices], self.sources_everywhere(), halves)
        if t > elapsed:
            bound = max(bound, self.later(read, t))
        return bound

    def later(self, read: MidpointRadius, t: Fraction) -> float:
        """The growth over more than TURNS and up to t: by what is linear in time at both ends, and
        by the rest at its largest.
        """
        times = [arb_of(self.followed), arb_of(t)]
        cosine, sine = self.largest_waves(arb_of(t))
        by_wave = self.across_parts([cosine, cosine], [sine, sine])
        parts = [self.along_part(times), *by_wave]
        no_width = np.zeros(2)
        return self.largest(read, parts, self.sources_everywhere(), no_width, turns_anyhow=True)

    def sources_everywhere(self) -> MidpointRadius:
        """J d/L (1, 3, 3) of changes of omega by one scale, the same in all cells."""
        return self.sources(self.axes, self.length)[None]

    def along_part(self, times: Sequence[arb]) -> MidpointRadius:
        """The part of D for errors along M (cells, 6, 6): alpha stays, p grows by omega alpha
        tau.
        """
        one = exact(np.ones(len(times)))
        turned = from_balls([time * self.rate for time in times])
        return filled({(0, 0): one, (0, 3): turned, (3, 3): one})

    def across_parts(self, cosines: Sequence[arb], sines: Sequence[arb]) -> list[MidpointRadius]:
        """The two parts of D for changes across M (cells, 6, 6 each): that of x and that of y in
        v(t) = x v(s) + y C v(s), with psi = -i v.

        `cosines` has x and `sines` y of each cell.
        """
        unit = [[arb(1), arb(0)], [arb(0), arb(1)]]
        parts = []
        for factors, matrix in ((cosines, unit), (sines, self.matrix)):
            entries = {}
            for column in (0, 1):
                v_w = from_balls([factor * matrix[0][column] for factor in factors])
                v_b = from_balls([factor * matrix[1][column] for factor in factors])
                entries[4, 4 + column] = v_w
                entries[5, 4 + column] = v_b
                # psi = -i v: psi_w = v_b, psi_b = -v_w.
                entries[1, 4 + column] = v_b
                entries[2, 4 + column] = -v_w
            parts.append(filled(entries))
        return parts

    def waves(self, time: arb) -> tuple[arb, arb]:
        """x and y after a time [s]: the solutions of f'' = -c f from (1, 0) and from (0, 1).

        UnsharpError if the sign of c, which is positive for a stable spin, is not known.
        """
        if self.square.is_zero():
            return arb(1), time
        root = abs(self.square).sqrt()
        angle = root * time
        if self.square > 0:
            return angle.cos(), angle.sin() / root
        if self.square < 0:
            return angle.cosh(), angle.sinh() / root
        raise UnsharpError("whether a spin is stable is not known at this precision")

    def largest_waves(self, t: arb) -> tuple[arb, arb]:
        """Bounds of |x| and |y| over all times up to t."""
        if not self.square > 0:
            # x is cosh or 1, y is sinh over its rate or the time: both grow.
            return self.waves(t)
        root = self.square.sqrt()
        if t < arb.pi() / (2 * root):
            # sin(root t)/root grows up to root t = pi/2.
            return arb(1), (root * t).sin() / root
        return arb(1), 1 / root


def tumbling_growth(
    tensor: Balls, body: FreeBody, turn: Fraction, spin: Fraction, attitude: Attitude
) -> Grows:
    """S of a body whose momentum is not along its omega.

    `tensor` [kg m^2] is in the axes in which `body` gives omega; `turn` [rad] and `spin` [rad/s]
    are the scales of an attitude and of omega; `attitude(t)` is its quaternion, of either sign.
    """
    scales = Scales(turn, spin, quickness(tensor, body.fastest()))
    return Tumbling(tensor, body, scales, attitude)


def steady_growth(
    tensor: Tensor, omega: Sequence[Number], turn: Fraction, spin: Fraction, attitude: Attitude
) -> Grows:
    """S of a body whose momentum is along its omega, or that rests; the arguments are those of
    `tumbling_growth`, with the constant `omega` [rad/s] in place of a motion.
    """
    if not any(omega):
        # psi(t) = psi(s) + (t - s) d, and nothing else changes.
        return Told(lambda t: 1 + t * arb_of(spin / turn))
    balls = [[arb_of(x) for x in row] for row in tensor]
    rates = [arb_of(x) for x in omega]
    fastest = rotation.dot(rates, rates).sqrt()
    scales = Scales(turn, spin, quickness(balls, fastest))
    return Spinning(tensor, omega, scales, attitude)


def quickness(tensor: Balls, fastest: arb) -> float:
    """Bound [1/s] of the Jacobian A(omega) d = J^-1 (J d x omega + J omega x d) of Euler's
    equations for |omega| <= `fastest`.

    A is linear in omega. With A_k its matrix at the unit vector e_k and H_kl = A_k : A_l, |A|^2 <=
    omega . H omega, which |omega|^2 times the Frobenius norm of H bounds. UnsharpError where it is
    not finite.
    """
    tensor_inverse = inverse(tensor)
    units = [[arb(int(i == j)) for j in AXES] for i in AXES]
    jacobians = []
    for k in AXES:
        columns = []
        for j in AXES:
            # A(e_k) e_j.
            first = rotation.cross(rotation.applied(tensor, units[j]), units[k])
            second = rotation.cross(rotation.applied(tensor, units[k]), units[j])
            torque = [a + b for a, b in zip(first, second, strict=True)]
            columns.append(rotation.applied(tensor_inverse, torque))
        jacobians.append([x for column in columns for x in column])
    # Of equal moments A is 0 but for rounding: balls about 0, whose power ** 2 is NaN in
    # python-flint, but whose product is known.
    entries = [rotation.dot(a, b) for a in jacobians for b in jacobians]
    square_of_frobenius = sum([entry * entry for entry in entries], arb(0)).abs_upper()
    bound = fastest * arb(square_of_frobenius).sqrt().sqrt()
    if not bound.is_finite():
        raise UnsharpError("how fast a body tumbles is not known at this precision")
    return float(bound.upper()) * UPWARDS


def moment_about(tensor: Tensor, omega: Sequence[Number]) -> Number:
    """The principal moment J_s [kg m^2] about omega, which is along a principal axis: J omega = J_s
    omega.
    """
    axis = max(AXES, key=lambda i: abs(float(omega[i])))
    if sum(1 for x in omega if x) == 1:
        return tensor[axis][axis]
    moment: Number = dot_exact(tensor[axis], omega) / omega[axis]
    return moment


def squared_frequency(tensor: Tensor, moment: Number) -> Number:
    """c/omega^2 of Spinning, exact if the tensor is.

    C is skew times X = 1 - J_s J^-1, so that c/omega^2 is the product of the two eigenvalues of X
    across omega. The third one is 0: the product is (tr^2 X - tr X^2)/2, the sum of the principal
    minors of X.
    """
    tensor_inverse = inverse(tensor)
    x = [[int(i == j) - moment * tensor_inverse[i][j] for j in AXES] for i in AXES]
    # (tr^2 X - tr X^2)/2, the sum of the principal minors of X = 1 - J_s J^-1.
    minors = [x[i][i] * x[j][j] - x[i][j] * x[j][i] for i, j in ((0, 1), (0, 2), (1, 2))]
    square: Number = minors[0] + minors[1] + minors[2]
    return square


def axes_about(along: Sequence[arb]) -> list[list[arb]]:
    """Three right-handed unit vectors as rows, of which the first is the unit vector `along`."""
    # The coordinate axis that is farthest from `along`: the cross product does not vanish.
    farthest = min(AXES, key=lambda i: abs(float(along[i].mid())))
    unit = [arb(int(i == farthest)) for i in AXES]
    normal = rotation.cross(along, unit)
    length = rotation.dot(normal, normal).sqrt()
    second = [x / length for x in normal]
    return [list(along), second, rotation.cross(along, second)]


def rotating(turns: Sequence[acb]) -> MidpointRadius:
    """The part i q lambda of psi across M (cells, 6, 6), for the unit number q of each cell.

    lambda = J d/L + psi x m across M is, in components along w and b, v - i psi.
    """
    cosine = from_balls([q.real for q in turns])
    sine = from_balls([q.imag for q in turns])
    return filled(
        {
            (1, 1): cosine,
            (1, 2): -sine,
            (2, 1): sine,
            (2, 2): cosine,
            # i q = -sine + i cosine.
            (1, 4): -sine,
            (1, 5): -cosine,
            (2, 4): cosine,
            (2, 5): -sine,
        }
    )


def filled(entries: Mapping[tuple[int, int], MidpointRadius]) -> MidpointRadius:
    """Matrices (cells, 6, 6) with these entries (cells,), and 0 elsewhere."""
    count = max(len(entry.midpoint) for entry in entries.values())
    matrices = exact(np.zeros((count, 6, 6)))
    for (row, column), entry in entries.items():
        matrices.midpoint[:, row, column] = entry.midpoint
        matrices.radius[:, row, column] = entry.radius
    return matrices


def norms_of_read(matrices: MidpointRadius) -> MidpointRadius:
    """Upper bounds (cells, 3) of the norms of the vectors READ of matrices (cells, 9, columns).

    `midpoint` bounds the norms of the doubles, `radius` those of their errors.
    """
    norms = [spectral_norms(matrices[:, rows]) for rows in READ]
    return MidpointRadius(
        np.stack([one.midpoint for one in norms], axis=-1),
        np.stack([one.radius for one in norms], axis=-1),
    )


def spectral_norms(matrices: MidpointRadius) -> MidpointRadius:
    """Upper bounds (cells,) of the largest singular values of matrices (cells, rows, columns)."""
    return MidpointRadius(spectral(matrices.midpoint), spectral(matrices.radius))


def scaled(matrix: Balls, factor: arb) -> list[list[arb]]:
    """The product of a matrix and a number, entry by entry."""
    return [[entry * factor for entry in row] for row in matrix]


def put(matrix: list[list[arb]], rows: slice, columns: slice, block: Balls) -> None:
    """Writes a block into these rows and columns of a matrix."""
    for row, values in zip(matrix[rows], block, strict=True):
        row[columns] = values


def inverse(tensor: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """The inverse of a symmetric tensor, by its cofactors; exact if the tensor is."""

    def cofactor(i: int, j: int) -> Any:
        # The rows and columns that follow i and j in cyclic order give the sign with them.
        first = tensor[(i + 1) % 3]
        second = tensor[(i + 2) % 3]
        k = (j + 1) % 3
        m = (j + 2) % 3
        return first[k] * second[m] - first[m] * second[k]

    cofactors = [[cofactor(i, j) for j in AXES] for i in AXES]
    determinant = dot_exact(tensor[0], cofactors[0])
    return [[value / determinant for value in row] for row in cofactors]


def diagonal(moments: Sequence[Any]) -> list[list[Any]]:
    """The diagonal matrix of these entries, whose zeros are of their type."""
    matrix = [[moment * 0 for _ in AXES] for moment in moments]
    for i in AXES:
        matrix[i][i] = moments[i]
    return matrix
