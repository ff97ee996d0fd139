"""A sphere that touches the wall x = 0 from the left under Hertz's law F = k d^(3/2), with sliding
friction of full size: closed form.

The normal motion, m d'' = -k d^(3/2) with the overlap d = x + R, is that of power_contact. Friction
is mu F against the slip s = v_y + R omega while there is any; with P(t) = v_x(0) - v_x(t) the
normal impulse per mass so far,

    v_y = v_y(0) - side mu P,    R omega = R omega(0) - side 5/2 mu P,

side being the sign of the slip at the start. So the slip ends at P = 2|s|/(7 mu), if P comes so
far, and does not come back: rolling needs no friction on a wall with the lever R (Maw, Barber and
Fawcett 1976 for the limit).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from typing import Any, Protocol, Self

from flint import arb, arb_mat

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.closed_form import ClosedForm, displaced_part, larger, per_precision
from refdem.truth.exact import sign_of
from refdem.truth.growth import Grows, Growth, Norm, Stretch, between_scales, most, narrow, smooth
from refdem.truth.line_growth import homogeneous
from refdem.truth.power_contact import PowerContact, touching
from refdem.truth.reals import Number
from refdem.truth.smooth_flow import derivative_by_start

HERTZ = Fraction(3, 2)
STATE = ("r.x", "r.y", "v.x", "v.y", "omega.z")
STILL = ("r.z", "v.z", "omega.x", "omega.y")


@dataclass(frozen=True, kw_only=True)
class Strike:
    """A sphere that strikes a wall under Hertz's law: the start, and the normal motion, which no
    friction changes.

    `begin` is (x, y, v_x, v_y, omega) at t = 0.
    """

    mass: Number
    radius: Fraction
    stiffness: Number
    friction: Fraction
    begin: tuple[Number, ...]
    kept: dict[Any, Any] = field(default_factory=dict, init=False, compare=False, repr=False)

    def displaced(self, axis: int, amount: Fraction) -> Self:
        """The strike from a start whose coordinate `axis` is larger by exactly `amount`."""
        return replace(self, begin=larger(self.begin, axis, amount))

    @per_precision
    def contact(self) -> tuple[PowerContact, arb]:
        """The contact, and the time [s] at which it begins."""
        return touching(
            self.mass, self.stiffness, HERTZ, self.begin[0] + self.radius, self.begin[2]
        )

    def slip(self) -> Number:
        """v_y + R omega at the start."""
        slip: Number = self.begin[3] + self.radius * self.begin[4]
        return slip

    def slip_size(self) -> Number:
        """|v_y + R omega| at the start."""
        slip = self.slip()
        if slip < 0:
            return -slip
        return slip

    def normal(self, t: arb) -> tuple[arb, arb]:
        """The overlap d [m], negative while apart, and its rate d' = v_x [m/s] at time t."""
        contact, touch = self.contact()
        since_touch = t - touch
        if since_touch < 0:
            overlap = arb_of(self.begin[0] + self.radius)
            rate = arb_of(self.begin[2])
            return overlap + rate * t, rate
        # `half` is the time from touch to the largest overlap.
        since_end = since_touch - 2 * contact.half
        if since_end >= 0:
            return (-contact.speed * since_end, -contact.speed)
        return contact.state(since_touch)

    def normal_at(self, t: arb) -> tuple[arb, arb]:
        """The overlap and its rate, also at a ball of times that holds the end of the contact.

        There d is at most the speed v at touch times the distance in time from the end, and d'
        differs from -v by at most (k/m) d^(3/2) times that distance.
        """
        contact, touch = self.contact()
        since_end = t - touch - 2 * contact.half
        if since_end > 0 or since_end < 0:
            return self.normal(t)
        overlap = contact.speed * since_end
        largest = arb(overlap.abs_upper())
        rate_change = arb_of(self.stiffness / self.mass) * largest * largest.sqrt() * since_end
        return overlap, -contact.speed + arb(0, rate_change.abs_upper())


def touching_sphere(
    *, normal: Number, across: Number, spin: Fraction, radius: Fraction, **numbers: Any
) -> Strike:
    """A sphere that touches the wall at t = 0 with the velocity (normal, across) and the spin."""
    begin = (-radius, Fraction(0), normal, across, spin)
    return Strike(radius=radius, begin=begin, **numbers)


