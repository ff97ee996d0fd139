"""A solid sphere that lies on the floor y = 0, its overlap that of its weight, and slides along x
until it rolls: closed form.

With d the overlap and N the normal force, d'' = g - N/m, so that the impulse of the floor per mass
is I = g t - (d' - d'(0)). Friction mu N against the slip u + R omega (u = v_x, omega about z, lever
R) takes mu I from u and 5/2 mu I from R omega:

    u = u0 - mu I,    R omega = R omega0 - 5/2 mu I.

So it rolls from I = 2 (u0 + R omega0)/(7 mu) on, at 5/7 u0 if it did not spin; then nothing acts
along the floor. The overlap stays m g/k, or, for the neighbouring motions of S, swings about that
at sqrt(k/m).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from flint import arb, arb_mat

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, displaced_tuple, per_precision
from refdem.truth.growth import Grows, Growth, Norm, Stretch, between_scales, narrow, smooth
from refdem.truth.reals import Number

STATE = ("r.x", "r.y", "v.x", "v.y", "omega.z")
STILL = ("r.z", "v.z", "omega.x", "omega.y")


@dataclass(frozen=True, kw_only=True)
class SlideToRoll(ClosedForm):
    """The truth of the slide: position [m], velocity [m/s], angular velocity [rad/s] at t >= 0.

    `begin` has x, the height of the centre above its place of rest, their rates, and the spin at
    t = 0; `speed` is that of x which is meant, of which neighbouring starts differ.
    """

    state = STATE
    method = "closed form: uniform deceleration, then uniform rolling"
    witness = "Taylor series of the motion under its law with all its coordinates"

    mass: Number
    radius: Fraction
    stiffness: Fraction
    gravity: Fraction
    friction: Fraction
    speed: Fraction
    begin: tuple[Fraction, ...]

    displaced = displaced_tuple("begin")

    @property
    def rate2(self) -> Number:
        """The stiffness per mass, k/m [1/s^2]."""
        return self.stiffness / self.mass

    @property
    def sag(self) -> Number:
        """The overlap m g/k [m] at rest."""
        return self.gravity / self.rate2

    @per_precision
    def growth(self) -> Grows:
        """How errors of STATE grow, from the stretches below."""
        rate = arb_of(self.rate2).sqrt()
        return Growth(self.stretches(), Norm([1] * len(STATE)), step=narrow(rate))

    def stretches(self) -> Iterator[Stretch]:
        """Sliding, then rolling, along which errors grow smoothly.

        Where the slip v_x + R omega ends, and at once for every later error, v_x loses 2/7 of it
        and omega 5/7 of it over R.
        """
        radius = arb_of(self.radius)
        roll_time = self.roll_time()
        held = [[arb(int(i == j)) for j in range(5)] for i in range(5)]
        held[2][2] = arb_of(Fraction(5, 7))
        held[2][4] = -arb_of(Fraction(2, 7)) * radius
        held[4][2] = -arb_of(Fraction(5, 7)) / radius
        held[4][4] = arb_of(Fraction(2, 7))
        jump = self.scaled(held)
        yield smooth(arb(0), roll_time, partial(self.errors, arb_of(self.friction)), jump=jump)
        yield smooth(roll_time, None, partial(self.errors, arb(0)), instant_map=jump)

    def scaled(self, rows: list[list[arb]]) -> arb_mat:
        """The matrix between errors of STATE, given as rows, between errors in scales."""
        return between_scales(rows, [arb_of(self.scale[name]) for name in STATE])

    def errors(self, friction: arb, t: arb) -> arb_mat:
        """The matrix (5 x 5, in scales) that maps errors of STATE to those a time t [s] later.

        The height y swings with w = sqrt(k/m). Friction mu N takes from v_x mu times what the
        floor gives to v_y, and from omega 5/(2 R) times as much: -mu (v_y - v_y(0)), and its
        integral -mu (y - y(0) - v_y(0) t) from x.
        """
        w = arb_of(self.rate2).sqrt()
        zero = arb(0)
        one = arb(1)
        sine, cosine = (w * t).sin_cos()
        # y and v_y by the errors of y and v_y, and what they have gained.
        y_by = [cosine, sine / w]
        vy_by = [-w * sine, cosine]
        y_gain = [cosine - 1, sine / w - t]
        vy_gain = [-w * sine, cosine - 1]
        turn = friction * arb_of(Fraction(5, 2) / self.radius)
        # Columns: the errors of x, y, v_x, v_y and omega.
        row_x = [one, -friction * y_gain[0], t, -friction * y_gain[1], zero]
        row_y = [zero, y_by[0], zero, y_by[1], zero]
        row_vx = [zero, -friction * vy_gain[0], one, -friction * vy_gain[1], zero]
        row_vy = [zero, vy_by[0], zero, vy_by[1], zero]
        row_omega = [zero, -turn * vy_gain[0], zero, -turn * vy_gain[1], one]
        return self.scaled([row_x, row_y, row_vx, row_vy, row_omega])

    def overlap(self, t: arb) -> tuple[arb, arb]:
        """The overlap d = m g/k + a cos w t + (b/w) sin w t and its rate at time t, w^2 = k/m.

        a and b are the displacement from rest at the start, downwards, and its rate.
        """
        w = arb_of(self.rate2).sqrt()
        a = arb_of(-self.begin[1])
        b = arb_of(-self.begin[3])
        cosine = (w * t).cos()
        sine = (w * t).sin()
        overlap = arb_of(self.sag) + a * cosine + b / w * sine
        rate = b * cosine - a * w * sine
        return overlap, rate

    def rolling_impulse(self) -> Fraction:
        """The impulse per mass after which it rolls, 2 (u0 + R omega0)/(7 mu) [m/s]."""
        slip: Fraction = self.begin[2] + self.radius * self.begin[4]
        return Fraction(2, 7) * slip / self.friction

    def roll_time(self) -> arb:
        """The time [s] at which it rolls, where g t - (d' - d'(0)) is the rolling impulse.

        Exact where the overlap stays; for a neighbouring motion one step of t = (impulse + d'(t) -
        d'(0))/g, which is right to first order in its displacement.
        """
        first = arb_of(self.rolling_impulse() / self.gravity)
        return first + (self.overlap(first)[1] + arb_of(self.begin[3])) / arb_of(self.gravity)

    def evaluate(self, t: arb) -> dict[str, arb]:
        """STATE at time t, and zeros for the other components.

        Until it rolls u = u0 - mu I and x = x0 + u0 t - mu (integral of I), with I = g t - (d' -
        d'(0)); then the speed remains constant.
        """
        overlap, overlap_rate = self.overlap(t)
        roll_time = self.roll_time()
        if not (t <= roll_time or t > roll_time):
            raise UndecidedError("whether it rolls")
        if t > roll_time:
            sliding_time = roll_time
        else:
            sliding_time = t
        last_overlap, last_rate = self.overlap(sliding_time)
        x, _, u, v, spin = (arb_of(value) for value in self.begin)
        mu = arb_of(self.friction)
        radius = arb_of(self.radius)
        g = arb_of(self.gravity)
        # v is -d'(0).
        impulse = g * sliding_time - last_rate - v
        overlap_gain = last_overlap - self.overlap(arb(0))[0]
        impulse_integral = g * sliding_time * sliding_time / 2 - overlap_gain - v * sliding_time
        speed = u - mu * impulse
        position = x + u * sliding_time - mu * impulse_integral + speed * (t - sliding_time)
        omega = spin - mu * impulse * 5 / (2 * radius)
        state = (position, radius - overlap, speed, -overlap_rate, omega)
        return dict(zip((*STATE, *STILL), (*state, *(arb(0),) * 4), strict=True))

    def constants(self) -> dict[str, arb]:
        """The scalars: roll_time t [s], roll_speed u [m/s], and without units speed_ratio = u/u0
        and time_ratio = mu g t/u0.
        """
        time = self.roll_time()
        speed = self.evaluate(time * 2)["v.x"]
        ratio = arb_of(self.friction * self.gravity / self.speed)
        return {
            "roll_time": time,
            "roll_speed": speed,
            "speed_ratio": speed / arb_of(self.speed),
            "time_ratio": time * ratio,
        }
