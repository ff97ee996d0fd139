"""Two spheres so heavy that they pass each other on a prescribed straight path, overlapping for a
while: what the linear law gives them.

Path. In its plane body 1 rests at the origin and body 2 is at (x, b), x = x0 + V t, with the
constant spin w2. The distance of the centres is D = sqrt(x^2 + b^2), the overlap d = D0 - D with D0
= R1 + R2, and A = asinh(x/b), for which dA/dx = 1/D.

Slip. It is V b/D + l2 w2 with the lever l2 = R2 - beta d (`lever` is beta). Its integral over time,
the tangential displacement sigma, is

    sigma = C + g A + a x + e x D,
    e = w2 beta/(2 V),  a = w2 (R2 - beta D0)/V,  g = b + e b^2.

Force on body 1: k d along -n, n = (x, b)/D, and along (-b, x)/D that of the tangential spring, -k_t
sigma, at most mu k d. So all impulses and turning impulses are integrals of A, x and D over x, in
closed form, over V (`antiderivatives`).

Switches. The spring slides where |sigma| comes to its limit mu k d/k_t, and is caught where that
limit outgrows the slip again: both are proved by bisection and interval Newton. Without a spring
(k_t = 0) it slides all the time, by mu k d against the slip; a slip that then changes its sign is
not certified.

The masses are finite and move by less than 1e-20 of the overlap, which the radii contain
(XX"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from math import floor, log10
from typing import Any, Self

from flint import arb, arb_mat

from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of, ball_of, precision
from refdem.truth.closed_form import ClosedForm, displaced_part, larger, per_precision
from refdem.truth.dual import DualBall, parameters
from refdem.truth.events.crossing import Along, SwitchError, Watched, carried_crossing
from refdem.truth.growth import Grows, UnsharpError, upper
from refdem.truth.swept_growth import Span, largest_growth

AXES = "xyz"
STATE = ("r.x", "r.y", "v.x", "v.y")
COORDINATES = (*STATE, "sigma", "impulse.x", "impulse.y", "turning.z")
"""The coordinates of an error that grows. sigma is one of them, because it is part of the state."""
SIGMA = 4
"""Where sigma stands in COORDINATES."""
MOST_PIECES = 16
"""A contact with more pieces is not followed."""
BITS_OF_BOUND = 64
"""The working precision of a bound, of which few digits matter."""
Matrix = tuple[tuple[Fraction, ...], ...]


@dataclass(frozen=True, kw_only=True)
class Passing:
    """Exact parameters of the path and both spheres, in SI units.

    `spin` is w2 [rad/s], `lever` beta, `start` the (x, y, vx, vy) of body 2 in the plane at t = 0;
    `frame` has the axes of the plane, then its normal, as columns (a rational rotation).
    """

    mass: Fraction
    radii: tuple[Fraction, Fraction]
    stiffness: Fraction
    tangential_stiffness: Fraction
    friction: Fraction
    spin: Fraction
    lever: Fraction
    start: tuple[Fraction, ...]
    frame: Matrix

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The path from a start whose coordinate `axis` is larger by exactly `amount`."""
        return replace(self, start=larger(self.start, axis, amount))


@dataclass(frozen=True)
class Place:
    """A point (x, b) of the path and the functions of x there; balls, or balls with slopes."""

    x: Any
    b: Any

    @property
    def distance(self) -> Any:
        """The distance D between the centres."""
        return (self.x * self.x + self.b * self.b).sqrt()

    @property
    def angle(self) -> Any:
        """A = asinh(x/b), the integral of 1/D over x."""
        return (self.x / self.b).asinh()

    @property
    def distance_integral(self) -> Any:
        """The integral of D over x: (x D + b^2 A)/2."""
        return (self.x * self.distance + self.b * self.b * self.angle) / 2


