"""A mass on a rotating shaft: m z'' + (c_e + c_i) z' + (k - i c_i W) z = 0 with z = x + i y.

With 2 b = (c_e + c_i)/m, w0^2 = k/m and n = c_i W/m the roots are q = -b +- s, and

    s^2 = b^2 - w0^2 + i n,
    C = exp(-b t) cosh s t,    D = exp(-b t) (sinh s t)/s,
    z = z0 (C + b D) + v0 D,   z' = v0 (C - b D) - (w0^2 - i n) z0 D.

C and D are even in s, so that either square root s can be taken. For a double root, s = 0, which
is decided in rationals, D = exp(-b t) t.

Border of stability: for q = i w on the imaginary axis the real part of the polynomial is 0 for w =
+-w0, and the imaginary part for 2 b w = n. So one root crosses the axis at

    |W| = w0 (1 + c_e/c_i);

the other root has the real part -2 b < 0 there, as the sum of both is -2 b.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import acb, arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import ClosedForm, displaced_tuple, per_precision
from refdem.truth.exact import numbers, vector
from refdem.truth.growth import Grows, Norm, SteadyGrowth, Told, narrow
from refdem.truth.refiner import Refiner
from refdem.truth.smooth_flow import derivative_by_start
from refdem.truth.validated_flow import ValidatedFlow

NAMES = ("x", "y", "vx", "vy")


@dataclass(frozen=True, kw_only=True)
class WhirlingShaft(ClosedForm):
    """x, y [m] and vx, vy [m/s] at t from the start `begin` = (x0, y0, vx0, vy0)."""

    method = "closed form in the complex plane; double root and border decided in exact rationals"
    witness = "Taylor integration of Newton's law in Cartesian coordinates; power of the dashpots"
    state = NAMES

    mass: Fraction
    stiffness: Fraction
    outer_damping: Fraction
    inner_damping: Fraction
    turning: Fraction
    begin: tuple[Fraction, ...]

    displaced = displaced_tuple("begin")
    jacobian = derivative_by_start

    @property
    def square(self) -> Fraction:
        """The square w0^2 = k/m of the angular frequency [1/s^2]."""
        return self.stiffness / self.mass

    @property
    def decay(self) -> Fraction:
        """The rate of decay b = (c_e + c_i)/(2 m) [1/s]."""
        return (self.outer_damping + self.inner_damping) / (2 * self.mass)

    @property
    def push(self) -> Fraction:
        """The push n = c_i W/m of the inner damping [1/s^2]."""
        return self.inner_damping / self.mass * self.turning

    @property
    def is_at_border(self) -> bool:
        """True if a root lies on the imaginary axis: n^2 = (2 b)^2 w0^2."""
        # |n| = 2 b w0, from 2 b w = n at w = +-w0.
        return self.push**2 == 4 * self.decay**2 * self.square

    def half_gap(self) -> acb:
        """s, half the difference of the roots, with a real part >= 0."""
        # s = sqrt(b^2 - w0^2 + i n).
        real = arb_of(self.decay**2 - self.square)
        return acb(real, arb_of(self.push)).sqrt()

    def shapes(self, t: arb) -> tuple[acb, acb]:
        """The functions C and D [s] of the motion at time t."""
        # C = exp(-b t) cosh s t,  D = exp(-b t) sinh(s t)/s, or exp(-b t) t for s = 0
        fade = (-arb_of(self.decay) * t).exp()
        if self.push == 0 and self.decay**2 == self.square:
            return acb(fade), acb(fade * t)
        s = self.half_gap()
        phase = s * t
        return phase.cosh() * fade, phase.sinh() / s * fade

    def moved(self, t: arb) -> tuple[acb, acb, acb, acb]:
        """The factors of z0 and v0 in z and v at time t: (z by z0, z by v0, v by z0, v by v0)."""
        # z = (C + b D) z0 + D v0,  z' = -(w0^2 - i n) D z0 + (C - b D) v0
        c, d = self.shapes(t)
        b = arb_of(self.decay)
        stiffness = acb(arb_of(self.square), -arb_of(self.push))
        return c + b * d, d, -stiffness * d, c - b * d

    def evaluate(self, t: arb) -> dict[str, arb]:
        """Place and velocity at time t."""
        x0, y0, vx0, vy0 = (arb_of(value) for value in self.begin)
        place = acb(x0, y0)
        velocity = acb(vx0, vy0)
        z_by_z, z_by_v, v_by_z, v_by_v = self.moved(t)
        z = z_by_z * place + z_by_v * velocity
        v = v_by_z * place + v_by_v * velocity
        return {"x": z.real, "y": z.imag, "vx": v.real, "vy": v.imag}

    def by_equation(self) -> ValidatedFlow:
        """The same motion from its equation, to the same digits: z'' = -(w0^2 - i n) z - 2 b z'
        with z = x + i y.
        """

        def field(state: Sequence[Any]) -> list[Any]:
            x, y, vx, vy = state
            decay = 2 * self.decay
            # x'' = -w0^2 x - n y - 2 b x',  y'' = -w0^2 y + n x - 2 b y'.
            along = -(x * self.square) - y * self.push - vx * decay
            across = -(y * self.square) + x * self.push - vy * decay
            return [vx, vy, along, across]

        flow = ValidatedFlow(
            field,
            self.begin,
            lambda y: dict(zip(NAMES, y, strict=True)),
            self.scale,
            state=NAMES,
            moved=range(4),
        )
        return flow.refined(self.digits)

    @per_precision
    def growth(self) -> Grows:
        """How errors grow: the motion is linear, so that the time elapsed alone counts."""
        ratio = arb_of(self.scale["x"] / self.scale["vx"])
        if self.decay**4 >= 16 * (self.square**2 + self.push**2):
            return Told(lambda t: self.overdamped_growth(t, ratio))

        def propagator(elapsed: arb) -> arb_mat:
            """The matrix that maps errors of (x, y, vx, vy) in scales to those after a time [s]."""
            z_by_z, z_by_v, v_by_z, v_by_v = self.moved(elapsed)
            # In scales: z by v0 times V/X, v by z0 times X/V; `ratio` is X/V.
            return of_complex([[z_by_z, z_by_v / ratio], [v_by_z * ratio, v_by_v]])

        # |q| = |-b +- s| <= b + |s|.
        fastest = arb_of(self.decay) + abs(self.half_gap())
        return SteadyGrowth(propagator, Norm([1] * 4), narrow(fastest))

    def overdamped_growth(self, t: arb, ratio: arb) -> arb:
        """A bound of S(t) for b^2 >= 4 |w0^2 - i n|, where s is larger than b/2.

        With the roots q and r, z = (q exp(r t) - r exp(q t))/(q - r) for z0 = 1, and (exp(q t) -
        exp(r t))/(q - r) for v0 = 1; v alike. No exponential is larger than E = max(1, exp(a t)), a
        the largest real part. So the parts of the matrix are at most E (|q| + |r|)/|q - r|,
        2 E/|q - r|, 2 E |q r|/|q - r|; a complex number u is a matrix whose row sums are at most
        sqrt(2) |u|.
        """
        s = self.half_gap()
        gap = abs(2 * s)
        # The roots r = -b + s and q = -b - s, with r - q = 2 s.
        slow = acb(arb_of(-self.decay)) + s
        fast = acb(arb_of(-self.decay)) - s
        exponential = arb(1).max((self.largest_real_part() * t).exp())
        # (|q| + |r|)/|q - r| on the diagonal, 2/|q - r| for z by v0, 2 |q r|/|q - r| for v by z0.
        diagonal = (abs(slow) + abs(fast)) / gap
        place_by_velocity = 2 / (gap * ratio)
        velocity_by_place = 2 * abs(slow * fast) * ratio / gap
        off_diagonal = place_by_velocity.max(velocity_by_place)
        return arb(2).sqrt() * exponential * (diagonal + off_diagonal)

    def largest_real_part(self) -> arb:
        """The largest real part of both roots [1/s]; 0 at the border."""
        if self.is_at_border:
            return arb(0)
        if self.push == 0 and self.decay**2 == self.square:
            return arb_of(-self.decay)
        # Re(-b + s), as Re s >= 0.
        return self.half_gap().real - arb_of(self.decay)

    def constants(self) -> dict[str, arb]:
        """The growth rate [1/s], and with internal damping the rotation [rad/s] at the border."""
        constants = {"growth_rate": self.largest_real_part()}
        if self.inner_damping:
            # w0 (1 + c_e/c_i).
            constants["border"] = arb_of(self.square).sqrt() * arb_of(
                1 + self.outer_damping / self.inner_damping
            )
        return constants


def of_complex(rows: list[list[acb]]) -> arb_mat:
    """The real matrix of a complex 2 x 2 one, for the coordinates (x, y, vx, vy): a number u + i w
    becomes the block ((u, -w), (w, u)).
    """
    table = []
    for row in rows:
        upper: list[arb] = []
        lower: list[arb] = []
        for value in row:
            upper += [value.real, -value.imag]
            lower += [value.imag, value.real]
        table += [upper, lower]
    return arb_mat(table)


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters mass, stiffness, outer_damping, inner_damping, turning, x0, v0.

    `scale` of x, y, vx and vy.
    """
    names = ("mass", "stiffness", "outer_damping", "inner_damping", "turning")
    begin = (*vector(p, "x0"), *vector(p, "v0"))
    return WhirlingShaft(refiner=Refiner.of(scale), **numbers(p, *names), begin=begin)
