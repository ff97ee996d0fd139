"""Plane orbits about a fixed centre: Kepler's field gm/r^2 and the central spring, from periapsis
on +x moving in +y.

Kepler, from any start (r0, v0) on an ellipse, with 1/a = 2/r0 - v0^2/gm, n = sqrt(gm/a^3), s =
r0.v0/sqrt(gm a), E the gain in eccentric anomaly: n t = E - (1 - r0/a) sin E + s (1 - cos E), and r
= f r0 + g v0, v = f' r0 + g' v0 with f = 1 - (a/r0)(1 - cos E), g = t - (E - sin E)/n (Battin, An
Introduction to the Mathematics and Methods of Astrodynamics, 1999, section 4.3). Spring, unit mass:
x = a cos w t, y = a sqrt(1 - e^2) sin w t with w^2 = stiffness.
"""

from collections.abc import Mapping, Sequence
from copy import copy
from fractions import Fraction
from functools import partial

from flint import arb, arb_mat, ctx

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.exact import number
from refdem.truth.growth import Grows, Norm, SteadyGrowth, most, narrow
from refdem.truth.kepler_growth import CentralGrowth
from refdem.truth.refiner import GROWTH_BITS, Refiner, Sensitivity
from refdem.truth.smooth_flow import SmoothFlow

NAMES = ("x", "y", "vx", "vy")
LOSSES = 9
"""Bits that S of a comet loses for each bit of 1/(1 - e), about: at e = 0.99 64 bits suffice, at
0.999 they do not.
"""
State = Sequence[arb]


class Orbit(ClosedForm, SmoothFlow):
    """x, y [m] and vx, vy [m/s] at t; scalar period [s].

    `stiffness` [1/s^2, unit mass] is None for Kepler's field.
    """

    method = "Kepler's equation by interval Newton; ellipse about the centre for the spring"
    witness = "Taylor series of the equation of motion; energy, angular momentum and Laplace vector"
    state = NAMES

    def __init__(
        self,
        scale: Mapping[str, float],
        *,
        gm: Fraction,
        semi_major: Fraction,
        eccentricity: Fraction,
        stiffness: Fraction | None,
    ) -> None:
        self.refiner = Refiner.of(scale)
        self.gm = gm
        self.semi_major = semi_major
        self.eccentricity = eccentricity
        self.stiffness = stiffness
        self.proof_of_s = Sensitivity(self.growth_bits())
        self.offset = [Fraction(0)] * 4

    def displaced(self, axis: int, amount: Fraction) -> "Orbit":
        """The orbit from a neighbouring start."""
        other = copy(self)
        other.kept = {}
        other.offset = [x + amount * (i == axis) for i, x in enumerate(self.offset)]
        return other

    def start(self) -> list[arb]:
        """The state at t = 0: periapsis for Kepler, the end of the long axis for the spring."""
        a = self.semi_major
        e = self.eccentricity
        if self.stiffness is None:
            # v^2 = gm/a (1 + e)/(1 - e) at r = a (1 - e).
            apsis = a * (1 - e)
            square = self.gm / a * (1 + e) / (1 - e)
        else:
            # v = w b at the end of the long axis.
            apsis = a
            square = self.stiffness * a * a * (1 - e * e)
        start = (arb_of(apsis), arb(0), arb(0), arb_of(square).sqrt())
        return [part + arb_of(off) for part, off in zip(start, self.offset, strict=True)]

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The position and velocity of the orbit at time t."""
        start = self.start()
        if self.stiffness is None:
            now = kepler(arb_of(self.gm), start, t)
        else:
            now = spring(arb_of(self.stiffness), start, t)
        return dict(zip(NAMES, now, strict=True))

    @per_precision
    def growth(self) -> Grows:
        period = self.constants()["period"]
        step = narrow(2 * arb.pi() / period)
        length = self.scale["x"]
        speed = self.scale["vx"]
        if self.stiffness is not None:
            return SteadyGrowth(
                partial(sprung, arb_of(self.stiffness), arb_of(length / speed)),
                Norm([1] * 4),
                step,
                period,
            )
        ellipse = arb_of(self.gm), arb_of(self.semi_major), arb_of(self.eccentricity)
        return CentralGrowth(
            partial(ellipses, *ellipse, arb_of(length), arb_of(speed)),
            partial(tidal, *ellipse),
            period,
            float(length / speed),
        )

    def growth_bits(self) -> Sequence[int]:
        """Working precisions for S: a comet's errors grow as a power of 1/(1 - e) and shrink again,
        and precisions that would lose them are left out.
        """
        if self.stiffness is not None:
            return GROWTH_BITS
        digits = (1 / (1 - self.eccentricity)).__ceil__().bit_length()
        return [bits for bits in GROWTH_BITS if bits >= LOSSES * (digits - 1)]

    def constants(self) -> dict[str, arb]:
        """The scalar constants of the motion: the period [s]."""
        if self.stiffness is None:
            squared = self.semi_major**3 / self.gm
        else:
            squared = 1 / self.stiffness
        return {"period": 2 * arb.pi() * arb_of(squared).sqrt()}


def spring(stiffness: arb, start: State, t: arb) -> list[arb]:
    """(x, y, vx, vy) at t on the central spring."""
    rate = stiffness.sqrt()
    sine, cosine = (rate * t).sin_cos()
    places = [start[i] * cosine + start[i + 2] / rate * sine for i in (0, 1)]
    return places + [start[i + 2] * cosine - start[i] * rate * sine for i in (0, 1)]


def kepler(gm: arb, start: State, t: arb) -> list[arb]:
    """(x, y, vx, vy) at t in Kepler's field, from any state on an ellipse."""
    x, y, vx, vy = start
    r0 = (x * x + y * y).sqrt()
    a = 1 / (2 / r0 - (vx * vx + vy * vy) / gm)
    n = (gm / a).sqrt() / a
    s = (x * vx + y * vy) / (gm * a).sqrt()
    anomaly = anomaly_gain(n * t, 1 - r0 / a, s)
    sine, cosine = anomaly.sin_cos()
    r = a + (r0 - a) * cosine + s * a * sine
    # r = f r0 + g v0 and v = f' r0 + g' v0.
    f = 1 - a / r0 * (1 - cosine)
    g = t - (anomaly - sine) / n
    f_rate = -n * a * a / (r * r0) * sine
    g_rate = 1 - a / r * (1 - cosine)
    return [f * x + g * vx, f * y + g * vy, f_rate * x + g_rate * vx, f_rate * y + g_rate * vy]