@dataclass(frozen=True)
class Piece:
    """A piece of the contact, from x = `begin` on.

    `side` is the side to which the spring slides at its limit, 1 or -1; 0 while it sticks, with the
    constant C of sigma.
    """

    begin: arb
    side: int
    constant: arb


@dataclass(frozen=True)
class ContactPath(ClosedForm):
    """The truth of a passing: the impulse [N s] and turning impulse [N m s] that body 1 has got by
    time t, and position [m] and velocity [m/s] of body 2.
    """

    state = STATE
    method = "closed form from switch to switch; switches proved by bisection and interval Newton"
    witness = (
        "midpoint sums of the force, its spring clipped step by step; the motion itself by"
        " extrapolation"
    )

    path: Passing

    displaced = displaced_part("path")

    def refuse_more_digits(self, t: arb) -> None:
        """Raises NotCertifiedError for more digits than the finite masses allow."""
        most = self.most_digits()
        if self.digits > most:
            if most > 0:
                remedy = f"which leaves {most} digits; ask for at most {most}, or for a faster path"
            else:
                remedy = "which leaves no digit; take a faster path, or a smaller stiffness"
            raise NotCertifiedError(
                f"at t = {float(t):.17g} s: precision: the path is straight only as far as spheres"
                f" of {float(self.path.mass):.3g} kg do not give way to the force, {remedy}",
                code="precision",
                time=0.0,
            )

    def most_digits(self) -> int:
        """The number of digits that are certified, of the quantity with the smallest scale: what
        finite masses may change is less than a unit of the last one.
        """
        # A component in axes of space is a sum over those of the plane.
        spread = max(sum(map(abs, row), Fraction(0)) for row in self.path.frame)
        with precision(BITS_OF_BOUND):
            bound = ball_of(total_bound(self.path) * arb_of(spread))
        one_digit = self.refiner.to(0).target()
        return floor(log10(one_digit / (bound.mid + bound.radius)))

    @per_precision
    def numbers(self) -> dict[str, Any]:
        """The numbers of the path from its start."""
        return self.numbers_from([arb_of(value) for value in self.path.start])

    def numbers_from(self, state: Sequence[Any]) -> dict[str, Any]:
        """The numbers of the path through the state (x, y, vx, vy) of body 2 in the plane.

        b, x and V are those of the top of this file, in axes along and across the velocity; g, a, e
        the coefficients of sigma; cos and sin those of the direction of the velocity.
        """
        p = self.path
        x, y, u, v = state
        speed = (u * u + v * v).sqrt()
        along = (x * u + y * v) / speed
        b = (y * u - x * v) / speed
        a = arb_of(p.spin * (p.radii[1] - p.lever * sum(p.radii))) / speed
        e = arb_of(p.spin * p.lever) / (2 * speed)
        return {
            "b": b,
            "x": along,
            "V": speed,
            "g": b + e * b * b,
            "a": a,
            "e": e,
            "cos": u / speed,
            "sin": v / speed,
        }

    @property
    def touch_distance(self) -> arb:
        """The distance D0 between the centres at touch, the sum of radii."""
        return arb_of(sum(self.path.radii, Fraction(0)))

    def place(self, x: arb) -> Place:
        """The point of the path with coordinate x."""
        return Place(x, self.numbers()["b"])

    def side_before(self, piece: Piece) -> int:
        """The side to which the piece before this one slides; 0 where this one begins at touch."""
        index = self.pieces().index(piece)
        if index:
            return self.pieces()[index - 1].side
        return 0

    def parting(self) -> arb:
        """The x > 0 at which they part, x^2 = D0^2 - b^2; they touch at -x."""
        x: arb = (self.touch_distance * self.touch_distance - self.numbers()["b"] ** 2).sqrt()
        return x

    def sigma(self, at: Place, numbers: Mapping[str, Any] | None = None) -> Any:
        """sigma - C = g A + a x + e x D at a point of this path, or of one with other numbers."""
        n = numbers
        if n is None:
            n = self.numbers()
        return n["g"] * at.angle + n["a"] * at.x + n["e"] * at.x * at.distance

    def limit_per_overlap(self) -> arb:
        """The ratio mu k/k_t, the spring stretch at the limit per overlap."""
        p = self.path
        return arb_of(p.friction * p.stiffness / p.tangential_stiffness)

    def sigma_limit(self, x: arb, order: int) -> arb:
        """The limit mu k d/k_t of |sigma|, or its derivative by x of an order up to 2.

        d = D0 - D, D' = x/D and D'' = b^2/D^3.
        """
        at = self.place(x)
        distance: arb = at.distance
        overlap_derivatives = (
            self.touch_distance - distance,
            -at.x / distance,
            -at.b * at.b / distance**3,
        )
        limit: arb = self.limit_per_overlap() * overlap_derivatives[order]
        return limit

    def slip(self, x: arb, order: int) -> arb:
        """The slip per V, sigma' = b/D + a + 2 e D (order 0), or its derivative sigma'' (1)."""
        at = self.place(x)
        n = self.numbers()
        distance = at.distance
        derivatives: tuple[arb, arb] = (
            at.b / distance + n["a"] + 2 * n["e"] * distance,
            -at.b * x / distance**3 + 2 * n["e"] * x / distance,
        )
        return derivatives[order]

    def margin(self, piece: Piece, side: int, order: int, x: arb) -> arb:
        """The margin of a sticking spring to its limit on a side, limit - side sigma.

        Or its derivative by x of the order given. It slides when the margin comes to 0.
        """
        sigma: arb
        if order == 0:
            sigma = piece.constant + self.sigma(self.place(x))
        else:
            sigma = self.slip(x, order - 1)
        return self.sigma_limit(x, order) - side * sigma

    def excess_rate(self, side: int, order: int, x: arb) -> arb:
        """The rate by x at which the slip would carry a spring at its limit beyond it.

        side sigma' - limit' (order 0), or its derivative (1). Where it comes to 0 the spring is
        caught: from there on it sticks.
        """
        return side * self.slip(x, order) - self.sigma_limit(x, order + 1)

    @per_precision
    def pieces(self) -> list[Piece]:
        """All pieces of the motion, from touch on, in order of time."""
        x = -self.parting()
        end = self.parting()
        slip = self.slip(x, 0)
        if not (slip > 0 or slip < 0):
            raise UndecidedError("the direction of the slip at touch")
        if slip > 0:
            side = 1
        else:
            side = -1
        if not self.path.tangential_stiffness:
            return self.without_spring(Piece(x, side, arb(0)), end)
        # At touch sigma and its limit are both 0: the phase follows from which of the two grows
        # faster.
        excess = self.excess_rate(side, 0, x)
        if not (excess > 0 or excess < 0):
            raise UndecidedError("whether it slides from touch on")
        if excess > 0:
            first_side = side
        else:
            first_side = 0
        pieces = [Piece(x, first_side, -self.sigma(self.place(x)))]
        # The order of the zero that the margin to each side has where a stick begins: 1 at touch,
        # on both sides; 2 where a slide is caught, since sigma and its limit agree to first order.
        touching = {1: 1, -1: 1}
        while len(pieces) < MOST_PIECES:
            last = pieces[-1]
            after = self.next_piece(last, touching, end)
            if after is None:
                return pieces
            pieces.append(after)
            if not after.side:
                touching = {last.side: 2}
            else:
                touching = {}
        raise SwitchError("end", "the contact has more pieces than are followed", 0.0)

    def without_spring(self, whole: Piece, end: arb) -> list[Piece]:
        """The one piece of a contact without a tangential spring: friction mu k d against the slip.

        SwitchError where the slip changes its sign: there friction jumps, and nothing holds a slip
        that is prescribed at zero.
        """
        slip: list[Along] = [partial(self.sided_slip, whole.side, order) for order in (0, 1)]
        turns = carried_crossing([Watched("slip", slip)], whole.begin, end)
        if turns is not None and self.path.friction:
            n = self.numbers()
            time = (turns[1] - n["x"]) / n["V"]
            message = "friction without a tangential spring jumps where the slip changes its sign"
            raise SwitchError("singular", message, float(time.mid()))
        return [whole]

    def sided_slip(self, side: int, order: int, x: arb) -> arb:
        """A derivative by x of the slip to one side."""
        return side * self.slip(x, order)

    def next_piece(self, last: Piece, touching: Mapping[int, int], end: arb) -> Piece | None:
        """The piece that follows a piece; None if that lasts until x = `end`.

        `touching` has the order of the zero of the margin to a side where a stick begins.
        """
        if last.side:
            rates: list[Along] = [partial(self.excess_rate, last.side, order) for order in (0, 1)]
            caught = carried_crossing([Watched("caught", rates)], last.begin, end)
            if caught is None:
                return None
            x = caught[1]
            # There sigma is at its limit, from which the constant C follows.
            constant = last.side * self.sigma_limit(x, 0) - self.sigma(self.place(x))
            return Piece(x, 0, constant)
        guards = []
        for side in (1, -1):
            order = touching.get(side, 0)
            margins: list[Along] = [
                partial(self.margin, last, side, n) for n in range(max(2, order + 1))
            ]
            guards.append(Watched(str(side), margins, order))
        slide = carried_crossing(guards, last.begin, end)
        if slide is None:
            return None
        name, x = slide
        return Piece(x, int(name), arb(0))

    def antiderivatives(
        self, side: int, constant: Any, at: Place, n: Mapping[str, Any]
    ) -> list[Any]:
        """Antiderivatives by x, at a point, of the force (2, along x and y) and torque on body 1.

        The force is -k d (x, b)/D + q s (-b, x)/D and the torque q s (R1 - beta d), where q s is
        the tangential force: s = d and q = -side mu k while it slides to a side, s = sigma and q =
        -k_t while it sticks (`side` 0) with the constant C of sigma. `n` has the numbers of the
        path. With I_f for the integral of f over x this is

            -k I_(d x/D) - q I_(s b/D),   -k I_(d b/D) + q I_(s x/D),
            q ((R1 - beta D0) I_s + beta I_(s D)).
        """
        p = self.path
        x = at.x
        b = at.b
        distance = at.distance
        angle = at.angle
        # I_D
        of_distance = at.distance_integral
        d0 = self.touch_distance
        k = arb_of(p.stiffness)
        # I_(d x/D) and I_(d b/D), with d = D0 - D.
        normal_x = d0 * distance - x * x / 2
        normal_y = b * (d0 * angle - x)
        lever = arb_of(p.radii[0] - p.lever * sum(p.radii))
        beta = arb_of(p.lever)
        if side:
            q = -side * arb_of(p.friction) * k
            s_b = normal_y
            s_x = normal_x
            s_one = d0 * x - of_distance
            s_distance = d0 * of_distance - (x * x * x / 3 + b * b * x)
        else:
            q = -arb_of(p.tangential_stiffness)
            c = constant
            g = n["g"]
            a = n["a"]
            e = n["e"]
            # Term by term of s = C + g A + a x + e x D.
            s_b = b * (c * angle + g * angle * angle / 2 + a * distance + e * x * x / 2)
            s_x = (
                c * distance
                + g * (distance * angle - x)
                + a * (x * distance - b * b * angle) / 2
                + e * x * x * x / 3
            )
            s_one = c * x + g * (x * angle - distance) + a * x * x / 2 + e * distance**3 / 3
            # I_(A D)
            of_angle_distance = angle * of_distance - (x * x + b * b * angle * angle) / 4
            s_distance = (
                c * of_distance + g * of_angle_distance + a * distance**3 / 3 + e * distance**4 / 4
            )
        force_x = -k * normal_x - q * s_b
        force_y = -k * normal_y + q * s_x
        torque = q * (lever * s_one + beta * s_distance)
        return [force_x, force_y, torque]

    def evaluate(self, t: arb) -> dict[str, arb]:
        """impulse, turning (impulse), r and v by axis at time t, in axes of space."""
        self.refuse_more_digits(t)
        n = self.numbers()
        p = self.path
        total = self.gained(n["x"] + n["V"] * t)
        # What finite masses may change.
        allowance = arb(0, total_bound(p))
        impulse = [
            n["cos"] * total[0] - n["sin"] * total[1] + allowance,
            n["sin"] * total[0] + n["cos"] * total[1] + allowance,
            arb(0),
        ]
        start = [arb_of(value) for value in p.start]
        vectors = {
            "impulse": impulse,
            "turning": [arb(0), arb(0), total[2] + allowance],
            "r": [start[0] + start[2] * t, start[1] + start[3] * t, arb(0)],
            "v": [start[2], start[3], arb(0)],
        }
        quantities = {}
        for name, vector in vectors.items():
            for axis, component in zip(AXES, self.turned(vector), strict=True):
                quantities[f"{name}.{axis}"] = component
        return quantities

    def gained(self, x: arb) -> list[arb]:
        """The impulse (2, along and across the path) and turning impulse of body 1 up to x.

        The sum over the pieces so far of antiderivatives at their ends. UndecidedError if balls do
        not decide in which piece x lies.
        """
        n = self.numbers()
        total = [arb(0)] * 3
        if x > -self.parting():
            pieces = self.pieces()
        elif x <= -self.parting():
            pieces = []
        else:
            raise UndecidedError("whether they touch yet")
        for index, piece in enumerate(pieces):
            if index + 1 < len(pieces):
                end = pieces[index + 1].begin
            else:
                end = self.parting()
            if x <= piece.begin:
                break
            if not x > piece.begin or not (x <= end or x > end):
                raise UndecidedError("in which piece it is")
            if x > end:
                last = self.place(end)
            else:
                last = self.place(x)
            first = self.place(piece.begin)
            at_last = self.antiderivatives(piece.side, piece.constant, last, n)
            at_first = self.antiderivatives(piece.side, piece.constant, first, n)
            for i in range(3):
                total[i] = total[i] + (at_last[i] - at_first[i]) / n["V"]
        return total

    def turned(self, vector: list[arb]) -> list[arb]:
        """The vector rotated from the frame of the path to space axes."""
        return [
            sum((arb_of(row[j]) * vector[j] for j in range(3)), arb(0)) for row in self.path.frame
        ]

    @per_precision
    def growth(self) -> Grows:
        """How errors of STATE in the plane grow, at all times, with masses that do not move.

        That they do move changes it by a part of 1e-20.
        """
        return PathGrowth(self)


