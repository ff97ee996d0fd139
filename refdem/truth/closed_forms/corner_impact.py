"""Certified impact of a box's corner on a smooth plane: uniform motion, one impulse, and uniform
motion with a constant angular velocity.

Notation: (x, y), (vx, vy) of the centre, theta the angle and omega the angular velocity. The lowest
corner has the arm (p, -d) from the centre, d(theta) being (a sin theta + b cos theta)/2, and p =
-d'. It touches where y = d, closes with c = -(vy + omega p), and the impulse is

    J = (1 + e) c/(1/m + p^2/I),   vy += J/m,   omega += p J/I.

No second corner: at s after the impact a corner with the arm (q, z) is at least g + u s - R omega^2
s^2/2 above the plane, where g = y + z, u = vy + omega q, and R is its distance from the centre (the
theorem of Taylor; nothing else accelerates it). Once the centre is above R, and rises, none can
touch at all.

S: an error moves the time of the impact by dt = n/c, n = (1, p) in (y, theta) being the derivative
of the gap. So the derivative across it is DP (1 + f- dt) - f+ dt, P being the map of the impulse
and f = (vx, vy, 0, 0, omega, 0) (Aizerman and Gantmacher 1958); DP has dp/dtheta = d.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import UndecidedError, arb_of, unit_matrix
from refdem.truth.closed_form import ClosedForm, displaced_tuple, per_precision
from refdem.truth.exact import number, vector
from refdem.truth.growth import Grows, Growth, Norm, Stretch, between_scales, narrow, smooth
from refdem.truth.refiner import Refiner

X, Y, VX, VY, THETA, OMEGA = range(6)
"""Indices of the coordinates in the state."""
AROUND = Fraction(1, 2**20)
"""Part of a time around it in which Newton's rule proves the one zero."""
STEPS = 12
"""Steps of Newton's rule, each of which doubles the digits."""


@dataclass(frozen=True, kw_only=True)
class Box:
    """Mass [kg], sides a, b [m], and the restitution of its corners."""

    mass: Fraction
    sides: tuple[Fraction, ...]
    restitution: Fraction

    @property
    def inertia(self) -> Fraction:
        """I = m (a^2 + b^2)/12 [kg m^2]."""
        a, b = self.sides
        return self.mass * (a * a + b * b) / 12

    def arm(self, angle: arb) -> tuple[arb, arb]:
        """p and d [m]: the lowest corner is at (p, -d) from the centre."""
        half_a, half_b = (arb_of(side / 2) for side in self.sides)
        sine, cosine = angle.sin_cos()
        # d = (a sin theta + b cos theta)/2, p = -d'(theta).
        return half_b * sine - half_a * cosine, half_a * sine + half_b * cosine

    def corners(self, angle: arb) -> Iterator[tuple[arb, arb]]:
        """The arms (q, z) [m] of the other three corners."""
        half_a, half_b = (arb_of(side / 2) for side in self.sides)
        sine, cosine = angle.sin_cos()
        for i, j in ((-1, 1), (1, -1), (1, 1)):
            along = i * half_a
            across = j * half_b
            # (i a/2, j b/2) turned by theta; (-1, -1) is the lowest corner.
            yield along * cosine - across * sine, along * sine + across * cosine


@dataclass(frozen=True)
class Touch:
    """The impact: its time [s], the states (6,) before and after it, the arm (p, d), the closing
    speed [m/s] and the impulse [N s].
    """

    time: arb
    before: list[arb]
    after: list[arb]
    p: arb
    d: arb
    closing: arb
    impulse: arb