def sprung(stiffness: arb, ratio: arb, elapsed: arb) -> arb_mat:
    """What errors of (x, y, vx, vy) on the central spring become, in scales whose ratio is `ratio`
    [s].
    """
    turn = stiffness.sqrt() * ratio
    sine, cosine = (stiffness.sqrt() * elapsed).sin_cos()
    none = arb(0)
    return arb_mat(
        [
            [cosine, none, sine / turn, none],
            [none, cosine, none, sine / turn],
            [-turn * sine, none, cosine, none],
            [none, -turn * sine, none, cosine],
        ]
    )


def ellipses(gm: arb, a: arb, e: arb, length: arb, speed: arb, t: arb) -> arb_mat:
    """Four independent errors of (x, y, vx, vy), in scales, on Kepler's ellipse at a time t >= 0
    since periapsis: columns.

    They come from a shift in time, from the scale of the ellipse, from its eccentricity, and from a
    turn less the shift that is nearly the same, over e: regular for all 0 <= e < 1. With c, s = cos
    E, sin E, d = 1 - e c, b = sqrt(1 - e^2), n = sqrt(gm/a^3).
    """
    n = (gm / a).sqrt() / a
    b = (1 - e * e).sqrt()
    s, c = anomaly_gain(n * t, e, arb(0)).sin_cos()
    d = 1 - e * c
    cube = d * d * d
    x = a * (c - e)
    y = a * b * s
    vx = -a * n * s / d
    vy = a * n * b * c / d
    shift = [vx, vy, -n * n * a * (c - e) / cube, -n * n * a * b * s / cube]
    scale = [
        value - 3 * t * rate / 2
        for value, rate in zip([x, y, -vx / 2, -vy / 2], shift, strict=True)
    ]
    # By e at fixed a and time: E moves by sin E / d.
    later = s / d
    stretched = e * s * later - c
    wider_x = -a * s * later - a
    wider_y = -a * e / b * s + a * b * c * later
    wider_vx = -a * n * (c * later / d - s * stretched / (d * d))
    wider_vy = a * n * (-e / b * c / d - b * s * later / d - b * c * stretched / (d * d))
    wider = [wider_x, wider_y, wider_vx, wider_vy]
    # (-y - vx/n, x - vy/n, -vy - ax/n, vx - ay/n) / e, with 1 - b = e^2/(1 + b) taken out.
    small = e / (1 + b)
    turn_x = a * s * (small + b * c) / d
    turn_y = a * ((small + e) * c - 1 - c * c) / d
    turn_vx = a * n * (small * c - 1 + 2 * b * c * c - b * e * c * c * c) / cube
    turn_vy = a * n * s * (-small + 2 * c - e * c * c) / cube
    turn = [turn_x, turn_y, turn_vx, turn_vy]
    rows = zip((length, length, speed, speed), shift, scale, wider, turn, strict=True)
    return arb_mat([[entry / size for entry in row] for size, *row in rows])


