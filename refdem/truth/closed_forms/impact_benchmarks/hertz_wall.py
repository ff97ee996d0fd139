"""A sphere that touches the wall x = 0 from the left under Hertz's law F = k d^(3/2), with sliding
friction of full size: closed form.

The normal motion is that of power_contact. Friction is mu F against the slip s = v_y + R omega
while there is any; with P(t) the normal impulse per mass so far (the fall of v_x), v_y loses mu P
and R omega 5/2 mu P, so that the slip ends at P = 2|s|/(7 mu), if P comes so far, and does not come
back: rolling needs no friction on a wall with the lever R (Maw, Barber and Fawcett 1976 for the
limit).
"""

from collections.abc import Callable, Iterator, Mapping
from copy import copy
from fractions import Fraction
from functools import partial
from typing import Any, Protocol, Self

from flint import arb, arb_mat

from refdem.truth.balls import Guarded, UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.growth import Grows, Growth, Norm, Stretch, most, narrow, smooth
from refdem.truth.line_growth import homogeneous
from refdem.truth.power_contact import PowerContact, touching
from refdem.truth.reals import Number
from refdem.truth.refiner import Refiner, Size
from refdem.truth.smooth_flow import SmoothFlow

HERTZ = Fraction(3, 2)
STATE = ("r.x", "r.y", "v.x", "v.y", "omega.z")
STILL = ("r.z", "v.z", "omega.x", "omega.y")


class AgainstWall(Guarded):
    """The part that all impacts of Hertz's law on a wall share: the start, and the normal motion,
    which no friction changes.
    """

    mass: Number
    radius: Fraction
    stiffness: Number
    friction: Fraction
    begin: tuple[Number, ...]
    kept: dict[Any, Any]

    def strike(
        self,
        *,
        mass: Number,
        radius: Fraction,
        stiffness: Number,
        friction: Fraction,
        normal: Number,
        across: Number,
        spin: Fraction,
    ) -> None:
        """Sets the exact numbers: the sphere touches the wall with the velocity (normal, across)
        and the spin.
        """
        self.mass = mass
        self.radius = radius
        self.stiffness = stiffness
        self.friction = friction
        self.begin = (-radius, Fraction(0), normal, across, spin)

    def displaced(self, axis: int, amount: Fraction) -> Self:
        other = copy(self)
        other.kept = {}
        other.begin = tuple(x + amount * (i == axis) for i, x in enumerate(self.begin))
        return other

    @per_precision
    def contact(self) -> tuple[PowerContact, arb]:
        """The contact, and when it begins."""
        return touching(
            self.mass, self.stiffness, HERTZ, self.begin[0] + self.radius, self.begin[2]
        )

    def slip(self) -> Number:
        """v_y + R omega at the start."""
        return self.begin[3] + self.radius * self.begin[4]

    def slip_size(self) -> Number:
        """|v_y + R omega| at the start."""
        slip = self.slip()
        if slip < 0:
            return -slip
        return slip

    def normal(self, t: arb) -> tuple[arb, arb]:
        """Overlap (negative while apart) and its rate."""
        contact, touch = self.contact()
        since = t - touch
        if since < 0:
            return arb_of(self.begin[0] + self.radius) + arb_of(self.begin[2]) * t, arb_of(
                self.begin[2]
            )
        after = since - 2 * contact.half
        if after >= 0:
            return (-contact.speed * after, -contact.speed)
        return contact.state(since)

    def normal_at(self, t: arb) -> tuple[arb, arb]:
        """Overlap and its rate, also at the ball of times at which the contact ends: about 0, and
        the speed that it began with.
        """
        contact, touch = self.contact()
        beyond = t - touch - 2 * contact.half
        if beyond > 0 or beyond < 0:
            return self.normal(t)
        depth = contact.speed * beyond
        deepest = arb(depth.abs_upper())
        lost = arb_of(self.stiffness / self.mass) * deepest * deepest.sqrt() * beyond
        return depth, -contact.speed + arb(0, lost.abs_upper())


