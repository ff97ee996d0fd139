"""Witnesses of the impact benchmarks: Newton's law for the parameters of each member, phase by
phase.

The parameters `p` of a member come from impact_numbers.py: exact rationals or Arb balls, in SI
units.
"""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.witnesses import contacts, members
from refdem.truth.witnesses.collisions import Colliding, Value, during, flown, phases, two_spheres
from refdem.truth.witnesses.contacts import beyond
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.impact_numbers import impact_numbers
from refdem.truth.witnesses.taylor import Solution

METHOD = (
    "Taylor integration of Newton's law phase by phase at 58 digits, unproven"
    " (refdem/truth/witnesses/impacts.py)"
)


class Struck(Colliding):
    """One sphere at x < 0 and the wall x = 0, in the notation of collisions.py.

    The normal e = (-1, 0) and the tangent t = (0, -1) are constant, and the overlap is d = R + x.
    The state has the form of a pair of spheres; its second spin is 0.
    """

    def __init__(self, p: Mapping[str, Any]) -> None:
        self.mass = arb_of(p["mass"])
        self.reach = arb_of(p["radius"])
        self.moment = self.mass * self.reach * self.reach * 2 / 5
        self.beta = {"R": arb(0), "R-d/2": arb(1) / 2, "R-d": arb(1)}[str(p["branch"])]
        names = ("stiffness", "damping", "tangential_stiffness", "friction")
        self.k, self.c, self.kt, self.mu = (arb_of(p[name]) for name in names)
        self.pulls = p["cutoff"] == "zero_overlap" and p["damping"] > 0

    def geometry(self, s: Sequence[Any]) -> tuple[Any, Any, Any, Any, Any, Any]:
        # |r| = -x,  v_e = -v_x,  v_t = -v_y,  F = k (R + x) - c v_e = k (R + x) + c v_x
        x, _, vx, vy = s[:4]
        force = self.k * (self.reach + x) + self.c * vx
        return arb(-1), arb(0), -x, -vx, -vy, force

    def lever(self, s: Sequence[Any]) -> Any:
        """The lever l = R - beta d of friction."""
        return self.reach - self.beta * self.overlap(s)

    def slip(self, s: Sequence[Any]) -> Any:
        """The slip v_t - l omega = -v_y - l omega of the surface [m/s]."""
        return -s[3] - self.lever(s) * s[4]

    def holding(self, s: Sequence[Any]) -> Any:
        """The friction f with slip' = 0 [N].

        slip' = -v_y' - l' omega - l omega' = f/m + beta v_x omega + l^2 f/J, as l' = -beta v_x.
        """
        # 0 = f (1/m + l^2/J) + beta v_x omega
        inverse_mass = 1 / self.mass + self.lever(s) * self.lever(s) / self.moment
        return -self.beta * s[2] * s[4] / inverse_mass

    def growth(self, s: Sequence[Any]) -> Any:
        """dF/dt = k v_x + c v_x' = k v_x - c F/m [N/s]."""
        return self.k * s[2] - self.c * self.force(s) / self.mass

    def field(self, friction: Value) -> Any:
        """m v_x' = -F, m v_y' = -f, J omega' = -l f, stretch' = slip."""

        def rates(t: Any, s: Sequence[Any]) -> list[Any]:
            f = friction(s)
            ax = -self.force(s) / self.mass
            ay = -f / self.mass
            spin_rate = -self.lever(s) * f / self.moment
            return [s[2], s[3], ax, ay, spin_rate, s[5] * 0, self.slip(s)]

        return rates

    def law(self, phase: str) -> Value:
        return self.plain_law(phase)

    def after(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        return self.caught_or_slipped(phase, then, s)


def on_wall(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The impact of a sphere on a wall under the linear contact law."""
    sphere = Struck(p)
    zero = arb(0)
    vx, vy, spin = (arb_of(p[name]) for name in ("normal", "across", "spin"))
    start = [-sphere.reach, zero, vx, vy, spin, zero, zero]
    contact = list(phases(sphere, start, float(claimed["duration"])))
    last_phase, end = contact[-1]
    last = last_phase.at(end)
    yield (
        None,
        {
            "duration": end,
            "rebound_across": last[3],
            "rebound_spin": last[4],
            "restitution": -last[2] / start[2],
        },
    )
    for t in times:
        state = during(contact, arb_of(t)) or flown(last, arb_of(t) - end)
        x, y, vx, vy, spin = state[:5]
        yield t, members.nine("", x, y, vx, vy, spin)


def hertz_wall(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """A sphere on a wall under Hertz's law with sliding friction, as a curve in s.

    The substitution d = w^2, dt = w ds makes the equations analytic at d = 0. The state is (w, v =
    d', t, y, v_y, R omega). Friction mu F acts against the slip v_y + R omega. If the slip becomes
    0 during the contact, a second phase without friction follows.
    """
    stiffness, mu, radius, normal, across = (
        arb_of(p[name]) for name in ("hertz", "friction", "radius", "normal", "across")
    )
    k = stiffness / arb_of(p["mass"])
    r_omega = radius * arb_of(p["spin"])
    if across + r_omega > 0:
        side = 1
    elif across + r_omega < 0:
        side = -1
    else:
        side = 0
    start = [arb(0), normal, arb(0), arb(0), across, r_omega]
    contact = [Solution(partial(sliding, k, side * mu), start)]
    # The contact lasts over a range of s of the size w_max/v0 with w_max about (v0^2/k)^(1/5), as
    # dw/ds = v/2. The end, w < 0, is searched in steps of a 32nd of that.
    scale = float((normal * normal / k).root(5)) / float(normal)
    grid = [scale * n / 32 for n in range(1, 2000)]
    parted = next(s for s in grid if contact[0].at(arb(s))[0] < 0)
    begins = [arb(0)]
    if side and side * sum(contact[0].at(arb(parted))[4:6]) < 0:
        stop = contact[0].bisected(lambda y: -side * (y[4] + y[5]), 0.0, parted)
        rolling = Solution(partial(sliding, k, arb(0)), contact[0].at(stop), begin=stop)
        begins.append(stop)
        contact.append(rolling)
        parted = next(s for s in grid if s > float(stop) and rolling.at(arb(s))[0] < 0)
    end = contact[-1].bisected(lambda y: -y[0], parted / 2, parted)
    last = contact[-1].at(end)
    ends = [*begins[1:], end]
    for t in times:
        time = arb_of(t)
        state = last
        if time < last[2]:
            # The phase in which the time lies, and the s of the time in it.
            if time > contact[0].at(begins[-1])[2]:
                index = len(contact) - 1
            else:
                index = 0
            s = contact[index].bisected(
                partial(beyond, 2, time), float(begins[index]), float(ends[index])
            )
            state = contact[index].at(s)
        w, v, state_time, y, vy, r_omega_now = state
        # The time since the end of the contact; it is 0 during the contact. x = w^2 - R.
        flight = time - state_time
        x = w * w + v * flight - radius
        yield t, members.nine("", x, y + vy * flight, v, vy, r_omega_now / radius)


def sliding(k: arb, mu: arb, s: Any, y: Sequence[Any]) -> list[Any]:
    """The derivatives of (w, v, t, y, v_y, R omega) by s, with the stiffness k per mass.

    d/ds = w d/dt, with dw/dt = v/(2 w), dv/dt = -k w^3, dv_y/dt = -mu k w^3 and, as J = 2/5 m R^2,
    d(R omega)/dt = -5/2 mu k w^3.
    """
    w, v, _, _, vy, _ = y
    # w F/m = k w^4, as F/m = k d^(3/2) = k w^3.
    force = k * w * w * w * w
    return [v / 2, -force, w, vy * w, -mu * force, -mu * force * 5 / 2]


def bouncing(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """A sphere that bounces on a floor: alternating flights and contacts, apexes where y' = 0.

    A phase lasts about `span`: the time of the flight back to y = R, or half a period of the
    contact. Its end is bracketed in steps of a sixteenth of that and refined by the secant method.
    """
    mass, radius, gravity = (arb_of(p[name]) for name in ("mass", "radius", "gravity"))
    k, c = (arb_of(p[name]) / mass for name in ("stiffness", "damping"))
    y = arb_of(p["height"])
    v = arb(0)
    begin = arb(0)
    waiting = list(times)
    bounces = 0
    is_flight = True
    apexes = len([name for name in claimed if name.startswith("apex_")])
    while waiting or bounces <= apexes:
        if is_flight:
            field = partial(falling, gravity)
            # y + v t - g t^2/2 = R at t = (v + sqrt(v^2 + 2 g (y - R)))/g.
            span = float((v + (v * v + 2 * gravity * (y - radius)).sqrt()) / gravity)
        else:
            field = partial(pressing, k, c, gravity, radius)
            # pi/sqrt(k), with k per mass.
            span = float(arb.pi() / k.sqrt())
        phase = Solution(field, [y, v], begin=begin)
        grid = (float(begin) + span * n / 16 for n in range(2, 99))
        after = next(t for t in grid if (phase.at(arb(t))[0] < radius) == is_flight)
        if is_flight and bounces and bounces <= apexes:
            top = phase.crossing(lambda s: s[1], float(begin) + span / 2, span / 32)
            yield None, {f"apex_{bounces}": phase.at(top)[0]}
        end = phase.crossing(lambda s: s[0] - radius, after - span / 32, span / 32)
        while waiting and arb_of(waiting[0]) < end:
            t = waiting.pop(0)
            height, rate = phase.at(t)
            yield t, members.nine("", y=height, vy=rate)
        begin = end
        y = radius
        v = phase.at(end)[1]
        if not is_flight:
            bounces += 1
        is_flight = not is_flight


def falling(gravity: arb, t: Any, s: Sequence[Any]) -> list[Any]:
    """The rates of (y, v) for y'' = -g."""
    return [s[1], s[1] * 0 - gravity]


def pressing(k: arb, c: arb, gravity: arb, radius: arb, t: Any, s: Sequence[Any]) -> list[Any]:
    """The rates of (y, v) for y'' = k (R - y) - c y' - g, k and c being per mass."""
    return [s[1], (radius - s[0]) * k - s[1] * c - gravity]


def alike(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Two equal spheres that collide head-on under Hertz's law; the effective mass is m/2."""
    halved = arb_of(p["mass"]) / 2
    yield from contacts.hertz(
        {"effective_mass": halved, "stiffness": p["hertz"], "closing_speed": p["speed"]},
        times,
        claimed,
    )


def spun(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Two spheres that spin about z and collide head-on under the linear law."""
    spins = (Fraction(0), Fraction(0), p["spins"][0], Fraction(0), Fraction(0), p["spins"][1])
    yield from two_spheres(
        {**p, "closing_speed": p["speed"], "angle": Fraction(0), "spins": spins}, times, claimed
    )


MEMBERS: dict[str, Callable[[Mapping[str, Any], Sequence[Fraction], Claimed], Results]] = {
    **dict.fromkeys(("co-3", "co-4", "co-5", "co-6", "dem-05"), on_wall),
    **dict.fromkeys(("co-7", "co-8"), spun),
    **dict.fromkeys(("dem-01", "dem-02"), bouncing),
    "co-1": alike,
    **dict.fromkeys(("co-2", "dem-05-hertz"), hertz_wall),
    "dem-03": members.stacked,
    "dem-04": members.sliding_to_roll,
    "dem-05-mindlin": members.mindlin_wall,
    "three-spheres": members.squeezed,
    "contact-path": partial(members.passing, members.frame(1, (1, 0, 0), (0, 1, 0), (0, 0, 1))),
    "contact-path-turned": partial(
        members.passing, members.frame(3, (2, -1, 2), (2, 2, -1), (-1, 2, 2))
    ),
}
"""The witness of every member of the case."""


def impact(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The impact under the law of the member."""
    yield from MEMBERS[p["member"]](impact_numbers(p), times, claimed)


WITNESSES = {"impact-benchmarks": Witness(METHOD, impact)}