@dataclass(frozen=True)
class Leg:
    """A part of the motion between two times [s]: a piece of the contact, or free flight (None).

    The last one has no end. `jump` is the matrix that maps errors of COORDINATES across its end.
    """

    begin: arb
    end: arb | None
    piece: Piece | None
    jump: arb_mat


class PathGrowth:
    """S of a path: how an error of position or velocity of body 2 changes all that body 1 gets.

    An error of COORDINATES grows along a leg by `propagator`, and is mapped by the `jump` of the
    leg at its end. The force is continuous at every switch, so that no error jumps there but that
    of sigma: sigma begins with 0 at touch, which an error of D moves by -dD/D' in time, and is at
    its limit, which depends on D, where a slide ends. While it slides sigma has no effect.

    S is the largest growth over all times at which an error is made (swept_growth.py). Every leg is
    one span of such times; an `answer` is a row of the matrix that maps the error to the scaled
    quantities at t.
    """

    def __init__(self, form: ContactPath) -> None:
        self.form = form
        n = form.numbers()
        self.start = [arb_of(value) for value in form.path.start]
        self.legs = list(self.all_legs(n))
        # What each leg, with the jump at its end, makes of an error at its start.
        self.transitions = [
            leg.jump * self.propagator(leg, arb(0), leg.end - leg.begin)
            for leg in self.legs
            if leg.end is not None
        ]

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        time = arb_of(t)
        current_index = self.leg_index(time)
        current = self.legs[current_index]
        answers = partial(self.answers_on_leg, current, time)
        spans = [Span(Fraction(0), upper(time - current.begin), answers)]
        # From the start of a leg to the quantities at t; backwards from the current leg.
        from_begin = self.readings() * self.propagator(current, arb(0), time - current.begin)
        for index in reversed(range(current_index)):
            leg = self.legs[index]
            assert leg.end is not None
            answers = partial(self.answers_before, leg, from_begin)
            spans.append(Span(Fraction(0), upper(leg.end - leg.begin), answers))
            from_begin = from_begin * self.transitions[index]
        return largest_growth(spans)

    def answers_on_leg(
        self, leg: Leg, time: arb, middle: Fraction, off: Fraction
    ) -> tuple[list[arb], list[arb]]:
        """Answers at `time` [s] to an error made on the same leg, about `middle` since its start.

        See `answers_and_bounds`; `off` is how far from the middle the error may be made.
        """
        since = arb_of(middle)
        left = time - leg.begin - since
        return self.answers_and_bounds(
            self.readings() * self.propagator(leg, since, left), leg, since, off
        )

    def answers_before(
        self, leg: Leg, after: arb_mat, middle: Fraction, off: Fraction
    ) -> tuple[list[arb], list[arb]]:
        """The same for an error made on an earlier leg; `after` maps one at its end to answers."""
        assert leg.end is not None
        since = arb_of(middle)
        left = leg.end - leg.begin - since
        return self.answers_and_bounds(
            after * (leg.jump * self.propagator(leg, since, left)), leg, since, off
        )

    def answers_and_bounds(
        self, answers: arb_mat, leg: Leg, since: arb, off: Fraction
    ) -> tuple[list[arb], list[arb]]:
        """The growth of each quantity for an error made `since` the start of a leg, and a bound of
        it for all errors made at most `off` [s] from there.

        Growth is the sum of |answer| over errors of one scale in every coordinate of STATE.

        `answers` has a row for every quantity. By the mean value theorem a row y at another time of
        the error is y + h y' with |h| <= off, and y' = -y A, A being the Jacobian of the equations:
        r' = v; sigma' and the force by (r, v, sigma); the impulses are their integrals. So the
        entry of sigma follows from those of the impulses, those of r from both, those of v from all
        (`times` is a ball of -h, which is symmetric).
        """
        sizes = [arb_of(self.form.scale[name]) for name in STATE]
        times = arb(0, arb_of(off).upper())
        jacobian = self.jacobian(leg, since + times)
        growths = []
        bounds = []
        for row in answers.table():
            x, y, u, v, sigma, *impulses = row
            sigma_ball = sigma + times * impulse_change(impulses, jacobian, SIGMA)
            changes = [
                impulse_change(impulses, jacobian, i) + sigma_ball * jacobian[0][i]
                for i in range(len(STATE))
            ]
            x_ball = x + times * changes[0]
            y_ball = y + times * changes[1]
            u_ball = u + times * (changes[2] + x_ball)
            v_ball = v + times * (changes[3] + y_ball)
            growths.append(sum_of_sizes((x, y, u, v), sizes))
            bounds.append(sum_of_sizes((x_ball, y_ball, u_ball, v_ball), sizes))
        return growths, bounds

    def jacobian(self, leg: Leg, since: arb) -> list[tuple[arb, ...]]:
        """The derivatives by (x, y, u, v, sigma) of sigma', the force (2) and the torque on body 1.

        Four rows, at a ball of times `since` the start of a leg; sigma' is 0 while it slides.
        """
        if leg.piece is None:
            return [(arb(0),) * 5] * 4
        form = self.form
        p = self.form.path
        time = leg.begin + since
        piece = leg.piece
        state = [*self.place(time), *self.start[2:]]
        sigma_value = arb(0)
        if not piece.side:
            n = form.numbers()
            sigma_value = piece.constant + form.sigma(form.place(n["x"] + n["V"] * time))
        # From here on balls carry their derivatives by the five coordinates.
        x, y, u, v, sigma = parameters([*state, sigma_value])
        distance = (x * x + y * y).sqrt()
        overlap = form.touch_distance - distance
        lever2 = arb_of(p.radii[1]) - arb_of(p.lever) * overlap
        slip = (u * y - v * x) / distance + lever2 * arb_of(p.spin)
        normal_force = arb_of(p.stiffness) * overlap / distance
        tangential_force = arb_of(p.tangential_stiffness) * sigma
        if piece.side:
            tangential_force = piece.side * arb_of(p.friction * p.stiffness) * overlap
            slip = slip * 0
        force_x = -normal_force * x + tangential_force * y / distance
        force_y = -normal_force * y - tangential_force * x / distance
        torque = -tangential_force * (arb_of(p.radii[0]) - arb_of(p.lever) * overlap)
        return [slip.slopes, force_x.slopes, force_y.slopes, torque.slopes]

    def leg_index(self, time: arb) -> int:
        """The index of the leg in which a time [s] lies; UnsharpError if balls do not decide it."""
        for index, leg in enumerate(self.legs):
            if leg.end is None or time <= leg.end:
                return index
            if not time > leg.end:
                raise UnsharpError("whether a switch is over")
        raise AssertionError("the last leg has no end")

    def all_legs(self, n: Mapping[str, Any]) -> Iterator[Leg]:
        """The legs in order of time: free flight, every piece of the contact, free flight."""
        form = self.form
        pieces = form.pieces()
        times = [(piece.begin - n["x"]) / n["V"] for piece in pieces]
        times.append((form.parting() - n["x"]) / n["V"])
        yield Leg(arb(0), times[0], None, self.sigma_jump(pieces[0], times[0]))
        for piece, after, begin, end in zip(
            pieces, [*pieces[1:], None], times, times[1:], strict=False
        ):
            yield Leg(begin, end, piece, self.sigma_jump(after, end))
        yield Leg(times[-1], None, None, self.sigma_jump(None, times[-1]))

    def sigma_jump(self, piece: Piece | None, time: arb) -> arb_mat:
        """The matrix that maps an error across the start of a piece at a time [s].

        All of it is kept but the error of sigma. Where a stick begins, sigma follows from D: at
        touch (sigma = 0 there) an error dD shifts the time of touch by -dD/D', and sigma by sigma'
        dD/D' = V sigma_x dD/(V x/D); where a slide to a side ends, sigma = side mu k (D0 - D)/k_t.
        """
        count = len(COORDINATES)
        rows = [[arb(int(i == j)) for j in range(count)] for i in range(count)]
        rows[SIGMA][SIGMA] = arb(0)
        if piece is not None and not piece.side:
            n = self.form.numbers()
            x = n["x"] + n["V"] * time
            distance = self.form.place(x).distance
            by_distance = self.form.slip(x, 0) * distance / x
            side = self.form.side_before(piece)
            if side:
                by_distance = -side * self.form.limit_per_overlap()
            place = self.place(time)
            for i in range(2):
                rows[SIGMA][i] = by_distance * place[i] / distance
        return arb_mat(rows)

    def place(self, time: arb) -> list[arb]:
        """The position (2) of body 2 in the plane at a time."""
        x, y, u, v = self.start
        return [x + u * time, y + v * time]

    def propagator(self, leg: Leg, since: arb, elapsed: arb) -> arb_mat:
        """The matrix that maps an error of COORDINATES made `since` the start of a leg to what it
        is when the time `elapsed` [s] has passed on that leg.

        The motion from a state (x, y, u, v, sigma) is computed with derivatives by these five; an
        error of the impulses stays what it is.
        """
        begin = leg.begin + since
        state = parameters([*self.place(begin), *self.start[2:], arb(0)])
        x, y, u, v, sigma = state
        later: list[Any] = [x + u * elapsed, y + v * elapsed, u, v, sigma]
        impulses: list[Any] = [sigma * 0] * 3
        if leg.piece is not None:
            n = self.form.numbers_from(state[:4])
            first = Place(n["x"], n["b"])
            last = Place(n["x"] + n["V"] * elapsed, n["b"])
            # C = sigma - (g A + a x + e x D): its value is known, its slopes are those of this.
            constant_slopes = (sigma - self.form.sigma(first, n)).slopes
            constant = DualBall(leg.piece.constant, constant_slopes)
            at_last = self.form.antiderivatives(leg.piece.side, constant, last, n)
            at_first = self.form.antiderivatives(leg.piece.side, constant, first, n)
            along, across, turning = (
                (after - before) / n["V"] for after, before in zip(at_last, at_first, strict=True)
            )
            impulses = [
                n["cos"] * along - n["sin"] * across,
                n["sin"] * along + n["cos"] * across,
                turning,
            ]
            if not leg.piece.side:
                later[SIGMA] = constant + self.form.sigma(last, n)
        rows = [[*coordinate.slopes, *[arb(0)] * 3] for coordinate in later]
        for i, impulse in enumerate(impulses):
            rows.append([*impulse.slopes, *[arb(int(i == j)) for j in range(3)]])
        return arb_mat(rows)

    def readings(self) -> arb_mat:
        """The derivatives of every quantity, in its scale, by COORDINATES: rotated into space."""
        frame = self.form.path.frame
        scale = self.form.scale
        # Where the components of a vector in the plane's axes stand in COORDINATES; None for 0.
        columns_of: dict[str, tuple[int | None, ...]] = {
            "r": (0, 1, None),
            "v": (2, 3, None),
            "impulse": (5, 6, None),
            "turning": (None, None, 7),
        }
        rows = []
        for name, columns in columns_of.items():
            for i, axis in enumerate(AXES):
                row = [arb(0)] * len(COORDINATES)
                for j, column in enumerate(columns):
                    if column is not None:
                        row[column] = arb_of(frame[i][j] / scale[f"{name}.{axis}"])
                rows.append(row)
        return arb_mat(rows)


