"""Plane orbits about a fixed centre, in Kepler's field gm/r^2 or on a central spring; they start at
periapsis on the +x axis, moving towards +y.

Kepler, from any start (r0, v0) on an ellipse (Battin, An Introduction to the Mathematics and
Methods of Astrodynamics, 1999, section 4.3), E being the change of the eccentric anomaly since the
start:

    1/a = 2/r0 - v0^2/gm,  n = sqrt(gm/a^3),  s = r0.v0/sqrt(gm a),
    n t = E - (1 - r0/a) sin E + s (1 - cos E)                       Kepler's equation
    r = f r0 + g v0,  v = f' r0 + g' v0,
    f = 1 - (a/r0)(1 - cos E),  g = t - (E - sin E)/n.

Spring, unit mass: x = a cos w t, y = a sqrt(1 - e^2) sin w t with w^2 = stiffness.

A `State` is (x, y, vx, vy) in m and m/s.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from flint import arb, arb_mat, ctx

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, displaced_tuple, per_precision
from refdem.truth.dual import ball, carried
from refdem.truth.exact import number
from refdem.truth.growth import Grows, Norm, SteadyGrowth, most, narrow
from refdem.truth.kepler_growth import CentralGrowth
from refdem.truth.refiner import GROWTH_BITS, Refiner, Sensitivity
from refdem.truth.smooth_flow import derivative_by_start

NAMES = ("x", "y", "vx", "vy")
LOST_BITS = 9
"""Bits that the proof of S loses, about, for each bit of 1/(1 - e). A working precision of 64 bits
suffices at e = 0.99 and not at 0.999.
"""
State = Sequence[arb]


@dataclass(frozen=True, kw_only=True)
class Orbit(ClosedForm):
    """The truth of an orbit: x, y [m] and vx, vy [m/s] at t; scalar period [s].

    The field is Kepler's with `gm` [m^3/s^2], or that of a spring with `stiffness` [1/s^2, unit
    mass], which is None for Kepler's. `offset` is added to the start (x, y, vx, vy), and is not 0
    for a displaced orbit.
    """

    method = "Kepler's equation by interval Newton; ellipse about the centre for the spring"
    witness = "Taylor series of the equation of motion; energy, angular momentum and Laplace vector"
    state = NAMES

    gm: Fraction
    semi_major: Fraction
    eccentricity: Fraction
    stiffness: Fraction | None
    proof_of_s: Sensitivity
    offset: tuple[Fraction, ...] = (Fraction(0),) * 4

    displaced = displaced_tuple("offset")
    jacobian = derivative_by_start

    def start(self) -> list[arb]:
        """The state at t = 0: periapsis for Kepler, the end of the long axis for the spring."""
        a = self.semi_major
        e = self.eccentricity
        if self.stiffness is None:
            # At periapsis r = a (1 - e) and v^2 = (gm/a)(1 + e)/(1 - e).
            x = a * (1 - e)
            speed_square = self.gm / a * (1 + e) / (1 - e)
        else:
            # At the end of the long axis v = w b, with b^2 = a^2 (1 - e^2).
            x = a
            speed_square = self.stiffness * a * a * (1 - e * e)
        start = (arb_of(x), arb(0), arb(0), arb_of(speed_square).sqrt())
        return [
            coordinate + arb_of(offset)
            for coordinate, offset in zip(start, self.offset, strict=True)
        ]

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The position and velocity of the orbit at time t."""
        start = self.start()
        if self.stiffness is None:
            state = kepler(arb_of(self.gm), start, t)
        else:
            state = spring(arb_of(self.stiffness), start, t)
        return dict(zip(NAMES, state, strict=True))

    @per_precision
    def growth(self) -> Grows:
        """How errors of the orbit grow, with x, y and vx, vy in their scales.

        On the spring the flow is linear and periodic, so that the growth depends on the elapsed
        time alone; on an ellipse it comes from four known errors and the gradient of the field.
        """
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

    def constants(self) -> dict[str, arb]:
        """The period 2 pi/n [s]: n^2 = gm/a^3 in Kepler's field, the stiffness on the spring."""
        if self.stiffness is None:
            inverse_square = self.semi_major**3 / self.gm
        else:
            inverse_square = 1 / self.stiffness
        return {"period": 2 * arb.pi() * arb_of(inverse_square).sqrt()}


