"""Two spheres so heavy that they pass each other on a prescribed straight path, overlapping for a
while: what the linear law gives them.

In the plane of the path body 1 rests at the origin and body 2 is at (x, b), x = x0 + V t, with the
constant spin w2: D^2 = x^2 + b^2, overlap d = D0 - D, A = asinh(x/b). The slip V b/D + l2 w2 with
the lever l2 = R2 - beta d has the way sigma = C + g A + a x + e x D, and with forces k d along n =
(x, b)/D and k_t sigma, or mu k d, along (-b, x)/D all impulses and turning impulses are integrals
of A, x and D in closed form. Where the spring comes to its limit, and where it is caught, is proved
by bisection and interval Newton. Without a spring (k_t = 0) it slides all the way, by mu k d
against the slip; a slip that then changes its sign is not certified. The masses are finite and give
way by less than 1e-20 of the overlap, which the radii contain.
"""

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any, Self

from flint import arb, arb_mat

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.events.crossing import Along, SwitchError, Watched, earliest
from refdem.truth.growth import Grows, UnsharpError, upper
from refdem.truth.refiner import Refiner, Size
from refdem.truth.slopes import Sloped, parameters
from refdem.truth.swept_growth import Span, largest_growth

AXES = "xyz"
STATE = ("r.x", "r.y", "v.x", "v.y")
COORDINATES = (*STATE, "way", "impulse.x", "impulse.y", "turning.z")
"""What errors grow in: the spring remembers the way of the slip."""
WAY = 4
Matrix = tuple[tuple[Fraction, ...], ...]


@dataclass(frozen=True, kw_only=True)
class Passing:
    """Exact parameters of the path and both spheres, in SI units.

    `frame` has the axes of the plane, then its normal, as columns (a rational rotation).
    """

    mass: Fraction
    radii: tuple[Fraction, Fraction]
    stiffness: Fraction
    tangential_stiffness: Fraction
    friction: Fraction
    spin: Fraction
    lever: Fraction
    start: tuple[Fraction, Fraction, Fraction, Fraction]
    frame: Matrix


@dataclass(frozen=True)
class Place:
    """x, D, A, and powers of them that integrals need, of balls or with their slopes."""

    x: Any
    b: Any

    @property
    def distance(self) -> Any:
        """The distance D between the centres."""
        return (self.x * self.x + self.b * self.b).sqrt()

    @property
    def angle(self) -> Any:
        """The angle A = asinh(x/b) along the path."""
        return (self.x / self.b).asinh()

    @property
    def area(self) -> Any:
        """The integral of the distance D over x."""
        return (self.x * self.distance + self.b * self.b * self.angle) / 2


@dataclass(frozen=True)
class Piece:
    """A piece of the contact from x on: sticking with the constant C of the way, or sliding to one
    side.
    """

    begin: arb
    side: int
    constant: arb