@dataclass(frozen=True)
class HertzWallImpact(ClosedForm):
    """The truth of an impact: position [m], velocity [m/s], angular velocity [rad/s] at t >= 0."""

    state = STATE
    method = (
        "closed form: incomplete beta function by 2F1, solved by Newton's rule with a bound;"
        " friction by its impulse"
    )
    witness = "Taylor integration in w = sqrt(overlap), friction by its own law"

    strike: Strike

    displaced = displaced_part("strike")
    jacobian = derivative_by_start

    @per_precision
    def growth(self) -> Grows:
        """How errors of STATE grow, from the stretches below."""
        rows = Norm([1] * len(STATE))
        return Growth(self.stretches(), rows, step=narrow(1 / self.strike.contact()[0].half))

    def stretches(self) -> Iterator[Stretch]:
        """The stretches of time along which errors of STATE grow smoothly, in scales.

        Free flight, sliding, rolling, free flight. Along the normal errors grow by scaling.
        Friction, mu times the normal force, hands on what the normal velocity loses: an error of
        v_x or x comes to v_y and y times mu, to omega times 5 mu/(2 R). Where the slip ends, and at
        once for every error that is made while the sphere rolls under pressure, v_y loses 2/7 of
        the slip and omega 5/7 of it over R (`held`).
        """
        contact, touch = self.strike.contact()
        parted = touch + 2 * contact.half
        stop = self.stop()
        slides = bool(self.strike.friction and self.strike.slip())
        held = self.scaled_errors(self.held())
        if touch > 0:
            # With friction and no slip an error of the slip is held at touch.
            if self.strike.friction and not slides:
                jump = held
            else:
                jump = None
            yield smooth(arb(0), touch, self.errors(0), jump=jump)
            begin = touch
        else:
            begin = arb(0)
        if not self.strike.friction:
            free = partial(self.later, self.errors(0), begin)
            yield smooth(begin, None, free, quickness=self.quick)
            return
        sliding = partial(self.later, self.errors(1), begin)
        if slides and stop is None:
            yield smooth(begin, parted - begin, sliding, quickness=self.quick)
        else:
            if slides:
                assert stop is not None
                _, stop_time = stop
                yield smooth(begin, stop_time - begin, sliding, jump=held, quickness=self.quick)
                begin = stop_time
            rolling = partial(self.later, self.errors(0), begin)
            yield smooth(begin, parted - begin, rolling, instant_map=held, quickness=self.quick)
        free = partial(self.later, self.errors(0), parted)
        yield smooth(parted, None, free, quickness=self.quick)

    def quick(self, t: arb) -> float:
        """A bound of the norm of the field's Jacobian, in scales, at all times.

        The largest row sum: the force per mass has the slope (3/2)(k/m) sqrt(d) by x, friction mu
        and its torque 5 mu/(2 R) of that; positions change with velocities.
        """
        contact, _ = self.strike.contact()
        slope = (
            arb_of(HERTZ * self.strike.stiffness / self.strike.mass)
            * contact.depth.sqrt()
            * arb_of(self.scale["r.x"])
        )
        mu = arb_of(self.strike.friction)
        turning = mu * slope * arb_of(Fraction(5, 2) / self.strike.radius)
        row_sums = [
            slope / arb_of(self.scale["v.x"]),
            mu * slope / arb_of(self.scale["v.y"]),
            turning / arb_of(self.scale["omega.z"]),
            arb_of(self.scale["v.x"] / self.scale["r.x"]),
            arb_of(self.scale["v.y"] / self.scale["r.y"]),
        ]
        return most(row_sums)

    def errors(self, slides: int) -> Callable[[arb], arb_mat]:
        """Five independent errors of STATE, as columns in scales, as a function of time [s].

        Two of the normal motion with what friction makes of them while it slides (`slides` is 1,
        else 0), one each of y, v_y and omega.
        """
        _, touch = self.strike.contact()
        k_over_m = arb_of(self.strike.stiffness / self.strike.mass)
        # The overlap goes with the speed at touch to the power 2/(n + 1).
        power = arb_of(Fraction(2) / (HERTZ + 1))
        side = sign_of(self.strike.slip())
        mu = arb_of(self.strike.friction * side * slides)
        mu_turn = mu * arb_of(Fraction(5, 2) / self.strike.radius)
        zero = arb(0)
        one = arb(1)

        def columns(t: arb) -> arb_mat:
            overlap, rate = self.strike.normal_at(t)
            if overlap > 0:
                acceleration = -k_over_m * overlap * overlap.sqrt()
            else:
                acceleration = zero
            normal = homogeneous(overlap, rate, acceleration, t - touch, power, one)
            (x1, x2), (v1, v2) = normal.table()
            row_x = [x1, x2, zero, zero, zero]
            row_y = [mu * x1, mu * x2, one, t, zero]
            row_vx = [v1, v2, zero, zero, zero]
            row_vy = [mu * v1, mu * v2, zero, one, zero]
            row_omega = [mu_turn * v1, mu_turn * v2, zero, zero, one]
            rows = [row_x, row_y, row_vx, row_vy, row_omega]
            return arb_mat(
                [
                    [entry / arb_of(self.scale[name]) for entry in row]
                    for name, row in zip(STATE, rows, strict=True)
                ]
            )

        return columns

    @staticmethod
    def later(errors: Callable[[arb], arb_mat], begin: arb, since: arb) -> arb_mat:
        """The errors at the time `since` [s] after another, `begin`."""
        return errors(begin + since)

    def held(self) -> list[list[arb]]:
        """The matrix that maps an error of STATE across the end of the slip, which is 0 after it.

        v_y loses 2/7 of the slip v_y + R omega and omega 5/7 of it over R.
        """
        rows = [[arb(int(i == j)) for j in range(5)] for i in range(5)]
        radius = arb_of(self.strike.radius)
        rows[3][3] = arb_of(Fraction(5, 7))
        rows[3][4] = -arb_of(Fraction(2, 7)) * radius
        rows[4][3] = -arb_of(Fraction(5, 7)) / radius
        rows[4][4] = arb_of(Fraction(2, 7))
        return rows

    def scaled_errors(self, rows: list[list[arb]]) -> arb_mat:
        """The matrix between errors of STATE that has these rows, between errors in scales."""
        return between_scales(rows, [arb_of(self.scale[name]) for name in STATE])

    @per_precision
    def stop(self) -> tuple[arb, arb] | None:
        """The overlap [m] and the time [s] at the end of the slip; None if it does not end.

        It ends at P = 2|s|/(7 mu), where u = d'/v = (v_x(0) - P)/v with v the speed at touch; then
        d = d_m (1 - u^2)^a by the energy. Raises UndecidedError if balls do not separate that point
        from the end of the contact.
        """
        contact, touch = self.strike.contact()
        if not self.strike.friction or not self.strike.slip():
            return None
        impulse = arb_of(Fraction(2, 7) * self.strike.slip_size() / self.strike.friction)
        u = (arb_of(self.strike.begin[2]) - impulse) / contact.speed
        if u < -1:
            return None
        if not u > -1:
            raise UndecidedError("whether the slip ends before the contact does")
        overlap = contact.depth * (1 - u * u) ** contact.a
        time = touch + contact.half - contact.unit * contact.before_turn(u)
        return overlap, time

    def evaluate(self, t: arb) -> dict[str, arb]:
        """STATE at time t, and zeros for the other components.

        y = y(0) + v_y(0) t - side mu I, where I is the integral of the impulse P = v_x(0) - v_x,
        v_x(0) t - (d - d(0)); from the end of the slip on the P of friction is constant.
        """
        x, y, vx, vy, spin = (arb_of(value) for value in self.strike.begin)
        overlap, rate = self.strike.normal(t)
        side = sign_of(self.strike.slip())
        mu = arb_of(self.strike.friction * side)
        stop = self.stop()
        first_overlap = x + arb_of(self.strike.radius)
        impulse = vx - rate
        integral = vx * t - (overlap - first_overlap)
        after_stop = arb(0)
        if stop is not None:
            stop_overlap, stop_time = stop
            if not (t < stop_time or t > stop_time):
                raise UndecidedError("whether it slides still")
            if t > stop_time:
                impulse = arb_of(Fraction(2, 7) * self.strike.slip_size() / self.strike.friction)
                integral = vx * stop_time - (stop_overlap - first_overlap)
                after_stop = impulse * (t - stop_time)
        position_x = overlap - arb_of(self.strike.radius)
        position_y = y + vy * t - mu * (integral + after_stop)
        velocity_y = vy - mu * impulse
        omega = spin - mu * impulse * arb_of(Fraction(5, 2) / self.strike.radius)
        state = (position_x, position_y, rate, velocity_y, omega)
        return dict(zip((*STATE, *STILL), (*state, *(arb(0),) * 4), strict=True))

    def constants(self) -> dict[str, arb]:
        """The scalars of an impact, see `impact_constants`."""
        return impact_constants(self)


class Impact(Protocol):
    """An impact on a wall, as far as its scalars are computed from it."""

    @property
    def strike(self) -> Strike: ...

    def evaluate(self, t: arb) -> dict[str, arb]: ...


def impact_constants(impact: Impact) -> dict[str, arb]:
    """The scalars: duration [s], largest overlap [m] and force [N], rebounding v_y and omega."""
    contact, touch = impact.strike.contact()
    max_overlap = contact.depth
    # Half a duration after the end of the contact, where nothing changes any more.
    rebound = impact.evaluate(touch + 3 * contact.half)
    return {
        "duration": 2 * contact.half,
        "max_overlap": max_overlap,
        "max_force": arb_of(impact.strike.stiffness) * max_overlap * max_overlap.sqrt(),
        "rebound_across": rebound["v.y"],
        "rebound_spin": rebound["omega.z"],
    }