def proof_of_s(stiffness: Fraction | None, eccentricity: Fraction) -> Sensitivity:
    """The proof of S, with the working precisions [bit] at which it is tried, in rising order.

    On an elongated ellipse errors grow as a power of 1/(1 - e) at periapsis and decrease again
    afterwards. Precisions at which no significant bits would remain are left out.
    """
    if stiffness is not None:
        return Sensitivity()
    bits_of_elongation = (1 / (1 - eccentricity)).__ceil__().bit_length()
    least = LOST_BITS * (bits_of_elongation - 1)
    return Sensitivity([bits for bits in GROWTH_BITS if bits >= least])


def spring(stiffness: arb, start: State, t: arb) -> list[arb]:
    """The state (x, y, vx, vy) at time t on the central spring of this stiffness [1/s^2].

    With w = sqrt(stiffness), for each of x and y: r = r0 cos w t + (v0/w) sin w t, v = v0 cos w t -
    r0 w sin w t.
    """
    # r = r0 cos w t + (v0/w) sin w t,  v = v0 cos w t - r0 w sin w t
    rate = stiffness.sqrt()
    sine, cosine = (rate * t).sin_cos()
    position = [start[i] * cosine + start[i + 2] / rate * sine for i in (0, 1)]
    velocity = [start[i + 2] * cosine - start[i] * rate * sine for i in (0, 1)]
    return position + velocity


def kepler(gm: arb, start: State, t: arb) -> list[arb]:
    """The state (x, y, vx, vy) at time t in Kepler's field, from any start on an ellipse.

    The equations are those at the top of this file, with r = a + (r0 - a) cos E + s a sin E, f' =
    -n a^2 sin E/(r r0) and g' = 1 - (a/r)(1 - cos E). Raises UndecidedError where the start is not
    proved to lie on an ellipse.
    """
    # 1/a = 2/r0 - v0^2/gm,  n = sqrt(gm/a^3),  s = r0.v0/sqrt(gm a)
    x, y, vx, vy = start
    r0 = (x * x + y * y).sqrt()
    a = 1 / (2 / r0 - (vx * vx + vy * vy) / gm)
    n = (gm / a).sqrt() / a
    s = (x * vx + y * vy) / (gm * a).sqrt()
    # E - (1 - r0/a) sin E + s (1 - cos E) = n t
    anomaly = anomaly_gain(n * t, 1 - r0 / a, s)
    sine, cosine = anomaly.sin_cos()
    # f = 1 - (a/r0)(1 - cos E),  g = t - (E - sin E)/n
    # f' = -n a^2 sin E/(r r0),   g' = 1 - (a/r)(1 - cos E)
    r = a + (r0 - a) * cosine + s * a * sine
    f = 1 - a / r0 * (1 - cosine)
    g = t - (anomaly - sine) / n
    f_rate = -n * a * a / (r * r0) * sine
    g_rate = 1 - a / r * (1 - cosine)
    return [f * x + g * vx, f * y + g * vy, f_rate * x + g_rate * vx, f_rate * y + g_rate * vy]


def sprung(stiffness: arb, ratio: arb, elapsed: arb) -> arb_mat:
    """The matrix (4 x 4) that maps errors of (x, y, vx, vy) to those after `elapsed` [s].

    It is that of `spring`, which is linear, with lengths and speeds in scales whose ratio X/V is
    `ratio` [s]: w becomes w X/V, without a unit.
    """
    scaled_rate = stiffness.sqrt() * ratio
    # r -> r cos + (v/(w X/V)) sin,  v -> v cos - (w X/V) r sin, in units of the scales X and V
    sine, cosine = (stiffness.sqrt() * elapsed).sin_cos()
    zero = arb(0)
    return arb_mat(
        [
            [cosine, zero, sine / scaled_rate, zero],
            [zero, cosine, zero, sine / scaled_rate],
            [-scaled_rate * sine, zero, cosine, zero],
            [zero, -scaled_rate * sine, zero, cosine],
        ]
    )


