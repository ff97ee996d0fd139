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

A norm is convex in n, and |q| = 1: over n >= RECENT it is at most the largest of |A + n N| at both
ends plus |B|. Fewer periods are taken one by one. The first of the far ones exceeds B so much that
this loses nothing. So one period of cells is S for ever.

Theorem (cell): for |s - c| <= h a change of omega grows by at most g = exp(a h), a bounding the
Jacobian of Euler's equations, and turns the body by at most h g. So |D(t, s)| <= |D(t, c)_psi| (1 +
h g) + |D(t, c)_omega| g.

A steady spin has W = 0: J d across M obeys an equation of constant coefficients, all else stays,
and D depends on tau alone.
"""

from abc import ABC, abstractmethod
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import inf, isfinite
from typing import Any

import numpy as np
from flint import arb
from numpy.typing import NDArray

from refdem.truth import rotation
from refdem.truth.balls import arb_of, ball_of
from refdem.truth.free_body import FreeBody, dot_exact
from refdem.truth.growth import (
    BOUNDLESS,
    KNOWN,
    ROUNDED,
    UPWARDS,
    WIDEST,
    Grows,
    Told,
    UnsharpError,
    bounded,
    known,
    rounded,
    spectral,
    upper,
)
from refdem.truth.reals import Number

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
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

DOUBLED = 1.0
"""Part of S that what is lost by rounding may have. Only needles lose so much: J^-1 of one with
1e-12 of the other moments cancels twelve digits of sixteen, and the bound of the loss is larger
than the loss. S is at most twice what it bounds then."""
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

    turn: float
    spin: float
    quick: float

    @property
    def shear(self) -> float:
        """How fast a change of omega turns a body, in scales [1/s]."""
        return self.spin / self.turn


@dataclass(frozen=True)
class Cell:
    """Times [low, high] of errors, or times that have passed since."""

    low: Fraction
    high: Fraction

    @property
    def middle(self) -> Fraction:
        """Where D is evaluated."""
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

    def __init__(self, tensor: Balls, scales: Scales, attitude: Attitude) -> None:
        self.scales = scales
        self.attitude = attitude
        self.balls = tensor
        self.tensor = doubles(tensor)
        self.inverse = doubles(inverse(tensor))
        self.cells: list[Cell] = []

    def at(self, t: Fraction) -> float:
        """S(t) >= 1; BOUNDLESS where doubles end."""
        with np.errstate(over="ignore", invalid="ignore"):
            return bounded(self.found_at(t))

    @abstractmethod
    def found_at(self, t: Fraction) -> float:
        """S(t), or what is not finite."""

    def read(self, t: Fraction, frame: Array, omega: Sequence[arb], length: float) -> Array:
        """What is read (9, 6) of psi and J d/L along the axes of `frame`, in scales: the turn,
        omega in body axes and in space.
        """
        space = doubles(rotation.matrix(self.attitude(arb_of(t))), 1.0)
        largest = max(float(abs(value).upper()) for value in omega)
        x, y, z = (known(value, largest) for value in omega)
        crossed = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        # d = J^-1 (J d), and in space the change of omega is R (d - omega x psi).
        changed = length * self.inverse @ frame.T
        found = np.zeros((9, 6))
        found[TURN, TURN] = np.eye(3) / self.scales.turn
        found[BODY, SPIN] = changed / self.scales.spin
        found[SPACE, TURN] = -space @ crossed @ frame.T / self.scales.spin
        found[SPACE, SPIN] = space @ changed / self.scales.spin
        return found

    def sources(self, frames: Array, length: float) -> Array:
        """J d/L along the axes of frames (cells, 3, 3), of changes d of omega in scales: (cells, 3,
        3).
        """
        found: Array = frames @ self.tensor * (self.scales.spin / length)
        return found

    def made(self, matrices: Array, sources: Array) -> tuple[Array, Array]:
        """Matrices (cells, q, 6) on errors in scales: of psi, whose size no axes change, and of
        omega, (cells, q, 3) each.
        """
        by_turn = matrices[..., TURN] * self.scales.turn
        by_spin = matrices[..., SPIN] @ sources
        return by_turn, by_spin

    def largest(self, read: Array, parts: Sequence[Array], sources: Array, halves: Array) -> float:
        """The largest growth of the errors of cells whose ends are `halves` (cells,) [s] from where
        D is the sum of `parts`.

        Each part has shape (cells, 6, 6), and the norm of the sum is bounded by the sum of the
        norms. Infinite where doubles end.
        """
        turns = np.zeros((len(sources), 7))
        spins = np.zeros((len(sources), 7))
        lost = 0.0
        for part in parts:
            by_turn, by_spin = self.made(read @ part, sources)
            turns = turns + row_norms(by_turn)
            spins = spins + row_norms(by_spin)
            sizes = [
                np.linalg.norm(block, axis=(-2, -1)).max(initial=0.0)
                for block in self.made(part, sources)
            ]
            lost += ROUNDED * float(np.linalg.norm(read)) * (float(sizes[0]) + float(sizes[1]))
        # The theorem about cells.
        grown = np.exp(self.scales.quick * halves)[:, None]
        sheared = halves[:, None] * self.scales.shear * grown
        found = float((turns * (1 + sheared) + spins * grown).max(initial=0.0)) * UPWARDS
        if not isfinite(found):
            return inf
        if lost > DOUBLED * found:
            raise UnsharpError(
                "rounding has a larger part in how errors of a body grow than doubles allow",
                final=True,
            )
        return found + lost

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
    """The moving axes m, w, b (rows, in body axes), W [rad/s], k [s/J] and the unit number by which
    w has turned about M in space.
    """

    frame: Array
    across: float
    lead: arb
    angle: complex


class Tumbling(BodyGrowth):
    """S of a body whose momentum is not along its omega."""

    def __init__(self, tensor: Balls, body: FreeBody, scales: Scales, attitude: Attitude) -> None:
        super().__init__(tensor, scales, attitude)
        self.body = body
        omega = body.omega(arb(0))
        momentum = rotation.applied(tensor, omega)
        self.length_ball = rotation.dot(momentum, momentum).sqrt()
        self.length = known(self.length_ball)
        self.along = known(rotation.dot(momentum, omega) / self.length_ball)
        self.first = self.axes(arb(0))
        self.instants: list[Instant] = []
        self.period = body.period()
        self.gained = arb(0)
        self.swing = 1 + 0j
        if self.period is not None:
            self.gained = body.lead(self.period) - body.lead(arb(0))
            self.swing = self.angle(self.period, self.axes(self.period))

    def axes(self, t: arb) -> list[list[arb]]:
        """m, w and b in body axes."""
        omega = self.body.omega(t)
        momentum = rotation.applied(self.balls, omega)
        rate = rotation.cross(momentum, omega)
        size = rotation.dot(rate, rate).sqrt()
        along = [x / self.length_ball for x in momentum]
        beside = [x / size for x in rate]
        across = rotation.cross(beside, along)
        return [along, across, beside]

    def across(self, t: arb) -> arb:
        """W = |M x omega|/L."""
        omega = self.body.omega(t)
        rate = rotation.cross(rotation.applied(self.balls, omega), omega)
        return rotation.dot(rate, rate).sqrt() / self.length_ball

    def angle(self, t: arb, axes: Balls) -> complex:
        """The unit number by which w has turned about M in space since the start."""
        seen = rotation.rotated(self.body.turn(t), axes[1])
        cosine = rotation.dot(seen, self.first[1])
        sine = rotation.dot(seen, self.first[2])
        return complex(known(cosine, 1.0), known(sine, 1.0))

    def instant(self, t: arb) -> Instant:
        """The axes and numbers of a time; UnsharpError where they are not known to doubles."""
        axes = self.axes(t)
        return Instant(
            doubles(axes, 1.0), known(self.across(t)), self.body.lead(t), self.angle(t, axes)
        )

    def instants_of(self, count: int) -> list[Instant]:
        """Those of the middles of the first cells."""
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
        read = self.read(t, now.frame, self.body.omega(since), self.length)
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

    def own(self, read: Array, now: Instant, since: float) -> float:
        """The growth of errors made during the last seconds: the cell about now."""
        whole = np.eye(6)[None]
        sources = self.sources(now.frame[None], self.length)
        return self.largest(read, [whole], sources, np.array([since * UPWARDS]))

    def of_earlier(self, read: Array, now: Instant, since: arb, periods: int) -> float:
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
        read: Array,
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
        cells = self.cells[:count]
        if self.period is None:
            more = arb(0)
        else:
            more = periods * self.period
        times = [since - arb_of(cell.middle) + more for cell in cells]
        leads = [now.lead - instant.lead + periods * self.gained for instant in instants]
        across = np.array([instant.across for instant in instants])
        angles = np.array([instant.angle for instant in instants])
        q = angles * np.conj(now.angle * self.swing**periods)
        changed = self.changed(now.across, across, times, leads)
        turned = rotating(q)
        if is_far:
            parts = [changed, turned]
        else:
            parts = [changed + turned]
        frames = np.array([instant.frame for instant in instants])
        return self.largest(
            read, parts, self.sources(frames, self.length), np.array([cell.half for cell in cells])
        )

    def changed(
        self, now: float, across: Array, times: Sequence[arb], leads: Sequence[arb]
    ) -> Array:
        """D without q (cells, 6, 6) of errors made where W is `across`, when it is `now`: A + n N
        of the theorem.
        """
        elapsed, blur = rounded(times)
        lead, lead_blur = rounded(leads)
        found = np.zeros((len(across), 6, 6))
        found[:, 0, 0] = 1.0
        found[:, 0, 3] = elapsed * self.along
        found[:, 0, 4] = elapsed * across
        found[:, 3, 3] = 1.0
        found[:, 4, 4] = across / now
        found[:, 5, 3] = elapsed * now
        found[:, 5, 4] = self.length * now * across * lead
        found[:, 5, 5] = now / across
        # psi across M has gamma - i beta.
        found[:, 1] = found[:, 5]
        found[:, 2] = -found[:, 4]
        fastest = self.along + now + float(across.max())
        off = blur * fastest + lead_blur * self.length * now * float(across.max())
        if off > float(KNOWN) * float(np.abs(found).max()):
            raise UnsharpError(
                "how errors of a body grow is not known well enough at this precision"
            )
        return found


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
        super().__init__([[arb_of(x) for x in row] for row in tensor], scales, attitude)
        self.omega = [arb_of(x) for x in omega]
        rate = rotation.dot(self.omega, self.omega).sqrt()
        self.rate = known(rate)
        moment = own_moment(tensor, omega)
        self.length = known(arb_of(moment) * rate)
        axes = axes_about([x / rate for x in self.omega])
        self.frame = doubles(axes, 1.0)
        # C of v' = C v along the two axes across M: M x J^-1 - omega x, with J^-1 = g.
        g = rotation.product(rotation.product(axes, inverse(self.balls)), rotation.transposed(axes))
        momentum = arb_of(moment) * rate
        matrix = [
            [-momentum * g[1][2], rate - momentum * g[2][2]],
            [momentum * g[1][1] - rate, momentum * g[1][2]],
        ]
        self.matrix = doubles(matrix, float(rate.upper()))
        self.square = known(arb_of(swinging(tensor, moment)) * rate * rate)
        self.followed = Fraction(float(2 * arb.pi() * TURNS / rate))

    def found_at(self, t: Fraction) -> float:
        read = self.read(t, self.frame, self.omega, self.length)
        near = min(t, self.followed)
        self.cover(near)
        cells = self.cells[: self.ended_by(near)]
        if cells:
            begun = cells[-1].high
        else:
            begun = Fraction(0)
        times = np.array([float(cell.middle) for cell in cells] + [float(near)])
        halves = np.array([cell.half for cell in cells] + [float(near - begun) * UPWARDS])
        kept = self.kept(times)
        swung = sum(self.swung(*self.waves(times)), np.zeros((len(times), 6, 6)))
        turned = rotating(np.exp(-1j * self.rate * times))
        found = self.largest(read, [kept + swung + turned], self.spread(len(times)), halves)
        if t > near:
            found = max(found, self.later(read, float(t)))
        return found

    def later(self, read: Array, t: float) -> float:
        """The growth from TURNS to t: by what is linear in time at both ends, and by the rest at
        its largest.
        """
        times = np.array([float(self.followed), t])
        turned = rotating(np.ones(2))
        cosine, sine = self.most(t)
        swung = self.swung(np.full(2, cosine), np.full(2, sine))
        return self.largest(read, [self.kept(times), *swung, turned], self.spread(2), np.zeros(2))

    def spread(self, count: int) -> Array:
        """J d/L of errors, the same in all cells."""
        sources = self.sources(self.frame[None], self.length)
        return np.repeat(sources, count, axis=0)

    def kept(self, times: Array) -> Array:
        """What errors along M become (cells, 6, 6)."""
        found = np.zeros((len(times), 6, 6))
        found[:, 0, 0] = 1.0
        found[:, 0, 3] = times * self.rate
        found[:, 3, 3] = 1.0
        return found

    def swung(self, cosine: Array, sine: Array) -> list[Array]:
        """What changes across M become, v and psi = -i v: the parts of x and of y (cells, 6, 6)."""
        parts = []
        for size, matrix in ((cosine, np.eye(2)), (sine, self.matrix)):
            found = np.zeros((len(size), 6, 6))
            found[:, 4:6, 4:6] = size[:, None, None] * matrix
            found[:, 1] = found[:, 5]
            found[:, 2] = -found[:, 4]
            parts.append(found)
        return parts

    def waves(self, times: Array) -> tuple[Array, Array]:
        """x and y at times that have passed."""
        root = abs(self.square) ** 0.5
        if root == 0.0:
            return np.ones_like(times), times
        if self.square > 0:
            return np.cos(root * times), np.sin(root * times) / root
        return np.cosh(root * times), np.sinh(root * times) / root

    def most(self, t: float) -> tuple[float, float]:
        """Bounds of |x| and |y| up to t."""
        if self.square > 0:
            quarter = np.pi / 2 / self.square**0.5
            _, sine = self.waves(np.array([min(t, quarter)]))
            return 1.0, float(sine[0])
        cosine, sine = self.waves(np.array([t]))
        return float(cosine[0]), float(sine[0])


def tumbling_growth(
    tensor: Balls, body: FreeBody, turn: Fraction, spin: Fraction, attitude: Attitude
) -> Grows:
    """S of a body whose momentum is not along its omega, `body` being told in the axes of the
    tensor.

    `turn` and `spin` are the scales of an attitude and of omega; `attitude(t)` is its quaternion,
    of either sign.
    """
    scales = Scales(float(turn), float(spin), quickness(tensor, body.fastest()))
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
    scales = Scales(float(turn), float(spin), quickness(balls, fastest))
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


def rotating(q: Complex | Array) -> Array:
    """i q lambda, which psi across M has of lambda = v - i psi: (cells, 6, 6)."""
    found = np.zeros((len(q), 6, 6))
    for factor, columns in ((q, (1, 2)), (1j * q, (4, 5))):
        first, second = columns
        found[:, 1, first] = factor.real
        found[:, 1, second] = -factor.imag
        found[:, 2, first] = factor.imag
        found[:, 2, second] = factor.real
    return found


def row_norms(matrices: Array) -> Array:
    """Norms (cells, 7) of the turn and of the other six rows of matrices (cells, 9, 3)."""
    turn = spectral(matrices[:, TURN])
    others = np.linalg.norm(matrices[:, 3:], axis=-1)
    return np.concatenate([turn[:, None], others], axis=1)


def doubles(matrix: Balls, size: float = 0.0) -> Array:
    """The doubles of a matrix of balls."""
    return np.array([[known(x, size) for x in row] for row in matrix])


def inverse(tensor: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """The inverse of a symmetric tensor, by its cofactors; exact if the tensor is."""
    cofactors = [
        [
            tensor[(i + 1) % 3][(j + 1) % 3] * tensor[(i + 2) % 3][(j + 2) % 3]
            - tensor[(i + 1) % 3][(j + 2) % 3] * tensor[(i + 2) % 3][(j + 1) % 3]
            for j in AXES
        ]
        for i in AXES
    ]
    size = dot_exact(tensor[0], cofactors[0])
    return [[value / size for value in row] for row in cofactors]


def diagonal(moments: Sequence[Any]) -> list[list[Any]]:
    """The tensor of a body in its principal axes."""
    return [[moments[i] if i == j else moments[i] * 0 for j in AXES] for i in AXES]
