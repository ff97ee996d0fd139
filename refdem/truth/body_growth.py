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
the same |M|), where k' = (w J^-1 w - b J^-1 b)/W^2: the equation along b says so. These three span
all changes, which gives alpha, beta, gamma. (psi . M)' = d . M = dE gives p. In space the change of
the momentum, R (J d + psi x M), is constant: in body axes lambda turns about m as axes fixed in
space do, by the unit number q, and psi across M is m x (lambda - J d/L).

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
bounds of near.py, entry by entry: D of a needle has entries of 1e12 that meet others of 1e-12, and
no bound by norms could tell that little is lost.

Hypotheses, and where each is checked:

* W is not 0, so that the axes exist: the exact start decides which bodies spin steadily
  (free_body.kind, RigidCluster.is_steady), and these are `Spinning`; a W whose ball holds 0 makes
  what follows not finite, which `near` refuses with UndecidedError;
* k is that of the motion: `FreeBody.lead`, in closed form for each kind of motion;
* omega repeats after P: `FreeBody.period`, which is None on the separatrix;
* a bounds the Jacobian of Euler's equations along the whole motion: `quickness`, from
  `FreeBody.fastest`;
* the cells cover all times at which errors are made: `BodyGrowth.cover`; errors of the cell that
  holds t are `Tumbling.own`;
* what doubles may have lost is a small part of S: `BodyGrowth.largest` compares it with LOST.
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
    LOST,
    UPWARDS,
    WIDEST,
    Grows,
    Told,
    UnsharpError,
    bounded,
    spectral,
    upper,
)
from refdem.truth.near import Near, exact, near, together
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
"""Rows that are read besides the turn: each component of omega in body axes and in space."""
ACROSS = slice(1, 3)
"""Components along w and b."""

RECENT = 4
"""Periods between an error and its effect that are taken one by one."""
TURNS = 16
"""Turns of a steady spin that are followed cell by cell, before its drift exceeds all that turns.
"""
SHARE = Fraction(1, 16)
"""Width of a cell as part of its time: a change of omega made at 0 turns the body 16 times as much
as one made in the cell.
"""


@dataclass(frozen=True)
class Scales:
    """Scales of a turn [rad] and of omega [rad/s], and `quick`, a bound of the Jacobian of Euler's
    equations [1/s].
    """

    turn: Fraction
    spin: Fraction
    quick: float

    @property
    def shear(self) -> float:
        """How fast a change of omega turns a body, in scales [1/s]."""
        return float(self.spin / self.turn)


@dataclass(frozen=True)
class Cell:
    """Times [low, high] of errors, or times that have passed since."""

    low: Fraction
    high: Fraction

    @property
    def middle(self) -> Fraction:
        """The middle of the interval, at which D is evaluated."""
        return (self.low + self.high) / 2

    @property
    def half(self) -> float:
        """How far the ends are from it."""
        return float(self.high - self.low) / 2 * UPWARDS


def next_cell(low: Fraction, scales: Scales) -> Cell:
    """A cell in which g <= exp(WIDEST), and h g is small beside 1 or beside what errors made at 0
    have grown to at `low`.
    """
    narrow = Fraction(2 * WIDEST / max(scales.quick, scales.shear))
    width = max(narrow, low * SHARE)
    if scales.quick > 0:
        width = min(width, Fraction(2 * WIDEST / scales.quick))
    return Cell(low, low + dyadic(width))


def dyadic(width: Fraction) -> Fraction:
    """Rounded down to about 8 bits, so that sums stay short."""
    exponent = width.numerator.bit_length() - width.denominator.bit_length() - 8
    unit = Fraction(2) ** exponent
    return width // unit * unit