def tidal(gm: arb, a: arb, e: arb, t: arb) -> float:
    """Bound [1/s^2] of the largest sum of a row of the gradient of -gm r/|r|^3 on a ball of times
    since periapsis: in its row i gm (3 r_i r_j - delta_ij r^2)/r^5.
    """
    n = (gm / a).sqrt() / a
    first, last = (anomaly_gain(n * arb(end), e, arb(0)) for end in (t.lower(), t.upper()))
    s, c = first.union(last).sin_cos()
    x = a * (c - e)
    y = a * (1 - e * e).sqrt() * s
    r = a * (1 - e * c)
    across = abs(3 * x * y)
    rows = [abs(3 * z * z - r * r) + across for z in (x, y)]
    strength = gm / r**5
    return most([strength * row for row in rows])


def anomaly_gain(mean: arb, c: arb, s: arb) -> arb:
    """E with E - c sin E + s (1 - cos E) = mean, where c^2 + s^2 < 1; UndecidedError if the proof
    fails.

    Newton's method in floating point finds it. Then the interval Newton operator maps a ball into
    its inside, which proves that the ball holds a root; it is the only one, since the left side
    rises everywhere (its rate r/a is positive).
    """
    if not c * c + s * s < 1:  # not by its root: on a circle the ball of the sum reaches below 0
        raise UndecidedError("the orbit is not proved to be an ellipse")
    found = _newton(mean.mid(), c.mid(), s.mid())
    residual = found - c * found.sin() + s * (1 - found.cos()) - mean
    near = found + arb(
        0, 4 * abs(residual / _slope(found, c, s)).upper() + arb(2) ** (8 - ctx.prec)
    )
    inside = found - residual / _slope(near, c, s)
    if not near.contains_interior(inside):
        raise UndecidedError("Kepler's equation is not solved at this precision")
    return inside


def _slope(anomaly: arb, c: arb, s: arb) -> arb:
    return 1 - c * anomaly.cos() + s * anomaly.sin()


def _newton(mean: arb, c: arb, s: arb) -> arb:
    """An approximate root, not proved: bisection to a thousandth (|E - mean| <= 2), then Newton's
    method.
    """
    low = mean - 2
    high = mean + 2
    for _ in range(12):
        middle = ((low + high) / 2).mid()
        below = (middle - c * middle.sin() + s * (1 - middle.cos())).mid() < mean
        low, high = (middle, high) if below else (low, middle)
    found = ((low + high) / 2).mid()
    for _ in range(24):
        step = (found - c * found.sin() + s * (1 - found.cos()) - mean) / _slope(found, c, s)
        better = (found - step).mid()
        if better == found:
            break
        found = better
    return found


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters gm, semi_major, eccentricity, stiffness (None for Kepler).

    `scale` of x, y, vx, vy.
    """
    if p["stiffness"] is None:
        stiffness = None
    else:
        stiffness = number(p, "stiffness")
    if stiffness is not None:
        gm = Fraction(1)
    else:
        gm = number(p, "gm")
    a = number(p, "semi_major")
    e = number(p, "eccentricity")
    return Orbit(scale, gm=gm, semi_major=a, eccentricity=e, stiffness=stiffness)
