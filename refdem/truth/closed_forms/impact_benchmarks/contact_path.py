"""Two spheres so heavy that they pass each other on a prescribed straight path, overlapping for a
while: what the linear law gives them.

In the plane of the path body 1 rests at the origin and body 2 is at (x, b), x = x0 + V t, with the
constant spin w2: D^2 = x^2 + b^2, overlap d = D0 - D, A = asinh(x/b). The slip V b/D + l2 w2 with
the lever l2 = R2 - beta d has the way sigma = C + g A + a x + e x D, and with forces k d along n =
(x, b)/D and k_t sigma, or mu k d, along (-b, x)/D all impulses and turning impulses are integrals
of A, x and D in closed form. Where the spring comes to its limit, and where it is caught, is proved
by bisection and interval Newton. The masses are finite and give way by less than 1e-20 of the
overlap, which the radii contain.
"""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Self

from flint import arb, arb_mat

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import DISPLACEMENT, ClosedForm, Size, per_precision
from refdem.truth.events.crossing import Along, SwitchError, Watched, earliest
from refdem.truth.growth import DIFFERENCE_BITS, FromTheStart, Grows

AXES = "xyz"
STATE = ("r.x", "r.y", "v.x", "v.y")
Matrix = tuple[tuple[Fraction, ...], ...]