class BodyGrowth(ABC):
    """S of a body with this tensor [kg m^2]; what is read of it needs its `attitude` in space."""

    def begin(self, tensor: Balls, scales: Scales, attitude: Attitude) -> None:
        """Sets what both kinds of motion begin with."""
        self.scales = scales
        self.attitude = attitude
        self.tensor = tensor
        self.inverse = inverse(tensor)
        self.cells: list[Cell] = []

    def at(self, t: Fraction) -> float:
        """S(t) >= 1; BOUNDLESS where doubles end."""
        with np.errstate(over="ignore", invalid="ignore"):
            return bounded(self.found_at(t))

    @abstractmethod
    def found_at(self, t: Fraction) -> float:
        """S(t), or what is not finite."""

    def read(self, t: Fraction, axes: Balls, omega: Sequence[arb], length: arb) -> Near:
        """What is read (9, 6) of psi and J d/L along `axes`, in scales: the turn, omega in body
        axes and in space.
        """
        back = rotation.transposed(axes)
        space = rotation.matrix(self.attitude(arb_of(t)))
        spin = arb_of(self.scales.spin)
        turn = arb_of(self.scales.turn)
        # d = J^-1 (J d), and in space the change of omega is R (d - omega x psi).
        changed = scaled(rotation.product(self.inverse, back), length / spin)
        x, y, z = omega
        crossed = [[arb(0), -z, y], [z, arb(0), -x], [-y, x, arb(0)]]
        swept = rotation.product(rotation.product(space, crossed), back)
        found = [[arb(0)] * 6 for _ in range(9)]
        put(found, TURN, TURN, scaled(diagonal([arb(1)] * 3), 1 / turn))
        put(found, BODY, SPIN, changed)
        put(found, SPACE, TURN, scaled(swept, -1 / spin))
        put(found, SPACE, SPIN, rotation.product(space, changed))
        return near(found)

    def sources(self, axes: Balls, length: arb) -> Near:
        """J d/L along axes (3, 3), of changes d of omega in scales."""
        return near(scaled(rotation.product(axes, self.tensor), arb_of(self.scales.spin) / length))

    def largest(
        self,
        read: Near,
        parts: Sequence[Near],
        sources: Near,
        halves: Array,
        *,
        turns_anyhow: bool = False,
    ) -> float:
        """The largest growth of the errors of cells whose ends are `halves` (cells,) [s] from where
        D is the sum of `parts`.

        Each part has shape (cells, 6, 6), and the norm of the sum is bounded by the sum of the
        norms; `turns_anyhow` adds i q lambda for any q. Infinite where doubles end.
        """
        one_turn = near([arb_of(self.scales.turn)])
        turns = exact(np.zeros((1, 7)))
        spins = exact(np.zeros((1, 7)))
        for part in parts:
            grown = read @ part
            turns = turns + row_norms(grown[..., TURN] * one_turn)
            spins = spins + row_norms(grown[..., SPIN] @ sources)
        if turns_anyhow:
            reach = row_norms(read[None, :, ACROSS])
            turns = turns + reach * one_turn
            spins = spins + reach * spectral_norms(sources[:, ACROSS])[:, None]
        # The theorem about cells.
        omega_grown = np.exp(self.scales.quick * halves)[:, None]
        turned_by_it = halves[:, None] * self.scales.shear * omega_grown
        told = turns.middle * (1 + turned_by_it) + spins.middle * omega_grown
        lost = turns.off * (1 + turned_by_it) + spins.off * omega_grown
        found = float((told + lost).max(initial=0.0)) * UPWARDS
        if not isfinite(found):
            return inf
        if float(lost.max(initial=0.0)) > LOST * found:
            raise UnsharpError("how errors of a body grow is not known well at this precision")
        return found

    def cover(self, until: Fraction) -> None:
        """Makes the cells that cover [0, until]."""
        while not self.cells or self.cells[-1].high < until:
            if self.cells:
                low = self.cells[-1].high
            else:
                low = Fraction(0)
            self.cells.append(next_cell(low, self.scales))

    def ended_by(self, time: Fraction) -> int:
        """How many cells end by a time up to which they are made."""
        return bisect_right([cell.high for cell in self.cells], time)