def ellipses(gm: arb, a: arb, e: arb, length: arb, speed: arb, t: arb) -> arb_mat:
    """The matrix (4 x 4) whose columns are four independent errors of a Kepler orbit at time t.

    An error is a difference of (x, y, vx, vy), in the scales `length` [m] and `speed` [m/s], from
    the orbit that passed periapsis on +x at time 0; t >= 0 [s]. Each column is the derivative of
    the orbit by one parameter and so solves the variational equation:

    * `shift`: by the time of periapsis, (v, acceleration);
    * `scale`: a d/da. The orbit is a R(n t) with n ~ a^(-3/2), so that it is (r, -v/2) - (3/2) t
      (v, acceleration);
    * `wider`: by the eccentricity, at fixed a and time;
    * `turn`: by the direction of periapsis, (-y, x, -vy, vx), less shift/n, over e. For e = 0 turn
      and shift/n are the same: their difference over e is regular for all 0 <= e < 1.

    With c = cos E, s = sin E, d = 1 - e c, b = sqrt(1 - e^2), n = sqrt(gm/a^3), the orbit is

        x = a (c - e),  y = a b s,  vx = -a n s/d,  vy = a n b c/d,    E - e s = n t.
    """
    n = (gm / a).sqrt() / a
    b = (1 - e * e).sqrt()
    s, c = anomaly_gain(n * t, e, arb(0)).sin_cos()
    d = 1 - e * c
    d_cubed = d * d * d
    x = a * (c - e)
    y = a * b * s
    vx = -a * n * s / d
    vy = a * n * b * c / d
    # The acceleration is -gm r/|r|^3 with |r| = a d and gm = n^2 a^3.
    shift = [vx, vy, -n * n * a * (c - e) / d_cubed, -n * n * a * b * s / d_cubed]
    scale = [
        value - 3 * t * rate / 2
        for value, rate in zip([x, y, -vx / 2, -vy / 2], shift, strict=True)
    ]
    # At fixed time dE/de = s/d, db/de = -e/b and dd/de = e s dE/de - c. So
    #     dx/de = -a (s dE/de + 1),    dvx/de = -a n (c dE/de/d - s dd/de/d^2),
    #     dy/de = a (db/de s + b c dE/de),
    #     dvy/de = a n (db/de c/d - b s dE/de/d - b c dd/de/d^2).
    e_slope = s / d
    d_slope = e * s * e_slope - c
    wider_x = -a * s * e_slope - a
    wider_y = -a * e / b * s + a * b * c * e_slope
    wider_vx = -a * n * (c * e_slope / d - s * d_slope / (d * d))
    wider_vy = a * n * (-e / b * c / d - b * s * e_slope / d - b * c * d_slope / (d * d))
    wider = [wider_x, wider_y, wider_vx, wider_vy]
    # turn = (-y - vx/n, x - vy/n, -vy - ax/n, vx - ay/n)/e with x, y, vx, vy, ax, ay in c, s and d.
    # All terms have a factor e, which is divided out; (1 - b)/e is computed as e/(1 + b).
    one_less_b = e / (1 + b)
    turn_x = a * s * (one_less_b + b * c) / d
    turn_y = a * ((one_less_b + e) * c - 1 - c * c) / d
    turn_vx = a * n * (one_less_b * c - 1 + 2 * b * c * c - b * e * c * c * c) / d_cubed
    turn_vy = a * n * s * (-one_less_b + 2 * c - e * c * c) / d_cubed
    turn = [turn_x, turn_y, turn_vx, turn_vy]
    rows = zip((length, length, speed, speed), shift, scale, wider, turn, strict=True)
    return arb_mat([[entry / size for entry in row] for size, *row in rows])


