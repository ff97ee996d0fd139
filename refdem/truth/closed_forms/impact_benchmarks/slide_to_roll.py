"""A solid sphere that lies on the floor y = 0, its overlap that of its weight, and slides along x
until it rolls: closed form.

With d the overlap, d'' = g - N/m, the impulse of the floor per mass is I = g t - (d' - d'(0)).
Friction mu N against the slip u + R omega (omega about z, lever R) takes mu I from u and 5/2 mu I
from R omega, so that it rolls from I = 2 (u0 + R omega0)/(7 mu) on, at 5/7 u0 if it did not spin;
then nothing acts along the floor. The overlap stays, or, for the neighbouring motions of S, swings
at sqrt(k/m).
"""

from collections.abc import Iterator, Mapping
from copy import copy
from fractions import Fraction
from functools import partial
from typing import Self

from flint import arb, arb_mat

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.growth import Grows, Growth, Norm, Stretch, narrow, smooth
from refdem.truth.reals import Number
from refdem.truth.refiner import Refiner, Size

STATE = ("r.x", "r.y", "v.x", "v.y", "omega.z")
STILL = ("r.z", "v.z", "omega.x", "omega.y")


class SlideToRoll(ClosedForm):
    """Place [m], velocity [m/s] and angular velocity [rad/s] at t >= 0."""

    state = STATE
    method = "closed form: uniform deceleration, then uniform rolling"
    witness = "Taylor series of the motion under its law with all its coordinates"

    def __init__(
        self,
        scale: Mapping[str, Size],
        *,
        mass: Number,
        radius: Fraction,
        stiffness: Fraction,
        gravity: Fraction,
        friction: Fraction,
        speed: Fraction,
    ) -> None:
        self.refiner = Refiner.of(scale)
        self.radius = radius
        self.gravity = gravity
        self.friction = friction
        self.rate2 = stiffness / mass
        self.speed = speed
        self.sag = gravity / self.rate2
        self.begin = (Fraction(0), Fraction(0), speed, Fraction(0), Fraction(0))
        """x, how far the centre is above its place of rest, their rates, and the spin."""

    def displaced(self, axis: int, amount: Fraction) -> Self:
        other = copy(self)
        other.kept = {}
        other.begin = tuple(x + amount * (i == axis) for i, x in enumerate(self.begin))  # type: ignore[assignment]
        return other

    @per_precision
    def growth(self) -> Grows:
        return Growth(
            self.stretches(), Norm([1] * len(STATE)), step=narrow(arb_of(self.rate2).sqrt())
        )

    def stretches(self) -> Iterator[Stretch]:
        """Sliding, then rolling; where the slip ends, and at once for every later error, v_x loses
        2/7 of it and omega 5/7 over R.
        """
        radius = arb_of(self.radius)
        rolls = self.roll_time()
        rows = [[arb(int(i == j)) for j in range(5)] for i in range(5)]
        rows[2][2], rows[2][4] = arb_of(Fraction(5, 7)), -arb_of(Fraction(2, 7)) * radius
        rows[4][2], rows[4][4] = -arb_of(Fraction(5, 7)) / radius, arb_of(Fraction(2, 7))
        sizes = [arb_of(self.scale[name]) for name in STATE]
        held = arb_mat(
            [
                [entry * own / size for entry, own in zip(row, sizes, strict=True)]
                for row, size in zip(rows, sizes, strict=True)
            ]
        )
        yield smooth(arb(0), rolls, partial(self.errors, arb_of(self.friction)), jump=held)
        yield smooth(rolls, None, partial(self.errors, arb(0)), felt=held)

    def errors(self, friction: arb, t: arb) -> arb_mat:
        """Errors of STATE in scales by those a time t earlier, under that friction.

        The overlap swings; mu N takes from v_x what the floor gives to v_y times mu, and from omega
        5/(2 R) times as much.
        """
        rate = arb_of(self.rate2).sqrt()
        none = arb(0)
        one = arb(1)
        sine, cosine = (rate * t).sin_cos()
        rise = [cosine, sine / rate]
        speed = [-rate * sine, cosine]
        # What the vertical motion has gained since.
        risen = [cosine - 1, sine / rate - t]
        gained = [-rate * sine, cosine - 1]
        turn = friction * arb_of(Fraction(5, 2) / self.radius)
        # By the errors of x, y, v_x, v_y and omega.
        row_x = [one, -friction * risen[0], t, -friction * risen[1], none]
        row_y = [none, rise[0], none, rise[1], none]
        row_vx = [none, -friction * gained[0], one, -friction * gained[1], none]
        row_vy = [none, speed[0], none, speed[1], none]
        row_omega = [none, -turn * gained[0], none, -turn * gained[1], one]
        rows = [row_x, row_y, row_vx, row_vy, row_omega]
        sizes = [arb_of(self.scale[name]) for name in STATE]
        return arb_mat(
            [
                [entry * own / size for entry, own in zip(row, sizes, strict=True)]
                for row, size in zip(rows, sizes, strict=True)
            ]
        )

    def overlap(self, t: arb) -> tuple[arb, arb]:
        """The overlap d and its rate d' at time t."""
        rate = arb_of(self.rate2).sqrt()
        off = arb_of(-self.begin[1])
        speed = arb_of(-self.begin[3])
        wave = (rate * t).cos()
        swing = (rate * t).sin()
        return (
            arb_of(self.sag) + off * wave + speed / rate * swing,
            speed * wave - off * rate * swing,
        )

    def enough(self) -> Fraction:
        """The impulse per mass after which it rolls."""
        return Fraction(2, 7) * (self.begin[2] + self.radius * self.begin[4]) / self.friction

    def roll_time(self) -> arb:
        """When it rolls; of a neighbouring motion to first order in how far it is off."""
        first = arb_of(self.enough() / self.gravity)
        return first + (self.overlap(first)[1] + arb_of(self.begin[3])) / arb_of(self.gravity)

    def evaluate(self, t: arb) -> dict[str, arb]:
        depth, rate = self.overlap(t)
        until = t
        rolls = self.roll_time()
        if not (t <= rolls or t > rolls):
            raise UndecidedError("whether it rolls")
        if t > rolls:
            until = rolls
        swung, turned = self.overlap(until)
        x, _, u, v, spin = (arb_of(value) for value in self.begin)
        mu = arb_of(self.friction)
        radius = arb_of(self.radius)
        g = arb_of(self.gravity)
        impulse = g * until - turned - v
        sunk = swung - self.overlap(arb(0))[0]
        way = g * until * until / 2 - sunk - v * until
        speed = u - mu * impulse
        now = (
            x + u * until - mu * way + speed * (t - until),
            radius - depth,
            speed,
            -rate,
            spin - mu * impulse * 5 / (2 * radius),
        )
        return dict(zip((*STATE, *STILL), (*now, *(arb(0),) * 4), strict=True))

    def constants(self) -> dict[str, arb]:
        """roll_time [s], roll_speed [m/s]; as parts, speed_ratio = u/u0 and time_ratio = mu g
        t/u0.
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