def sum_of_sizes(entries: Sequence[arb], scales: Sequence[arb]) -> arb:
    """The sum over a row of answers, for an error of one scale in every coordinate."""
    terms = (abs(entry) * scale for entry, scale in zip(entries, scales, strict=True))
    return sum(terms, arb(0))


def impulse_change(impulses: Sequence[arb], jacobian: Sequence[Sequence[arb]], column: int) -> arb:
    """The sum over force and torque of (answer to that impulse) times (its derivative).

    `impulses` are the entries of a row of answers for the three impulses; the derivative is by the
    coordinate `column`, in the last three rows of the Jacobian.
    """
    products = (answer * row[column] for answer, row in zip(impulses, jacobian[1:], strict=True))
    return sum(products, arb(0))


def total_bound(p: Passing) -> arb:
    """A bound of what the motion of the finite masses can change of an impulse.

    With stiffness k, sum of radii R and time T: a force of at most k R moves a mass by k R T^2/(2
    m), which changes forces by k times as much and impulses by k^2 R T^3/(2 m). The factor 100 is
    far more than levers, turning impulses and the other body need.
    """
    time = 4 * sum(p.radii) / max(abs(p.start[2]), abs(p.start[3]))
    stiffness = p.stiffness * (1 + p.friction) + p.tangential_stiffness
    return arb_of(stiffness * stiffness * sum(p.radii) * time**3 * 100 / p.mass)