class HertzWallImpact(AgainstWall, ClosedForm, SmoothFlow):
    """Place [m], velocity [m/s] and angular velocity [rad/s] at t >= 0."""

    state = STATE
    method = (
        "closed form: incomplete beta function by 2F1, solved by Newton's rule with a bound;"
        " friction by its impulse"
    )
    witness = "Taylor integration in w = sqrt(overlap), friction by its own law"

    def __init__(
        self,
        scale: Mapping[str, Size],
        *,
        mass: Number,
        radius: Fraction,
        stiffness: Number,
        friction: Fraction,
        normal: Number,
        across: Number,
        spin: Fraction,
    ) -> None:
        self.refiner = Refiner.of(scale)
        self.strike(
            mass=mass,
            radius=radius,
            stiffness=stiffness,
            friction=friction,
            normal=normal,
            across=across,
            spin=spin,
        )

    @per_precision
    def growth(self) -> Grows:
        rows = Norm([1] * len(STATE))
        return Growth(self.stretches(), rows, step=narrow(1 / self.contact()[0].half))

    def stretches(self) -> Iterator[Stretch]:
        """Free, sliding, rolling, free; errors of STATE in scales.

        Along the normal by scaling. Friction, mu times the normal force, hands on what the normal
        velocity loses: an error of v_x or x comes to v_y and y times mu, to omega times 5 mu/(2 R).
        Where the slip ends, and at once for every error that is made while the sphere rolls under
        pressure, v_y loses 2/7 of the slip and omega 5/7 of it over R.
        """
        contact, touch = self.contact()
        parted = touch + 2 * contact.half
        stop = self.stop()
        slides = bool(self.friction and self.slip())
        held = self.scaled_errors(self.held())
        if touch > 0:
            free = not (self.friction and not slides)
            yield smooth(arb(0), touch, self.errors(0), jump=None if free else held)
            begin = touch
        else:
            begin = arb(0)
        if not self.friction:
            yield smooth(
                begin, None, partial(self.later, self.errors(0), begin), quickness=self.quick
            )
            return
        if slides and stop is None:
            yield smooth(
                begin,
                parted - begin,
                partial(self.later, self.errors(1), begin),
                quickness=self.quick,
            )
        else:
            if slides:
                assert stop is not None
                yield smooth(
                    begin,
                    stop[1] - begin,
                    partial(self.later, self.errors(1), begin),
                    jump=held,
                    quickness=self.quick,
                )
                begin = stop[1]
            rolling = partial(self.later, self.errors(0), begin)
            yield smooth(begin, parted - begin, rolling, felt=held, quickness=self.quick)
        yield smooth(
            parted, None, partial(self.later, self.errors(0), parted), quickness=self.quick
        )

    def quick(self, t: arb) -> float:
        """Bound of the norm of the field's Jacobian in scales."""
        contact, _ = self.contact()
        steepest = (
            arb_of(HERTZ * self.stiffness / self.mass)
            * contact.depth.sqrt()
            * arb_of(self.scale["r.x"])
        )
        rub = arb_of(self.friction)
        rates = [steepest / arb_of(self.scale["v.x"]), rub * steepest / arb_of(self.scale["v.y"])]
        rates.append(
            rub * steepest * arb_of(Fraction(5, 2) / self.radius) / arb_of(self.scale["omega.z"])
        )
        rates += [
            arb_of(self.scale["v.x"] / self.scale["r.x"]),
            arb_of(self.scale["v.y"] / self.scale["r.y"]),
        ]
        return most(rates)

    def errors(self, rubs: int) -> Callable[[arb], arb_mat]:
        """Five independent errors, as columns, by the time since the start: two of the normal
        motion, y, v_y and omega.
        """
        _, touch = self.contact()
        stiffness = arb_of(self.stiffness / self.mass)
        power = arb_of(Fraction(2) / (HERTZ + 1))
        side = (self.slip() > 0) - (self.slip() < 0)
        push = arb_of(self.friction * side * rubs)
        turn = push * arb_of(Fraction(5, 2) / self.radius)
        none = arb(0)
        one = arb(1)

        def found(t: arb) -> arb_mat:
            depth, rate = self.normal_at(t)
            if depth > 0:
                force = -stiffness * depth * depth.sqrt()
            else:
                force = none
            (x1, x2), (v1, v2) = homogeneous(depth, rate, force, t - touch, power, one).table()
            row_x = [x1, x2, none, none, none]
            row_y = [push * x1, push * x2, one, t, none]
            row_vx = [v1, v2, none, none, none]
            row_vy = [push * v1, push * v2, none, one, none]
            row_omega = [turn * v1, turn * v2, none, none, one]
            rows = [row_x, row_y, row_vx, row_vy, row_omega]
            return arb_mat(
                [
                    [entry / arb_of(self.scale[name]) for entry in row]
                    for name, row in zip(STATE, rows, strict=True)
                ]
            )

        return found

    @staticmethod
    def later(errors: Callable[[arb], arb_mat], begin: arb, since: arb) -> arb_mat:
        """The same by the time since another."""
        return errors(begin + since)

    def held(self) -> list[list[arb]]:
        """What the end of the slip does to an error."""
        rows = [[arb(int(i == j)) for j in range(5)] for i in range(5)]
        radius = arb_of(self.radius)
        rows[3][3], rows[3][4] = arb_of(Fraction(5, 7)), -arb_of(Fraction(2, 7)) * radius
        rows[4][3], rows[4][4] = -arb_of(Fraction(5, 7)) / radius, arb_of(Fraction(2, 7))
        return rows

    def scaled_errors(self, rows: list[list[arb]]) -> arb_mat:
        """A matrix from errors to errors in scales."""
        sizes = [arb_of(self.scale[name]) for name in STATE]
        return arb_mat(
            [
                [entry * own / size for entry, own in zip(row, sizes, strict=True)]
                for row, size in zip(rows, sizes, strict=True)
            ]
        )

    @per_precision
    def stop(self) -> tuple[arb, arb] | None:
        """Overlap and time at the end of the slip; None if it does not end."""
        contact, touch = self.contact()
        if not self.friction or not self.slip():
            return None
        s = (
            arb_of(self.begin[2]) - arb_of(Fraction(2, 7) * self.slip_size() / self.friction)
        ) / contact.speed
        if s < -1:
            return None
        if not s > -1:
            raise UndecidedError("whether the slip ends before the contact does")
        return contact.depth * (
            1 - s * s
        ) ** contact.a, touch + contact.half - contact.unit * contact.before_turn(s)

    def evaluate(self, t: arb) -> dict[str, arb]:
        x, y, vx, vy, spin = (arb_of(value) for value in self.begin)
        depth, rate = self.normal(t)
        side = (self.slip() > 0) - (self.slip() < 0)
        push = arb_of(self.friction * side)
        end = self.stop()
        if end is not None and not (t < end[1] or t > end[1]):
            raise UndecidedError("whether it slips still")
        way = vx * t - (depth - (x + arb_of(self.radius)))
        impulse = vx - rate
        rest = arb(0)
        if end is not None and t > end[1]:
            impulse = arb_of(Fraction(2, 7) * self.slip_size() / self.friction)
            way = vx * end[1] - (end[0] - (x + arb_of(self.radius)))
            rest = impulse * (t - end[1])
        now = (
            depth - arb_of(self.radius),
            y + vy * t - push * (way + rest),
            rate,
            vy - push * impulse,
        )
        turned = spin - push * impulse * arb_of(Fraction(5, 2) / self.radius)
        return dict(zip((*STATE, *STILL), (*now, turned, *(arb(0),) * 4), strict=True))

    def constants(self) -> dict[str, arb]:
        return impact_constants(self)


class Impact(Protocol):
    """What the scalars of an impact are found from."""

    stiffness: Number

    def contact(self) -> tuple[PowerContact, arb]: ...

    def evaluate(self, t: arb) -> dict[str, arb]: ...


def impact_constants(impact: Impact) -> dict[str, arb]:
    """How long it lasts, its largest overlap and force, and with what it leaves."""
    contact, touch = impact.contact()
    deepest = contact.depth
    last = impact.evaluate(touch + 3 * contact.half)
    return {
        "duration": 2 * contact.half,
        "max_overlap": deepest,
        "max_force": arb_of(impact.stiffness) * deepest * deepest.sqrt(),
        "rebound_across": last["v.y"],
        "rebound_spin": last["omega.z"],
    }