@dataclass(frozen=True)
class CornerImpact(ClosedForm):
    """x, y [m], vx, vy [m/s], theta [rad] and omega [rad/s] of a box."""

    state = ("x", "y", "vx", "vy", "theta", "omega")
    method = "time of impact and impulse in closed form, turn at a constant rate"
    witness = (
        "balance equations of body and contact by elimination, time of impact by bisection"
        " (refdem/truth/witnesses/corner_impact.py)"
    )

    body: Box
    begin: tuple[Fraction, ...]

    displaced = displaced_tuple("begin")

    def flown(self, state: list[arb], t: arb) -> list[arb]:
        """The state after a flight of t [s]."""
        x, y, vx, vy, theta, omega = state
        return [x + vx * t, y + vy * t, vx, vy, theta + omega * t, omega]

    def starts(self) -> list[arb]:
        """The state in balls at the start."""
        return [arb_of(number) for number in self.begin]

    @per_precision
    def touch(self) -> Touch:
        """The impact, with the states on both sides of it."""
        time = self.impact_time()
        before = self.flown(self.starts(), time)
        p, d = self.body.arm(before[THETA])
        # c = -(vy + omega p),  J = (1 + e) c/(1/m + p^2/I),  vy += J/m,  omega += p J/I
        closing = -(before[VY] + before[OMEGA] * p)
        if not closing > 0:
            raise UndecidedError("the corner does not come nearer to the plane", code="grazing")
        impulse = arb_of(1 + self.body.restitution) * closing / self.ease(p)
        after = list(before)
        after[VY] += impulse / arb_of(self.body.mass)
        after[OMEGA] += p * impulse / arb_of(self.body.inertia)
        return Touch(time, before, after, p, d, closing, impulse)

    def ease(self, p: arb) -> arb:
        """1/m + p^2/I [1/kg]: the velocity that a unit impulse gives to the corner."""
        return 1 / arb_of(self.body.mass) + p * p / arb_of(self.body.inertia)

    def impact_time(self) -> arb:
        """The root t [s] of y = d: explicit for omega = 0, otherwise by interval Newton.

        If m - gap(m)/gap'(T) lies inside the interval T, for a point m of T, then the gap y - d has
        exactly one zero in T, and it lies in that image.
        """
        start = self.starts()
        _, d = self.body.arm(start[THETA])
        # y + vy t = d for a constant d.
        middle = (d - start[Y]) / start[VY]
        if self.begin[OMEGA] == 0:
            return middle
        for _ in range(STEPS):
            middle = self.newton(middle.mid(), middle.mid())
        around = middle.mid() * (1 + arb_of(AROUND) * arb(0, 1))
        newer = self.newton(around.mid(), around)
        if not around.contains_interior(newer):
            raise UndecidedError("the time of the impact", code="precision")
        for _ in range(STEPS):
            newer = newer.intersection(self.newton(newer.mid(), newer))
        return newer

    def newton(self, middle: arb, around: arb) -> arb:
        """m - gap(m)/gap'(T) [s], the gap being y - d."""
        # gap = y - d and gap' = vy + omega p, as p = -d'(theta).
        start = self.starts()
        then = self.flown(start, middle)
        _, d = self.body.arm(then[THETA])
        p, _ = self.body.arm(self.flown(start, around)[THETA])
        return middle - (then[Y] - d) / (start[VY] + start[OMEGA] * p)

    def evaluate(self, t: arb) -> dict[str, arb]:
        """All quantities at t, before the impact or after it."""
        if t < 0:
            raise NotCertifiedError("corner-impact: t < 0 is before the start")
        return dict(zip(self.state, self.at_time(t), strict=True))

    def at_time(self, t: arb) -> list[arb]:
        """The state at t; UndecidedError at the impact, and where a second corner may touch."""
        touch = self.touch()
        since = t - touch.time
        if since < 0:
            return self.flown(self.starts(), t)
        if not since > 0:
            raise UndecidedError(f"whether the corner has touched at {t}")
        self.refuse_second(touch, since)
        return self.flown(touch.after, since)

    def refuse_second(self, touch: Touch, since: arb) -> None:
        """Raises UndecidedError unless no corner can have come down by `since` [s] after the
        impact.
        """
        half_a, half_b = (arb_of(side / 2) for side in self.body.sides)
        radius = (half_a * half_a + half_b * half_b).sqrt()
        _, y, _, rise, theta, omega = touch.after
        until = since
        if rise > 0:
            # After this time y > R: no corner can reach the plane.
            until = since.min((radius - y) / rise)
        # Each bound is concave in s, or linear, and at least 0 at s = 0: if it is positive at the
        # end, it is positive all the time.
        bend = radius * omega * omega / 2
        # Height of the corner that touched, over s: at least e c - R omega^2 s/2. Those of the
        # others: at least y + z + (vy + omega q) s - R omega^2 s^2/2.
        slack = [arb_of(self.body.restitution) * touch.closing - bend * until]
        for q, z in self.body.corners(theta):
            slack.append(y + z + (rise + omega * q) * until - bend * until * until)
        if not all(height > 0 for height in slack):
            raise UndecidedError("a second corner may meet the plane", code="corner", final=True)

    def constants(self) -> dict[str, arb]:
        """impact_time [s], normal_impulse [N s], and energy_lost (1 - e^2) c^2/(2 (1/m + p^2/I))
        [J].
        """
        touch = self.touch()
        e = self.body.restitution
        # (1 - e^2) c^2/(2 (1/m + p^2/I)).
        lost = arb_of(1 - e * e) * touch.closing * touch.closing / (2 * self.ease(touch.p))
        return {
            "impact_time": touch.time,
            "normal_impulse": touch.impulse,
            "energy_lost": lost,
        }

    @per_precision
    def growth(self) -> Grows:
        """How errors grow: flights, and the derivative across the impact."""
        size = Norm([1] * len(self.state))
        fastest = max(self.scale["vx"] / self.scale["x"], self.scale["omega"] / self.scale["theta"])
        return Growth(self.stretches(), size, step=narrow(arb_of(fastest)))

    def sizes(self) -> list[arb]:
        """The scales of the coordinates of the state."""
        return [arb_of(self.scale[name]) for name in self.state]

    def stretches(self) -> Iterator[Stretch]:
        """The flight to the impact, which ends with it, and the flight after it."""
        touch = self.touch()
        sizes = self.sizes()

        def flight(t: arb) -> arb_mat:
            derivative = unit_matrix(len(sizes))
            for place, speed in ((X, VX), (Y, VY), (THETA, OMEGA)):
                derivative[place, speed] = t * sizes[speed] / sizes[place]
            return derivative

        jump = between_scales(self.saltation(touch).tolist(), sizes)
        yield smooth(arb(0), touch.time, flight, jump=jump, affine=True)
        yield smooth(touch.time, None, flight, affine=True)

    def saltation(self, touch: Touch) -> arb_mat:
        """The derivative (6, 6) of the state across the impact, in the units of the state."""
        mass = arb_of(self.body.mass)
        inertia = arb_of(self.body.inertia)
        ease = self.ease(touch.p)
        factor = arb_of(1 + self.body.restitution)
        omega = touch.before[OMEGA]
        # J = (1 + e) c/ease, with dc = -(dvy + p domega + omega d dtheta).
        of_impulse = [arb(0)] * 6
        of_impulse[VY] = -factor / ease
        of_impulse[OMEGA] = -factor * touch.p / ease
        # d(1/m + p^2/I)/dtheta = 2 p d/I, as dp/dtheta = d.
        of_ease = 2 * touch.p * touch.d / inertia
        of_impulse[THETA] = -factor * omega * touch.d / ease - touch.impulse * of_ease / ease
        across = unit_matrix(6)
        for k in range(6):
            across[VY, k] += of_impulse[k] / mass
            across[OMEGA, k] += touch.p * of_impulse[k] / inertia
        # omega += p J/I: the part of dp = d dtheta.
        across[OMEGA, THETA] += touch.d * touch.impulse / inertia
        # dt = (dy + p dtheta)/c.
        later = arb_mat(1, 6)
        later[0, Y] = 1 / touch.closing
        later[0, THETA] = touch.p / touch.closing
        rate_before = column(touch.before)
        rate_after = column(touch.after)
        # DP (1 + f- dt) - f+ dt.
        return across * (unit_matrix(6) + rate_before * later) - rate_after * later


def column(state: list[arb]) -> arb_mat:
    """The rates (6, 1) of a state in free flight."""
    rates = arb_mat(6, 1)
    for place, speed in ((X, VX), (Y, VY), (THETA, OMEGA)):
        rates[place, 0] = state[speed]
    return rates


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth of case corner-impact; `scale` of its quantities in order."""
    body = Box(
        mass=number(p, "mass"), sides=vector(p, "sides"), restitution=number(p, "restitution")
    )
    vx, vy = vector(p, "velocity")
    begin = (Fraction(0), number(p, "height"), vx, vy, number(p, "angle"), Fraction(0))
    return CornerImpact(Refiner.of(scale), body, begin)