@dataclass(frozen=True, kw_only=True)
class Passing:
    """Exact numbers in SI units;

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
    """x, D, A, and powers of them that integrals need."""

    x: arb
    b: arb

    @property
    def distance(self) -> arb:
        """D."""
        found: arb = (self.x * self.x + self.b * self.b).sqrt()
        return found

    @property
    def angle(self) -> arb:
        """A."""
        found: arb = (self.x / self.b).asinh()
        return found

    @property
    def area(self) -> arb:
        """The integral of D over x."""
        return (self.x * self.distance + self.b * self.b * self.angle) / 2


@dataclass(frozen=True)
class Piece:
    """From x on: sticking with the constant C of the way, or sliding to one side."""

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
        super().__init__(scale)
        self.path = path

    def displaced(self, axis: int, amount: Fraction) -> Self:
        other = copy(self)
        start = tuple(x + amount * (i == axis) for i, x in enumerate(self.path.start))
        other.kept = {}
        other.path = Passing(**{**vars(self.path), "start": start})
        return other

    @per_precision
    def numbers(self) -> dict[str, arb]:
        """Of the path: b, x at the start, V along x, and the coefficients g, a, e of the slip's
        way.
        """
        p = self.path
        (x, y, u, v) = [arb_of(value) for value in self.path.start]
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
        """D0."""
        return arb_of(sum(self.path.radii, Fraction(0)))

    def place(self, x: arb) -> Place:
        """The place at x."""
        return Place(x, self.numbers()["b"])

    def ends(self) -> arb:
        """The x > 0 at which they part."""
        found: arb = (self.reach * self.reach - self.numbers()["b"] ** 2).sqrt()
        return found

    def way(self, at: Place) -> arb:
        """sigma without its constant."""
        n = self.numbers()
        return n["g"] * at.angle + n["a"] * at.x + n["e"] * at.x * at.distance

    def limit(self, x: arb, order: int) -> arb:
        """mu k d / k_t and its derivatives by x."""
        at = self.place(x)
        p = self.path
        size = arb_of(p.friction * p.stiffness / p.tangential_stiffness)
        distance = at.distance
        return size * (self.reach - distance, -at.x / distance, -at.b * at.b / distance**3)[order]

    def slip(self, x: arb, order: int) -> arb:
        """Derivatives of sigma by x, from the first on."""
        at = self.place(x)
        n = self.numbers()
        distance = at.distance
        return (
            at.b / distance + n["a"] + 2 * n["e"] * distance,
            -at.b * x / distance**3 + 2 * n["e"] * x / distance,
        )[order]

    def spared(self, piece: Piece, side: int, order: int, x: arb) -> arb:
        """A derivative by x of what the spring has left towards a side."""
        if order == 0:
            held = piece.constant + self.way(self.place(x))
        else:
            held = self.slip(x, order - 1)
        return self.limit(x, order) - side * held

    def surplus(self, side: int, order: int, x: arb) -> arb:
        """By how much a clipped spring would outgrow its limit."""
        return side * self.slip(x, order) - self.limit(x, order + 1)

    @per_precision
    def pieces(self) -> list[Piece]:
        """Every piece from touch on."""
        x = -self.ends()
        end = self.ends()
        slip = self.slip(x, 0)
        if not (slip > 0 or slip < 0):
            raise UndecidedError("the direction of the slip at touch")
        if slip > 0:
            side = 1
        else:
            side = -1
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

    def after(self, last: Piece, touching: Mapping[int, int], end: arb) -> Piece | None:
        """What follows a piece."""
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

    def given(self, piece: Piece, x: arb) -> list[arb]:
        """Antiderivatives by x of the force's parts along x and y and of the torque on body 1."""
        p = self.path
        n = self.numbers()
        at = self.place(x)
        b = at.b
        d = at.distance
        angle = at.angle
        area = at.area
        reach = self.reach
        k = arb_of(p.stiffness)
        kt = arb_of(p.tangential_stiffness)
        pressed = reach * d - x * x / 2, b * (reach * angle - x)
        lever = arb_of(p.radii[0] - p.lever * sum(p.radii))
        more = arb_of(p.lever)
        if piece.side:
            rub = -piece.side * arb_of(p.friction) * k
            by_b = pressed[1]
            by_x = pressed[0]
            whole = reach * x - area
            spread = reach * area - (x**3 / 3 + b * b * x)
        else:
            rub = -kt
            c = piece.constant
            g = n["g"]
            a = n["a"]
            e = n["e"]
            by_b = b * (c * angle + g * angle * angle / 2 + a * d + e * x * x / 2)
            by_x = c * d + g * (d * angle - x) + a * (x * d - b * b * angle) / 2 + e * x**3 / 3
            whole = c * x + g * (x * angle - d) + a * x * x / 2 + e * d**3 / 3
            bent = angle * area - (x * x + b * b * angle * angle) / 4
            spread = c * area + g * bent + a * d**3 / 3 + e * d**4 / 4
        return [
            -k * pressed[0] - rub * by_b,
            -k * pressed[1] + rub * by_x,
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
            gained = zip(
                self.given(piece, stop if x > stop else x),
                self.given(piece, piece.begin),
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
        """From the frame of the path to space."""
        return [
            sum((arb_of(row[j]) * vector[j] for j in range(3)), arb(0)) for row in self.path.frame
        ]

    @per_precision
    def growth(self) -> Grows:
        """From errors of the start alone: those of the path that are made later act upon less of
        the contact.
        """
        return FromTheStart(self.jacobian)

    def jacobian(self, t: Fraction) -> arb_mat:
        """d quantity_i(t)/scale_i over d start_j/scale_j by central differences."""
        pairs = [self.pair(axis) for axis in range(len(self.state))]
        states = [(plus.evaluate(arb_of(t)), minus.evaluate(arb_of(t))) for plus, minus in pairs]
        twice = arb_of(2 * DISPLACEMENT)
        return arb_mat(
            [
                [
                    (plus[name] - minus[name]) / twice / arb_of(self.scale[name])
                    for plus, minus in states
                ]
                for name in states[0][0]
            ]
        )

    def growth_bits(self) -> Sequence[int]:
        return DIFFERENCE_BITS


def total_bound(p: Passing) -> arb:
    """What masses that give way can change of an impulse: the largest force for the whole time
    moves them, and that changes forces.
    """
    time = 4 * sum(p.radii) / max(abs(p.start[2]), abs(p.start[3]))
    stiff = p.stiffness * (1 + p.friction) + p.tangential_stiffness
    return arb_of(stiff * stiff * sum(p.radii) * time**3 * 100 / p.mass)