class ContactPath(ClosedForm):
    """Impulses [N s] and turning impulses [N m s] that body 1 has got, place and velocity of body
    2.
    """

    state = STATE
    method = "closed form from switch to switch; switches proved by bisection and interval Newton"
    witness = (
        "midpoint sums of the force, its spring clipped step by step; the motion itself by"
        " extrapolation"
    )

    def __init__(self, scale: Mapping[str, Size], path: Passing) -> None:
        self.refiner = Refiner.of(scale)
        self.path = path

    def displaced(self, axis: int, amount: Fraction) -> Self:
        start = list(self.path.start)
        start[axis] += amount
        other = copy(self)
        other.kept = {}
        other.path = Passing(**{**vars(self.path), "start": tuple(start)})
        return other

    @per_precision
    def numbers(self) -> dict[str, Any]:
        """The numbers of the path from its start."""
        return self.numbers_from([arb_of(value) for value in self.path.start])

    def numbers_from(self, state: Sequence[Any]) -> dict[str, Any]:
        """The numbers of the path through a place with a velocity: b, x there, V along x, and the
        coefficients g, a, e of the slip's way.
        """
        p = self.path
        x, y, u, v = state
        speed = (u * u + v * v).sqrt()
        along = (x * u + y * v) / speed
        off = (y * u - x * v) / speed
        base = arb_of(p.spin * (p.radii[1] - p.lever * sum(p.radii))) / speed
        steep = arb_of(p.spin * p.lever) / (2 * speed)
        return {
            "b": off,
            "x": along,
            "V": speed,
            "g": off + steep * off * off,
            "a": base,
            "e": steep,
            "cos": u / speed,
            "sin": v / speed,
        }

    @property
    def reach(self) -> arb:
        """The distance D0 between the centres at touch, the sum of radii."""
        return arb_of(sum(self.path.radii, Fraction(0)))

    def place(self, x: arb) -> Place:
        """The point of the path with coordinate x."""
        return Place(x, self.numbers()["b"])

    def constant_side(self, piece: Piece) -> int:
        """The side of its limit on which the spring is where a stick begins; 0 at touch."""
        number = self.pieces().index(piece)
        if number:
            return self.pieces()[number - 1].side
        return 0

    def ends(self) -> arb:
        """The x > 0 at which they part."""
        found: arb = (self.reach * self.reach - self.numbers()["b"] ** 2).sqrt()
        return found

    def way(self, at: Place, numbers: Mapping[str, Any] | None = None) -> Any:
        """sigma without its constant, on this path or on another one."""
        n = numbers
        if n is None:
            n = self.numbers()
        return n["g"] * at.angle + n["a"] * at.x + n["e"] * at.x * at.distance

    def slack(self) -> arb:
        """The ratio mu k/k_t, the spring stretch at the limit per overlap."""
        p = self.path
        return arb_of(p.friction * p.stiffness / p.tangential_stiffness)

    def limit(self, x: arb, order: int) -> arb:
        """mu k d / k_t and its derivatives by x."""
        at = self.place(x)
        distance: arb = at.distance
        rates = (self.reach - distance, -at.x / distance, -at.b * at.b / distance**3)
        found: arb = self.slack() * rates[order]
        return found

    def slip(self, x: arb, order: int) -> arb:
        """Derivatives of sigma by x, from the first on."""
        at = self.place(x)
        n = self.numbers()
        distance = at.distance
        rates: tuple[arb, arb] = (
            at.b / distance + n["a"] + 2 * n["e"] * distance,
            -at.b * x / distance**3 + 2 * n["e"] * x / distance,
        )
        return rates[order]

    def spared(self, piece: Piece, side: int, order: int, x: arb) -> arb:
        """A derivative by x of what the spring has left towards a side."""
        held: arb
        if order == 0:
            held = piece.constant + self.way(self.place(x))
        else:
            held = self.slip(x, order - 1)
        return self.limit(x, order) - side * held

    def surplus(self, side: int, order: int, x: arb) -> arb:
        """The amount by which a clipped spring would outgrow its limit."""
        return side * self.slip(x, order) - self.limit(x, order + 1)

    @per_precision
    def pieces(self) -> list[Piece]:
        """All pieces of the motion, from touch on, in order of time."""
        x = -self.ends()
        end = self.ends()
        slip = self.slip(x, 0)
        if not (slip > 0 or slip < 0):
            raise UndecidedError("the direction of the slip at touch")
        if slip > 0:
            side = 1
        else:
            side = -1
        if not self.path.tangential_stiffness:
            return self.without_spring(Piece(x, side, arb(0)), end)
        first = self.surplus(side, 0, x)
        if not (first > 0 or first < 0):
            raise UndecidedError("whether it slides from touch on")
        found = [Piece(x, side if first > 0 else 0, -self.way(self.place(x)))]
        touching = {1: 1, -1: 1}
        while len(found) < 16:
            last = found[-1]
            after = self.after(last, touching, end)
            if after is None:
                return found
            found.append(after)
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
        turns = earliest([Watched("slip", slip)], whole.begin, end)
        if turns is not None and self.path.friction:
            n = self.numbers()
            told = "friction without a tangential spring jumps where the slip changes its sign"
            raise SwitchError("singular", told, float(((turns[1] - n["x"]) / n["V"]).mid()))
        return [whole]

    def sided_slip(self, side: int, order: int, x: arb) -> arb:
        """A derivative by x of the slip to one side."""
        return side * self.slip(x, order)

    def after(self, last: Piece, touching: Mapping[int, int], end: arb) -> Piece | None:
        """The piece that follows a piece; None after the last one."""
        if last.side:
            rates: list[Along] = [partial(self.surplus, last.side, order) for order in (0, 1)]
            caught = earliest([Watched("caught", rates)], last.begin, end)
            if caught is None:
                return None
            return Piece(
                caught[1], 0, last.side * self.limit(caught[1], 0) - self.way(self.place(caught[1]))
            )
        guards = []
        for side in (1, -1):
            order = touching.get(side, 0)
            spare: list[Along] = [
                partial(self.spared, last, side, n) for n in range(max(2, order + 1))
            ]
            guards.append(Watched(str(side), spare, order))
        found = earliest(guards, last.begin, end)
        if found is None:
            return None
        return Piece(found[1], int(found[0]), arb(0))

    def given(self, side: int, constant: Any, at: Place, n: Mapping[str, Any]) -> list[Any]:
        """Antiderivatives by x of the force's parts along x and y and of the torque on body 1."""
        p = self.path
        x = at.x
        b = at.b
        d = at.distance
        angle = at.angle
        area = at.area
        reach = self.reach
        k = arb_of(p.stiffness)
        # The integrals of d x/D and of d b/D over x, d = D0 - D being the overlap.
        pressed_x = reach * d - x * x / 2
        pressed_y = b * (reach * angle - x)
        # The lever of body 1 is R1 - beta D0 + beta D.
        lever = arb_of(p.radii[0] - p.lever * sum(p.radii))
        more = arb_of(p.lever)
        if side:
            rub = -side * arb_of(p.friction) * k
            # The integrals of d b/D, d x/D, d and d D.
            by_b = pressed_y
            by_x = pressed_x
            whole = reach * x - area
            spread = reach * area - (x * x * x / 3 + b * b * x)
        else:
            rub = -arb_of(p.tangential_stiffness)
            c = constant
            g = n["g"]
            a = n["a"]
            e = n["e"]
            # The same of sigma = c + g A + a x + e x D in place of d.
            by_b = b * (c * angle + g * angle * angle / 2 + a * d + e * x * x / 2)
            by_x = c * d + g * (d * angle - x) + a * (x * d - b * b * angle) / 2 + e * x * x * x / 3
            whole = c * x + g * (x * angle - d) + a * x * x / 2 + e * d**3 / 3
            # The integral of A D.
            bent = angle * area - (x * x + b * b * angle * angle) / 4
            spread = c * area + g * bent + a * d**3 / 3 + e * d**4 / 4
        return [
            -k * pressed_x - rub * by_b,
            -k * pressed_y + rub * by_x,
            rub * (lever * whole + more * spread),
        ]

    def evaluate(self, t: arb) -> dict[str, arb]:
        n = self.numbers()
        p = self.path
        x = n["x"] + n["V"] * t
        total = [arb(0)] * 3
        if x > -self.ends():
            pieces = self.pieces()
        else:
            pieces = []
        if not pieces and not x <= -self.ends():
            raise UndecidedError("whether they touch yet")
        for number, piece in enumerate(pieces):
            if number + 1 < len(pieces):
                stop = pieces[number + 1].begin
            else:
                stop = self.ends()
            if x <= piece.begin:
                break
            if not x > piece.begin or not (x <= stop or x > stop):
                raise UndecidedError("in which piece it is")
            last = self.place(stop if x > stop else x)
            first = self.place(piece.begin)
            gained = zip(
                self.given(piece.side, piece.constant, last, n),
                self.given(piece.side, piece.constant, first, n),
                strict=True,
            )
            total = [
                one + (after - before) / n["V"]
                for one, (after, before) in zip(total, gained, strict=True)
            ]
        slack = arb(0, total_bound(p))
        pushed = [
            n["cos"] * total[0] - n["sin"] * total[1] + slack,
            n["sin"] * total[0] + n["cos"] * total[1] + slack,
            arb(0),
        ]
        start = [arb_of(value) for value in p.start]
        seen = {"impulse": pushed, "turning": [arb(0), arb(0), total[2] + slack]}
        seen |= {
            "r": [start[0] + start[2] * t, start[1] + start[3] * t, arb(0)],
            "v": [start[2], start[3], arb(0)],
        }
        return {
            f"{name}.{AXES[i]}": self.turned(vector)[i]
            for name, vector in seen.items()
            for i in range(3)
        }

    def turned(self, vector: list[arb]) -> list[arb]:
        """The vector rotated from the frame of the path to space axes."""
        return [
            sum((arb_of(row[j]) * vector[j] for j in range(3)), arb(0)) for row in self.path.frame
        ]

    @per_precision
    def growth(self) -> Grows:
        """Proved for errors of STATE in the plane at all times, while the masses do not give way:
        what they give is 1e-20 of that.
        """
        return PathGrowth(self)


