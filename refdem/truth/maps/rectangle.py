"""The rectangular billiard by unfolding: mirrored tables tile the plane, the path is a straight
line, bounces are its crossings.

With start and direction exact, times of crossings are rational: which wall comes n-th, and whether
a corner is met, is decided in whole numbers. The direction is a unit vector, so that a root is
taken once.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import gcd

from flint import arb, arb_mat

from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import Guarded, arb_of, ball_of, refined
from refdem.truth.growth import bounded, most
from refdem.truth.maps.iterated import whole
from refdem.truth.refiner import Size

HALF = Fraction(1, 2)
Exact2 = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Crossings:
    """Times first, first + every, first + 2 every, ... at which one coordinate meets its walls;
    every = None if it never does.
    """

    first: Fraction
    every: Fraction | None

    def count(self, t: Fraction) -> int:
        """How many are at or before t."""
        if self.every is None or t < self.first:
            return 0
        return int((t - self.first) // self.every) + 1

    def time(self, number: int) -> Fraction:
        """The time of one of them, counted from 1."""
        assert self.every is not None
        return self.first + (number - 1) * self.every


def crossings(start: Fraction, rate: Fraction, size: Fraction) -> Crossings:
    """The crossings of start + rate t with the walls at (k + 1/2) size."""
    if rate == 0:
        return Crossings(Fraction(0), None)
    if rate > 0:
        ahead = size / 2 - start
    else:
        ahead = size / 2 + start
    return Crossings(ahead / abs(rate), size / abs(rate))


def corner(a: Crossings, b: Crossings) -> Fraction | None:
    """The first time at which both cross: a.first + i a.every = b.first + j b.every has whole i, j
    >= 0; None if never.
    """
    if a.every is None or b.every is None:
        return None
    ratio = b.every / a.every
    gap = (b.first - a.first) / a.every
    p, q = ratio.numerator, ratio.denominator  # i = gap + j p/q: q gap + j p must be divisible by q
    shift = gap * q
    if shift.denominator != 1 or gcd(p, q) != 1:
        return None
    if q > 1:
        j = -int(shift) * pow(p, -1, q) % q
    else:
        j = 0
    i = (int(shift) + j * p) // q
    if i < 0:
        more = -(i // p)
        i = i + more * p
        j = j + more * q
    return a.time(i + 1)


class Rectangle(Guarded, Truth):
    """Bounce n of a point from `start` along `direction` (any length) in a table of that size,
    centred on the origin.
    """

    method = "unfolding: crossings of a straight line with mirrored walls, in exact rationals"
    witness = "the same path bounce by bounce, in exact rationals"
    state = ("position.x", "position.y", "direction.x", "direction.y")

    def __init__(
        self,
        size: Exact2,
        start: Exact2,
        direction: Exact2,
        scale: Mapping[str, Size],
        *,
        digits: int = 40,
    ) -> None:
        self.size = size
        self.start = start
        self.direction = direction
        self.digits = digits
        self.scale = {name: Fraction(value) for name, value in scale.items()}
        self.walls = tuple(crossings(*one) for one in zip(start, direction, size, strict=True))
        self.corner = corner(*self.walls)

    def refined(self, digits: int) -> "Rectangle":
        """The same truth with radii of at most 10^-digits."""
        return Rectangle(self.size, self.start, self.direction, self.scale, digits=digits)

    def bounce(self, n: int) -> tuple[Fraction, int]:
        """Time of bounce n (in units of 1/|direction|) and its wall's axis.

        NotCertifiedError at a corner and after it.
        """
        time, axis = self._merged(n)
        if self.corner is not None and time >= self.corner:
            last = sum(wall.count(self.corner) for wall in self.walls) - 2
            state = {name: ball_of(value) for name, value in self.values(last).items()}
            told = ", ".join(f"{name} = {float(ball.mid):.17g}" for name, ball in state.items())
            message = (
                f"corner: certified up to bounce {last}, where {told}; bounce {last + 1} meets a"
                " corner"
            )
            raise NotCertifiedError(message, code="corner", time=float(last), state=state)
        return time, axis

    def _merged(self, n: int) -> tuple[Fraction, int]:
        """The n-th of the crossings of both coordinates in order of time."""
        for axis, (own, other) in enumerate((self.walls, self.walls[::-1])):
            if own.every is None:
                continue
            low = 0
            high = n
            while (
                low < high
            ):  # the largest number of its own crossings that come with at most n of both
                middle = (low + high + 1) // 2
                low, high = (
                    (middle, high)
                    if middle + other.count(own.time(middle)) <= n
                    else (low, middle - 1)
                )
            if low and low + other.count(own.time(low)) == n:
                return own.time(low), axis
        assert self.corner is not None  # two crossings at one time, of which this is the first
        return self.corner, 0

    def values(self, n: int) -> dict[str, arb]:
        """Place and direction after bounce n at the current precision."""
        if n:
            time = self.bounce(n)[0]
        else:
            time = Fraction(0)
        length = arb_of(self.direction[0] ** 2 + self.direction[1] ** 2).sqrt()
        found = {}
        for name, x, rate, size, wall in zip(
            "xy", self.start, self.direction, self.size, self.walls, strict=True
        ):
            if n:
                count = wall.count(time)
            else:
                count = 0
            if rate > 0:
                sign = 1
            else:
                sign = -1
            place = x + rate * time - sign * count * size
            found[f"position.{name}"] = arb_of(place if count % 2 == 0 else -place)
            found[f"direction.{name}"] = arb_of(rate if count % 2 == 0 else -rate) / length
        return {name: found[name] for name in self.state}

    def at(self, t: Fraction) -> Mapping[str, Ball]:
        """Place and direction after bounce t, a whole number."""
        n = whole(t)
        target = min(Fraction(1), *self.scale.values()) / 10**self.digits
        balls = refined(lambda: self.values(n), target)
        assert balls is not None
        return balls

    def jacobian(self, t: Fraction) -> arb_mat:
        """The derivative of bounce t by the start, in scales: a flight of that length, cut off by
        the last wall.
        """
        n = whole(t)
        if n == 0:
            return arb_mat(4, 4, [int(i == j) for i in range(4) for j in range(4)])
        time, axis = self.bounce(n)
        length = arb_of(self.direction[0] ** 2 + self.direction[1] ** 2).sqrt()
        flight = arb_of(time) * length / arb_of(self.scale["position.x"])
        across = arb_of(self.direction[1 - axis] / self.direction[axis])
        signs = [-1 if wall.count(time) % 2 else 1 for wall in self.walls]
        rows = [[arb(0)] * 4 for _ in range(4)]
        for column, weight in ((1 - axis, arb(1)), (axis, -across)):
            rows[1 - axis][column] = signs[1 - axis] * weight
            rows[1 - axis][2 + column] = signs[1 - axis] * weight * flight
        for i in (0, 1):
            rows[2 + i][2 + i] = arb(signs[i])
        return arb_mat(rows)

    def sensitivity(self, t: Fraction) -> float:
        """S: the largest sum of a row; the flight from an earlier bounce is shorter, so that an
        error made there grows less.
        """
        rows = self.jacobian(t).table()
        return bounded(most(sum((abs(x) for x in row), arb(0)) for row in rows))