@dataclass(frozen=True)
class Instant:
    """The moving axes m, w, b (rows, in body axes) at a time, W [rad/s], k [s/J] and the unit
    number by which w has turned about M in space; `sources`: what errors are made of there.
    """

    time: arb
    axes: Balls
    across: arb
    lead: arb
    angle: acb
    sources: Near


class Tumbling(BodyGrowth):
    """S of a body whose momentum is not along its omega."""

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
        rate = rotation.cross(momentum, omega)
        size = rotation.dot(rate, rate).sqrt()
        along = [x / self.length for x in momentum]
        beside = [x / size for x in rate]
        across = rotation.cross(beside, along)
        return [along, across, beside]

    def across(self, t: arb) -> arb:
        """The magnitude W = |M x omega|/L of the scaled torque."""
        omega = self.body.omega(t)
        rate = rotation.cross(rotation.applied(self.tensor, omega), omega)
        return rotation.dot(rate, rate).sqrt() / self.length

    def angle(self, t: arb, axes: Balls) -> acb:
        """The unit number by which w has turned about M in space since the start."""
        seen = rotation.rotated(self.body.turn(t), axes[1])
        cosine = rotation.dot(seen, self.first[1])
        sine = rotation.dot(seen, self.first[2])
        return acb(cosine, sine)

    def instant(self, t: arb) -> Instant:
        """The axes and numbers of a time."""
        axes = self.axes(t)
        angle = self.angle(t, axes)
        sources = self.sources(axes, self.length)
        return Instant(t, axes, self.across(t), self.body.lead(t), angle, sources)

    def instants_of(self, count: int) -> list[Instant]:
        """The instants at the middles of the first cells."""
        while len(self.instants) < count:
            middle = self.cells[len(self.instants)].middle
            self.instants.append(self.instant(arb_of(middle)))
        return self.instants[:count]

    def found_at(self, t: Fraction) -> float:
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
        passed = upper(since)
        self.cover(passed)
        # Errors of this period: those of whole cells, and those that are made since the last of
        # them.
        ended = self.ended_by(passed)
        if ended:
            begun = self.cells[ended - 1].high
        else:
            begun = Fraction(0)
        found = self.own(read, now, float(max(passed - begun, Fraction(0))))
        found = max(found, self.grown(read, now, since, ended, 0))
        if periods:
            found = max(found, self.of_earlier(read, now, since, periods))
        return found

    def has_parted(self, time: arb) -> bool:
        """Whether neighbours of a motion without a period have parted by more than doubles can
        say.
        """
        return bool(self.across(arb(0)) / self.across(time) > BOUNDLESS)

    def own(self, read: Near, now: Instant, since: float) -> float:
        """The growth of errors made during the last seconds: the cell about now."""
        whole = exact(np.eye(6)[None])
        return self.largest(read, [whole], now.sources[None], np.array([since * UPWARDS]))

    def of_earlier(self, read: Near, now: Instant, since: arb, periods: int) -> float:
        """The growth of errors made in all earlier periods."""
        assert self.period is not None
        end = upper(self.period)
        self.cover(end)
        count = 1 + bisect_left([cell.high for cell in self.cells], end)
        recent = range(1, min(periods, RECENT - 1) + 1)
        found = [self.grown(read, now, since, count, n) for n in recent]
        if periods >= RECENT:
            found += [
                self.grown(read, now, since, count, n, is_far=True) for n in (RECENT, periods)
            ]
        return max(found)

    def grown(
        self,
        read: Near,
        now: Instant,
        since: arb,
        count: int,
        periods: int,
        *,
        is_far: bool = False,
    ) -> float:
        """The growth of errors of the first `count` cells, made so many periods ago; if it
        `is_far`, whatever the angle q.
        """
        if count == 0:
            return 0.0
        instants = self.instants_of(count)
        if self.period is None:
            more = arb(0)
        else:
            more = periods * self.period
        elapsed = near([since - instant.time + more for instant in instants])
        gained = periods * self.gained
        leads = near([now.lead - instant.lead + gained for instant in instants])
        grown = self.changed(now.across, [one.across for one in instants], elapsed, leads)
        if not is_far:
            # Of the unit number since the start, conj(q) is the inverse.
            back = now.angle.conjugate() * self.swing.conjugate() ** periods
            grown = grown + rotating([instant.angle * back for instant in instants])
        sources = together([instant.sources for instant in instants])
        halves = np.array([cell.half for cell in self.cells[:count]])
        return self.largest(read, [grown], sources, halves, turns_anyhow=is_far)

    def changed(self, now: arb, across: Sequence[arb], elapsed: Near, leads: Near) -> Near:
        """D without q (cells, 6, 6) of errors made where W is `across`, when it is `now`: A + n N
        of the theorem.
        """
        by_turn = elapsed * near([self.along])
        by_energy = elapsed * near(across)
        beta = near([then / now for then in across])
        gamma_by_momentum = elapsed * near([now])
        gamma_by_energy = leads * near([self.length * now * then for then in across])
        gamma = near([now / then for then in across])
        one = exact(np.ones(len(across)))
        # psi across M has gamma - i beta.
        return filled(
            {
                (0, 0): one,
                (0, 3): by_turn,
                (0, 4): by_energy,
                (1, 3): gamma_by_momentum,
                (1, 4): gamma_by_energy,
                (1, 5): gamma,
                (2, 4): -beta,
                (3, 3): one,
                (4, 4): beta,
                (5, 3): gamma_by_momentum,
                (5, 4): gamma_by_energy,
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
        moment = own_moment(tensor, omega)
        self.length = arb_of(moment) * self.rate
        self.axes = axes_about([x / self.rate for x in self.omega])
        # C of v' = C v along the two axes across M: M x J^-1 - omega x, with J^-1 = g.
        back = rotation.transposed(self.axes)
        g = rotation.product(rotation.product(self.axes, self.inverse), back)
        self.matrix = [
            [-self.length * g[1][2], self.rate - self.length * g[2][2]],
            [self.length * g[1][1] - self.rate, self.length * g[1][2]],
        ]
        # c, and its sign, which is exact where the tensor is.
        share = swinging(tensor, moment)
        self.square = arb_of(share) * self.rate * self.rate
        self.followed = Fraction(float(2 * arb.pi() * TURNS / self.rate))

    def found_at(self, t: Fraction) -> float:
        read = self.read(t, self.axes, self.omega, self.length)
        passed = min(t, self.followed)
        self.cover(passed)
        cells = self.cells[: self.ended_by(passed)]
        if cells:
            begun = cells[-1].high
        else:
            begun = Fraction(0)
        times = [arb_of(cell.middle) for cell in cells] + [arb_of(passed)]
        halves = np.array([cell.half for cell in cells] + [float(passed - begun) * UPWARDS])
        waves = [self.waves(time) for time in times]
        cosines = [cosine for cosine, _ in waves]
        sines = [sine for _, sine in waves]
        swung = self.swung(cosines, sines)
        turned = rotating([acb(0, -self.rate * time).exp() for time in times])
        grown = self.kept(times) + swung[0] + swung[1] + turned
        found = self.largest(read, [grown], self.spread(), halves)
        if t > passed:
            found = max(found, self.later(read, t))
        return found

    def later(self, read: Near, t: Fraction) -> float:
        """The growth from TURNS to t: by what is linear in time at both ends, and by the rest at
        its largest.
        """
        times = [arb_of(self.followed), arb_of(t)]
        cosine, sine = self.most(arb_of(t))
        swung = self.swung([cosine, cosine], [sine, sine])
        parts = [self.kept(times), *swung]
        return self.largest(read, parts, self.spread(), np.zeros(2), turns_anyhow=True)

    def spread(self) -> Near:
        """J d/L of errors, the same in all cells."""
        return self.sources(self.axes, self.length)[None]

    def kept(self, times: Sequence[arb]) -> Near:
        """What errors along M become (cells, 6, 6)."""
        one = exact(np.ones(len(times)))
        turned = near([time * self.rate for time in times])
        return filled({(0, 0): one, (0, 3): turned, (3, 3): one})

    def swung(self, cosines: Sequence[arb], sines: Sequence[arb]) -> list[Near]:
        """What changes across M become, v and psi = -i v: the parts of x and of y (cells, 6, 6)."""
        one = [[arb(1), arb(0)], [arb(0), arb(1)]]
        parts = []
        for sizes, matrix in ((cosines, one), (sines, self.matrix)):
            entries = {}
            for column in (0, 1):
                first = near([size * matrix[0][column] for size in sizes])
                second = near([size * matrix[1][column] for size in sizes])
                entries[4, 4 + column] = first
                entries[5, 4 + column] = second
                entries[1, 4 + column] = second
                entries[2, 4 + column] = -first
            parts.append(filled(entries))
        return parts

    def waves(self, time: arb) -> tuple[arb, arb]:
        """x and y at a time that has passed."""
        if self.square.is_zero():
            return arb(1), time
        root = abs(self.square).sqrt()
        angle = root * time
        if self.square > 0:
            return angle.cos(), angle.sin() / root
        if self.square < 0:
            return angle.cosh(), angle.sinh() / root
        raise UnsharpError("whether a spin is stable is not known at this precision")

    def most(self, t: arb) -> tuple[arb, arb]:
        """Bounds of |x| and |y| up to t."""
        if not self.square > 0:
            return self.waves(t)
        root = self.square.sqrt()
        if t < arb.pi() / (2 * root):
            return arb(1), (root * t).sin() / root
        return arb(1), 1 / root


def tumbling_growth(
    tensor: Balls, body: FreeBody, turn: Fraction, spin: Fraction, attitude: Attitude
) -> Grows:
    """S of a body whose momentum is not along its omega, `body` being told in the axes of the
    tensor.

    `turn` and `spin` are the scales of an attitude and of omega; `attitude(t)` is its quaternion,
    of either sign.
    """
    scales = Scales(turn, spin, quickness(tensor, body.fastest()))
    return Tumbling(tensor, body, scales, attitude)


def steady_growth(
    tensor: Tensor, omega: Sequence[Number], turn: Fraction, spin: Fraction, attitude: Attitude
) -> Grows:
    """S of a body whose momentum is along its omega, or that rests, in any axes."""
    if not any(omega):
        # psi(t) = psi(s) + (t - s) d, and nothing else changes.
        return Told(lambda t: 1 + t * arb_of(spin / turn))
    balls = [[arb_of(x) for x in row] for row in tensor]
    rates = [arb_of(x) for x in omega]
    fastest = rotation.dot(rates, rates).sqrt()
    scales = Scales(turn, spin, quickness(balls, fastest))
    return Spinning(tensor, omega, scales, attitude)


def quickness(tensor: Balls, fastest: arb) -> float:
    """Bound [1/s] of the Jacobian a(omega) d = J^-1 (J d x omega + J omega x d) of Euler's
    equations for |omega| <= `fastest`.

    With a_k its values at the unit vectors and H_kl = a_k : a_l, |a|^2 <= omega . H omega, which
    the Frobenius norm of H bounds.
    """
    back = inverse(tensor)
    units = [[arb(int(i == j)) for j in AXES] for i in AXES]
    slopes = []
    for k in AXES:
        columns = []
        for j in AXES:
            first = rotation.cross(rotation.applied(tensor, units[j]), units[k])
            second = rotation.cross(rotation.applied(tensor, units[k]), units[j])
            columns.append(
                rotation.applied(back, [a + b for a, b in zip(first, second, strict=True)])
            )
        slopes.append([x for column in columns for x in column])
    squares = [rotation.dot(a, b) ** 2 for a in slopes for b in slopes]
    whole = sum(squares, arb(0)).abs_upper()
    return float((fastest * arb(whole).sqrt().sqrt()).upper()) * UPWARDS


def own_moment(tensor: Tensor, omega: Sequence[Number]) -> Number:
    """The principal moment about omega, which is along a principal axis."""
    axis = max(AXES, key=lambda i: abs(float(omega[i])))
    if sum(1 for x in omega if x) == 1:
        return tensor[axis][axis]
    found: Number = dot_exact(tensor[axis], omega) / omega[axis]
    return found


def swinging(tensor: Tensor, moment: Number) -> Number:
    """c/omega^2 of Spinning, exact if the tensor is: with X = 1 - J_s J^-1, whose third eigenvalue
    is 0, (tr^2 X - tr X^2)/2.
    """
    back = inverse(tensor)
    x = [[int(i == j) - moment * back[i][j] for j in AXES] for i in AXES]
    minors = [x[i][i] * x[j][j] - x[i][j] * x[j][i] for i, j in ((0, 1), (0, 2), (1, 2))]
    found: Number = minors[0] + minors[1] + minors[2]
    return found


def axes_about(along: Sequence[arb]) -> list[list[arb]]:
    """Right-handed unit vectors, the first of them given."""
    least = min(AXES, key=lambda i: abs(float(along[i].mid())))
    unit = [arb(int(i == least)) for i in AXES]
    beside = rotation.cross(along, unit)
    size = rotation.dot(beside, beside).sqrt()
    second = [x / size for x in beside]
    return [list(along), second, rotation.cross(along, second)]


def rotating(turns: Sequence[acb]) -> Near:
    """i q lambda, which psi across M has of lambda = v - i psi: (cells, 6, 6)."""
    cosine = near([q.real for q in turns])
    sine = near([q.imag for q in turns])
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


def filled(entries: Mapping[tuple[int, int], Near]) -> Near:
    """Matrices (cells, 6, 6) with these entries (cells,), and 0 elsewhere."""
    count = max(len(entry.middle) for entry in entries.values())
    found = exact(np.zeros((count, 6, 6)))
    for (row, column), entry in entries.items():
        found.middle[:, row, column] = entry.middle
        found.off[:, row, column] = entry.off
    return found


def row_norms(matrices: Near) -> Near:
    """Upper bounds (cells, 7) of the norms of the turn and of the other six rows of matrices
    (cells, 9, columns): `middle` of what stands for them, `off` of what that may be off.
    """
    turn = spectral_norms(matrices[:, TURN])
    middle = np.linalg.norm(matrices.middle[:, 3:], axis=-1)
    off = np.linalg.norm(matrices.off[:, 3:], axis=-1)
    return Near(
        np.concatenate([turn.middle[:, None], middle], axis=1),
        np.concatenate([turn.off[:, None], off], axis=1),
    )


def spectral_norms(matrices: Near) -> Near:
    """The same of the largest singular values (cells,) of matrices (cells, rows, columns)."""
    return Near(spectral(matrices.middle), spectral(matrices.off))


def scaled(matrix: Balls, factor: arb) -> list[list[arb]]:
    """The product of a matrix and a number, entry by entry."""
    return [[entry * factor for entry in row] for row in matrix]


def put(matrix: list[list[arb]], rows: slice, columns: slice, block: Balls) -> None:
    """Writes a block into a matrix."""
    for row, values in zip(matrix[rows], block, strict=True):
        row[columns] = values


def inverse(tensor: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """The inverse of a symmetric tensor, by its cofactors; exact if the tensor is."""

    def cofactor(i: int, j: int) -> Any:
        first = tensor[(i + 1) % 3]
        second = tensor[(i + 2) % 3]
        k = (j + 1) % 3
        m = (j + 2) % 3
        return first[k] * second[m] - first[m] * second[k]

    cofactors = [[cofactor(i, j) for j in AXES] for i in AXES]
    size = dot_exact(tensor[0], cofactors[0])
    return [[value / size for value in row] for row in cofactors]


def diagonal(moments: Sequence[Any]) -> list[list[Any]]:
    """The tensor of a body in its principal axes."""
    return [[moments[i] if i == j else moments[i] * 0 for j in AXES] for i in AXES]