def tidal(gm: arb, a: arb, e: arb, t: arb) -> float:
    """A bound [1/s^2] of the norm of the gradient of Kepler's field over a ball of times t [s].

    The gradient of -gm r/|r|^3 has the entries gm (3 r_i r_j - delta_ij r^2)/r^5; the norm is the
    largest sum of the absolute values in a row. E rises with time, so that E over the ball of times
    since periapsis lies between those at its ends.
    """
    n = (gm / a).sqrt() / a
    first, last = (anomaly_gain(n * arb(end), e, arb(0)) for end in (t.lower(), t.upper()))
    s, c = first.union(last).sin_cos()
    x = a * (c - e)
    y = a * (1 - e * e).sqrt() * s
    r = a * (1 - e * c)
    off_diagonal = abs(3 * x * y)
    row_sums = [abs(3 * z * z - r * r) + off_diagonal for z in (x, y)]
    factor = gm / r**5
    return most([factor * row_sum for row_sum in row_sums])


def anomaly_gain(mean: arb, c: arb, s: arb) -> arb:
    """The root E of Kepler's equation F(E) = E - c sin E + s (1 - cos E) = mean, c^2 + s^2 < 1.

    Where mean, c and s carry derivatives, so does the root.
    """
    anomaly = proved_root(ball(mean), ball(c), ball(s))
    sine, cosine = anomaly.sin_cos()
    slope = _slope(anomaly, ball(c), ball(s))
    # F(E) = mean gives F' dE = d mean + sin E dc - (1 - cos E) ds.
    return carried(anomaly, (1 / slope, mean), (sine / slope, c), ((cosine - 1) / slope, s))


def proved_root(mean: arb, c: arb, s: arb) -> arb:
    """The root E of Kepler's equation as a ball.

    Theorem (interval Newton): let X be a ball, E0 a point in it and N = E0 - (F(E0) - mean)/F'(X).
    If N lies inside X, then X holds exactly one root, and so does N. Here F' = r/a > 0 everywhere,
    so that there is no other root. E0 is an approximation by Newton's method, which needs no proof.
    Raises UndecidedError if the orbit is not proved to be an ellipse,
    or N does not lie inside X.
    """
    # c^2 + s^2 is compared, not its square root: on a circle its ball contains negative numbers.
    if not c * c + s * s < 1:
        raise UndecidedError("the orbit is not proved to be an ellipse")
    point = _newton(mean.mid(), c.mid(), s.mid())
    residual = point - c * point.sin() + s * (1 - point.cos()) - mean
    # X: four times the length of a Newton step, and a little more where that is 0.
    radius = 4 * abs(residual / _slope(point, c, s)).upper() + arb(2) ** (8 - ctx.prec)
    interval = point + arb(0, radius)
    image = point - residual / _slope(interval, c, s)
    if not interval.contains_interior(image):
        raise UndecidedError("Kepler's equation is not solved at this precision")
    return image


def _slope(anomaly: arb, c: arb, s: arb) -> arb:
    """F'(E) = 1 - c cos E + s sin E, which is r/a."""
    return 1 - c * anomaly.cos() + s * anomaly.sin()


def _newton(mean: arb, c: arb, s: arb) -> arb:
    """An approximate root of Kepler's equation, not proved.

    |E - mean| = |c sin E - s (1 - cos E)| <= sqrt(2 - 2 cos E) <= 2, because c^2 + s^2 < 1. Twelve
    bisections reduce this interval to a thousandth, from where Newton's method converges. It ends
    when a step no longer changes the value.
    """
    low = mean - 2
    high = mean + 2
    for _ in range(12):
        middle = ((low + high) / 2).mid()
        is_below = (middle - c * middle.sin() + s * (1 - middle.cos())).mid() < mean
        if is_below:
            low = middle
        else:
            high = middle
    root = ((low + high) / 2).mid()
    for _ in range(24):
        residual = root - c * root.sin() + s * (1 - root.cos()) - mean
        improved = (root - residual / _slope(root, c, s)).mid()
        if improved == root:
            break
        root = improved
    return root


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters gm [m^3/s^2], semi_major [m], eccentricity, stiffness [1/s^2].

    `stiffness` is None for Kepler's field. `scale` has the sizes of x, y, vx, vy against which
    their errors count.
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
    refiner = Refiner.of(scale)
    return Orbit(
        refiner=refiner,
        gm=gm,
        semi_major=a,
        eccentricity=e,
        stiffness=stiffness,
        proof_of_s=proof_of_s(stiffness, e),
    )