@dataclass(frozen=True)
class Leg:
    """Part of the motion between two times [s], the last without an end: a piece, or free flight.

    `felt` is what the end makes of an error, in COORDINATES.
    """

    begin: arb
    end: arb | None
    piece: Piece | None
    felt: arb_mat


class PathGrowth:
    """S of a path: errors of place and velocity change the force from then on, and with it all that
    body 1 gets.

    The force is continuous at every switch, so that no error jumps there but that of the way sigma
    of the slip: it begins with 0 at touch, which an error of D moves by -dD/D' in time, and is at
    its limit, which depends on D, where a slide ends. While it slides it is of no use.
    """

    def __init__(self, form: ContactPath) -> None:
        self.form = form
        n = form.numbers()
        self.start = [arb_of(value) for value in form.path.start]
        self.legs = list(self.followed(n))
        self.wholes = [
            leg.felt * self.moved(leg, arb(0), leg.end - leg.begin)
            for leg in self.legs
            if leg.end is not None
        ]

    def at(self, t: Fraction) -> float:
        """The bound S(t) >= 1 on the growth of an error."""
        time = arb_of(t)
        number = self.number(time)
        now = self.legs[number]
        after = self.readings()
        spans = [Span(Fraction(0), upper(time - now.begin), partial(self.own, now, time))]
        after = after * self.moved(now, arb(0), time - now.begin)
        for earlier in reversed(range(number)):
            leg = self.legs[earlier]
            assert leg.end is not None
            answers = partial(self.earlier, leg, after)
            spans.append(Span(Fraction(0), upper(leg.end - leg.begin), answers))
            after = after * self.wholes[earlier]
        return largest_growth(spans)

    def own(
        self, leg: Leg, time: arb, middle: Fraction, off: Fraction
    ) -> tuple[list[arb], list[arb]]:
        """What is answered at a time on the same leg to an error made about `middle` since its
        begin.
        """
        since = arb_of(middle)
        left = time - leg.begin - since
        return self.sums(self.readings() * self.moved(leg, since, left), leg, since, off)

    def earlier(
        self, leg: Leg, after: arb_mat, middle: Fraction, off: Fraction
    ) -> tuple[list[arb], list[arb]]:
        """The same later, where `after` is what follows the leg."""
        assert leg.end is not None
        since = arb_of(middle)
        left = leg.end - leg.begin - since
        return self.sums(after * (leg.felt * self.moved(leg, since, left)), leg, since, off)

    def sums(
        self, answers: arb_mat, leg: Leg, since: arb, off: Fraction
    ) -> tuple[list[arb], list[arb]]:
        """What each quantity answers to errors of one scale in all coordinates of the state: to one
        that has these `answers`, and at most to those that are made at most `off` from it.

        A row y of answers changes as y' = -y A with the time of the error, A being the Jacobian of
        the equations, whose rows of r, v, the way and the impulses follow one from another (mean
        value theorem).
        """
        sizes = [arb_of(self.form.scale[name]) for name in STATE]
        earlier = arb(0, arb_of(off).upper())
        jacobian = self.jacobian(leg, since + earlier)
        seen = []
        bounds = []
        for row in answers.table():
            x, y, u, v, way, *impulses = row
            way_now = way + earlier * pushed(impulses, jacobian, WAY)
            changes = [
                pushed(impulses, jacobian, i) + way_now * jacobian[0][i] for i in range(len(STATE))
            ]
            x_now = x + earlier * changes[0]
            y_now = y + earlier * changes[1]
            u_now = u + earlier * (changes[2] + x_now)
            v_now = v + earlier * (changes[3] + y_now)
            seen.append(sum_of_sizes((x, y, u, v), sizes))
            bounds.append(sum_of_sizes((x_now, y_now, u_now, v_now), sizes))
        return seen, bounds

    def jacobian(self, leg: Leg, since: arb) -> list[tuple[arb, ...]]:
        """The derivatives by (x, y, u, v, way) of the rate of the way, while it sticks, and of the
        force and the torque on body 1, at a ball of times since the begin of a leg.
        """
        if leg.piece is None:
            return [(arb(0),) * 5] * 4
        form = self.form
        p = self.form.path
        time = leg.begin + since
        piece = leg.piece
        here = [*self.place(time), *self.start[2:]]
        held = arb(0)
        if not piece.side:
            n = form.numbers()
            held = piece.constant + form.way(form.place(n["x"] + n["V"] * time))
        x, y, u, v, stretch = parameters([*here, held])
        distance = (x * x + y * y).sqrt()
        overlap = form.reach - distance
        slip = (u * y - v * x) / distance + (
            arb_of(p.radii[1]) - arb_of(p.lever) * overlap
        ) * arb_of(p.spin)
        press = arb_of(p.stiffness) * overlap / distance
        rub = arb_of(p.tangential_stiffness) * stretch
        if piece.side:
            rub = piece.side * arb_of(p.friction * p.stiffness) * overlap
            slip = slip * 0
        along = -press * x + rub * y / distance
        across = -press * y - rub * x / distance
        torque = -rub * (arb_of(p.radii[0]) - arb_of(p.lever) * overlap)
        return [slip.slopes, along.slopes, across.slopes, torque.slopes]

    def number(self, time: arb) -> int:
        """The number of the leg in which a time lies."""
        for number, leg in enumerate(self.legs):
            if leg.end is None or time <= leg.end:
                return number
            if not time > leg.end:
                raise UnsharpError("whether a switch is over")
        raise AssertionError("the last leg has no end")

    def followed(self, n: Mapping[str, Any]) -> Iterator[Leg]:
        """Free flight, every piece, free flight."""
        form = self.form
        pieces = form.pieces()
        times = [(piece.begin - n["x"]) / n["V"] for piece in pieces]
        times.append((form.ends() - n["x"]) / n["V"])
        yield Leg(arb(0), times[0], None, self.way_after(pieces[0], times[0]))
        for piece, after, begin, end in zip(
            pieces, [*pieces[1:], None], times, times[1:], strict=False
        ):
            yield Leg(begin, end, piece, self.way_after(after, end))
        yield Leg(times[-1], None, None, self.way_after(None, times[-1]))

    def way_after(self, piece: Piece | None, time: arb) -> arb_mat:
        """What the begin of a piece at a time makes of an error: that of the way follows from that
        of D, if the piece sticks.
        """
        count = len(COORDINATES)
        rows = [[arb(int(i == j)) for j in range(count)] for i in range(count)]
        rows[WAY][WAY] = arb(0)
        if piece is not None and not piece.side:
            n = self.form.numbers()
            x = n["x"] + n["V"] * time
            distance = self.form.place(x).distance
            held = self.form.constant_side(piece)
            # At touch the way's rate V sigma_x over D' = V x/D, else the limit's slope by D.
            by_distance = self.form.slip(x, 0) * distance / x
            if held:
                by_distance = -held * self.form.slack()
            place = self.place(time)
            for i in range(2):
                rows[WAY][i] = by_distance * place[i] / distance
        return arb_mat(rows)

    def place(self, time: arb) -> list[arb]:
        """The position (2) of body 2 in the plane at a time."""
        x, y, u, v = self.start
        return [x + u * time, y + v * time]

    def moved(self, leg: Leg, since: arb, elapsed: arb) -> arb_mat:
        """What an error of COORDINATES made `since` the begin of a leg has become when so much time
        has elapsed.
        """
        begin = leg.begin + since
        state = parameters([*self.place(begin), *self.start[2:], arb(0)])
        x, y, u, v, way = state
        now: list[Any] = [x + u * elapsed, y + v * elapsed, u, v, way]
        got: list[Any] = [way * 0] * 3
        if leg.piece is not None:
            n = self.form.numbers_from(state[:4])
            first = Place(n["x"], n["b"])
            last = Place(n["x"] + n["V"] * elapsed, n["b"])
            # The constant is known; it changes by what the way does, less what way there is so far.
            changed = way - self.form.way(first, n)
            constant = Sloped(leg.piece.constant, changed.slopes)
            ahead = self.form.given(leg.piece.side, constant, last, n)
            behind = self.form.given(leg.piece.side, constant, first, n)
            along, across, turned = (
                (after - before) / n["V"] for after, before in zip(ahead, behind, strict=True)
            )
            got = [
                n["cos"] * along - n["sin"] * across,
                n["sin"] * along + n["cos"] * across,
                turned,
            ]
            if not leg.piece.side:
                now[WAY] = constant + self.form.way(last, n)
        kept = [[arb(int(i == j)) for j in range(3)] for i in range(3)]
        nothing = [arb(0)] * 3
        rows = [[*one.slopes, *nothing] for one in now]
        rows += [[*one.slopes, *own] for one, own in zip(got, kept, strict=True)]
        return arb_mat(rows)

    def readings(self) -> arb_mat:
        """Every quantity by COORDINATES, in its scale."""
        frame = self.form.path.frame
        scale = self.form.scale
        parts: dict[str, tuple[int | None, ...]] = {
            "r": (0, 1, None),
            "v": (2, 3, None),
            "impulse": (5, 6, None),
            "turning": (None, None, 7),
        }
        rows = []
        for kind, columns in parts.items():
            for i, axis in enumerate(AXES):
                row = [arb(0)] * len(COORDINATES)
                for j, column in enumerate(columns):
                    if column is not None:
                        row[column] = arb_of(frame[i][j] / scale[f"{kind}.{axis}"])
                rows.append(row)
        return arb_mat(rows)


def sum_of_sizes(entries: Sequence[arb], scales: Sequence[arb]) -> arb:
    """The sum over a row of answers, for an error of one scale in every coordinate."""
    terms = (abs(entry) * scale for entry, scale in zip(entries, scales, strict=True))
    return sum(terms, arb(0))


def pushed(impulses: Sequence[arb], jacobian: Sequence[Sequence[arb]], column: int) -> arb:
    """What force and torque change by with a coordinate, as answers to impulses count them."""
    changes = (one * row[column] for one, row in zip(impulses, jacobian[1:], strict=True))
    return sum(changes, arb(0))


def total_bound(p: Passing) -> arb:
    """What masses that give way can change of an impulse: the largest force for the whole time
    moves them, and that changes forces.
    """
    time = 4 * sum(p.radii) / max(abs(p.start[2]), abs(p.start[3]))
    stiff = p.stiffness * (1 + p.friction) + p.tangential_stiffness
    return arb_of(stiff * stiff * sum(p.radii) * time**3 * 100 / p.mass)
