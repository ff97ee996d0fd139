"""The rectangular billiard by unfolding: mirrored tables tile the plane, the path is a straight
line, bounces are its crossings.

Each coordinate by itself is x(t) = start + rate t, folded back at the walls at (k + 1/2) size. With
start and direction exact, times of crossings are rational (in units of 1/|direction|): which wall
comes n-th, and whether a corner is met, is decided in whole numbers. The direction is made a unit
vector in the end, so that a root is taken once.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import gcd

from flint import arb, arb_mat

from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import Guarded, arb_of, ball_of, refined
from refdem.truth.dual import Derivatives, flattened, unflattened
from refdem.truth.growth import bounded, most
from refdem.truth.maps.iterated import whole
from refdem.truth.refiner import Size

HALF = Fraction(1, 2)
Exact2 = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Crossings:
    """The times at which one coordinate meets its walls: first, first + every, first + 2 every...

    `every` is None if it never does.
    """

    first: Fraction
    every: Fraction | None

    def count(self, t: Fraction) -> int:
        """The number of crossings at or before t."""
        if self.every is None or t < self.first:
            return 0
        return int((t - self.first) // self.every) + 1

    def time(self, number: int) -> Fraction:
        """The time of crossing `number`, counted from 1."""
        assert self.every is not None
        return self.first + (number - 1) * self.every


def crossings(start: Fraction, rate: Fraction, size: Fraction) -> Crossings:
    """The crossings of the coordinate start + rate t with its walls at (k + 1/2) size, k any whole
    number: the table and its mirror images.
    """
    if rate == 0:
        # It never meets a wall.
        return Crossings(Fraction(0), None)
    # The table is centred on 0: its walls are at -size/2 and size/2.
    if rate > 0:
        distance = size / 2 - start
    else:
        distance = size / 2 + start
    return Crossings(distance / abs(rate), size / abs(rate))


def corner(a: Crossings, b: Crossings) -> Fraction | None:
    """The first time at which both coordinates cross, which is at a corner; None if never.

    a.first + i a.every = b.first + j b.every must hold for whole i, j >= 0. With b.every/a.every =
    p/q in lowest terms and g = (b.first - a.first)/a.every that is i = g + j p/q: q g must be whole
    and q g + j p divisible by q. The solutions are (i, j) + m (p, q) for whole m.
    """
    if a.every is None or b.every is None:
        return None
    ratio = b.every / a.every
    gap = (b.first - a.first) / a.every
    p = ratio.numerator
    q = ratio.denominator
    shift = gap * q
    if shift.denominator != 1 or gcd(p, q) != 1:
        return None
    # The smallest j >= 0 with q g + j p = 0 modulo q.
    if q > 1:
        j = -int(shift) * pow(p, -1, q) % q
    else:
        j = 0
    # i = g + j p/q
    i = (int(shift) + j * p) // q
    # The smallest m with i + m p >= 0; then j + m q >= 0 too.
    if i < 0:
        i = i - (i // p) * p
    return a.time(i + 1)


class Rectangle(Guarded, Truth):
    """The truth of bounce n in a rectangle of `size`, centred on the origin.

    A point starts at `start` along `direction`, which may have any length.
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
        """The time of bounce n (in units of 1/|direction|), and the axis across its wall (0 or 1).

        NotCertifiedError at a corner and after it.
        """
        time, axis = self._merged(n)
        if self.corner is not None and time >= self.corner:
            last = sum(wall.count(self.corner) for wall in self.walls) - 2
            state = {name: ball_of(value) for name, value in self.values(last).items()}
            listed = ", ".join(f"{name} = {float(ball.mid):.17g}" for name, ball in state.items())
            message = (
                f"corner: certified up to bounce {last}, where {listed}; bounce {last + 1} meets a"
                " corner"
            )
            raise NotCertifiedError(message, code="corner", time=float(last), state=state)
        return time, axis

    def _merged(self, n: int) -> tuple[Fraction, int]:
        """The time and the axis of the n-th crossing of both coordinates in order of time.

        Crossing m of one axis is crossing m + (number of the other's until then) of both. Bisection
        finds the largest m of an axis for which that is at most n: it is the n-th of both, or the
        n-th belongs to the other axis.
        """
        for axis in (0, 1):
            wall = self.walls[axis]
            other = self.walls[1 - axis]
            if wall.every is None:
                continue
            low = 0
            high = n
            while low < high:
                middle = (low + high + 1) // 2
                if middle + other.count(wall.time(middle)) <= n:
                    low = middle
                else:
                    high = middle - 1
            if low and low + other.count(wall.time(low)) == n:
                return wall.time(low), axis
        # Both axes cross at one time, at the corner, and crossing n is the first one of the two.
        assert self.corner is not None
        return self.corner, 0

    def values(self, n: int) -> dict[str, arb]:
        """Position and direction after bounce n at the current precision.

        Each coordinate has crossed c mirrored tables: x + rate t -+ c size is its place in the last
        of them, which is a mirror image of the table if c is odd.
        """
        if n:
            time = self.bounce(n)[0]
        else:
            time = Fraction(0)
        length = arb_of(self.direction[0] ** 2 + self.direction[1] ** 2).sqrt()
        quantities = {}
        for axis, name in enumerate("xy"):
            rate = self.direction[axis]
            if n:
                count = self.walls[axis].count(time)
            else:
                count = 0
            if rate > 0:
                sign = 1
            else:
                sign = -1
            # x + rate t - sign c size, which is mirrored with its rate if c is odd.
            position = self.start[axis] + rate * time - sign * count * self.size[axis]
            if count % 2:
                position = -position
                rate = -rate
            quantities[f"position.{name}"] = arb_of(position)
            quantities[f"direction.{name}"] = arb_of(rate) / length
        return {name: quantities[name] for name in self.state}

    def at(self, t: Fraction) -> Mapping[str, Ball]:
        """Position and direction after bounce t, a whole number."""
        n = whole(t)
        return self.proved(lambda: self.values(n))

    def derivatives(self, t: Fraction, count: int) -> Derivatives:
        """The derivatives of position and direction after bounce t by each of `count` parameters,
        by which the numbers of this truth carry their own derivatives (dual.py).
        """
        n = whole(t)
        flat = self.proved(lambda: flattened(self.values(n), count))
        return unflattened(flat, count)

    def proved(self, formula: Callable[[], dict[str, arb]]) -> dict[str, Ball]:
        """The balls of a formula of exact times, which more bits always make small enough."""
        target = min(Fraction(1), *self.scale.values()) / 10**self.digits
        balls = refined(formula, target)
        assert balls is not None
        return balls

    def jacobian(self, t: Fraction) -> arb_mat:
        """The derivative of bounce t by the start, in scales (4 x 4).

        In the unfolded plane the point flies straight on. An error (dr, du) of its start is dr + l
        du after a flight of length l. The bounce lies on the last wall: the error along its normal
        n is 0, and moves the bounce along the wall, t, by -(u_t/u_n) times itself. The mirror
        images of the unfolded plane change signs.
        """
        n = whole(t)
        if n == 0:
            return arb_mat(4, 4, [int(i == j) for i in range(4) for j in range(4)])
        time, axis = self.bounce(n)
        length = arb_of(self.direction[0] ** 2 + self.direction[1] ** 2).sqrt()
        flight = arb_of(time) * length / arb_of(self.scale["position.x"])
        # Along the wall the bounce has the error (dr_t + l du_t) - (u_t/u_n) (dr_n + l du_n).
        tangent = 1 - axis
        slope = arb_of(self.direction[tangent] / self.direction[axis])
        signs = [(-1) ** wall.count(time) for wall in self.walls]
        rows = [[arb(0)] * 4 for _ in range(4)]
        for column, weight in ((tangent, arb(1)), (axis, -slope)):
            rows[tangent][column] = signs[tangent] * weight
            rows[tangent][2 + column] = signs[tangent] * weight * flight
        for i in (0, 1):
            rows[2 + i][2 + i] = arb(signs[i])
        return arb_mat(rows)

    def sensitivity(self, t: Fraction) -> float:
        """S(t): the largest sum of a row of the derivative by the start.

        The flight from an earlier bounce is shorter, so that an error made there grows less.
        """
        rows = self.jacobian(t).table()
        return bounded(most(sum((abs(x) for x in row), arb(0)) for row in rows))
