"""Witnesses of the impact benchmarks: Newton's law for the numbers of each member, phase by
phase.
"""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.witnesses import contacts, members
from refdem.truth.witnesses.collisions import Colliding, Value, flown, phases, two_spheres
from refdem.truth.witnesses.contacts import beyond
from refdem.truth.witnesses.impact_numbers import impact_numbers
from refdem.truth.witnesses.taylor import Solution
from refdem.truth.witnesses.testimony import Claimed, Said, Witness

METHOD = (
    "Taylor integration of Newton's law phase by phase at 58 digits, unproven"
    " (refdem/truth/witnesses/impacts.py)"
)
AXES = [f"{kind}.{axis}" for kind in ("r", "v", "omega") for axis in "xyz"]


class Struck(Colliding):
    """One sphere and the wall x = 0, from the left: in the frame of Spheres e = (-1, 0), and no
    normal that turns.
    """

    def __init__(self, p: Mapping[str, Any]) -> None:
        self.mass, self.reach = arb_of(p["mass"]), arb_of(p["radius"])
        self.moment = self.mass * self.reach * self.reach * 2 / 5
        self.beta = {"R": arb(0), "R-d/2": arb(1) / 2, "R-d": arb(1)}[str(p["branch"])]
        names = ("stiffness", "damping", "tangential_stiffness", "friction")
        self.k, self.c, self.kt, self.mu = (arb_of(p[name]) for name in names)
        self.pulls = p["cutoff"] == "zero_overlap" and p["damping"] > 0

    def geometry(self, s: Sequence[Any]) -> tuple[Any, Any, Any, Any, Any, Any]:
        x, _, vx, vy = s[:4]
        return arb(-1), arb(0), -x, -vx, -vy, self.k * (self.reach + x) + self.c * vx

    def lever(self, s: Sequence[Any]) -> Any:
        return self.reach - self.beta * self.overlap(s)

    def slip(self, s: Sequence[Any]) -> Any:
        return -s[3] - self.lever(s) * s[4]

    def holding(self, s: Sequence[Any]) -> Any:
        """0 = f/m + l^2 f/J + beta v_x w."""
        return (
            -self.beta * s[2] * s[4] / (1 / self.mass + self.lever(s) * self.lever(s) / self.moment)
        )

    def growth(self, s: Sequence[Any]) -> Any:
        return self.k * s[2] - self.c * self.force(s) / self.mass

    def field(self, friction: Value) -> Any:
        def rates(t: Any, s: Sequence[Any]) -> list[Any]:
            f = friction(s)
            return [
                s[2],
                s[3],
                -self.force(s) / self.mass,
                -f / self.mass,
                -self.lever(s) * f / self.moment,
                s[5] * 0,
                self.slip(s),
            ]

        return rates

    def law(self, phase: str) -> Value:
        return self.plain_law(phase)

    def after(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        return self.caught_or_slipped(phase, then, s)


def on_wall(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The impact on a wall under the linear contact law."""
    ball = Struck(p)
    nothing = arb(0)
    start = [
        -ball.reach,
        nothing,
        *(arb_of(p[name]) for name in ("normal", "across", "spin")),
        nothing,
        nothing,
    ]
    course = list(phases(ball, start, float(claimed["duration"])))
    end = course[-1][1]
    last = course[-1][0].at(end)
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
        now = next(
            (solution.at(t) for solution, until in course if arb_of(t) < until), None
        ) or flown(last, arb_of(t) - end)
        yield (
            t,
            dict(
                zip(
                    AXES,
                    (now[0], now[1], nothing, now[2], now[3], nothing, nothing, nothing, now[4]),
                    strict=True,
                )
            ),
        )


def hertz_wall(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """d = w^2, dt = w ds: w, v, t, and y, v_y, R omega under friction mu F against their slip until
    there is none.
    """
    ratio, mu, radius, normal, across = (
        arb_of(p[name]) for name in ("hertz", "friction", "radius", "normal", "across")
    )
    ratio = ratio / arb_of(p["mass"])
    turning = radius * arb_of(p["spin"])
    if across + turning > 0:
        side = 1
    elif across + turning < 0:
        side = -1
    else:
        side = 0
    course = [
        Solution(
            partial(sliding, ratio, side * mu), [arb(0), normal, arb(0), arb(0), across, turning]
        )
    ]
    scale = float((normal * normal / ratio).root(5)) / float(normal)
    looks = [scale * n / 32 for n in range(1, 2000)]
    until = next(s for s in looks if course[0].at(arb(s))[0] < 0)
    ends = [arb(0)]
    if side and side * sum(course[0].at(arb(until))[4:6]) < 0:
        ends.append(course[0].bisected(lambda y: -side * (y[4] + y[5]), 0.0, until))
        course.append(
            Solution(partial(sliding, ratio, arb(0)), course[0].at(ends[1]), begin=ends[1])
        )
        until = next(s for s in looks if s > float(ends[1]) and course[1].at(arb(s))[0] < 0)
    end = course[-1].bisected(lambda y: -y[0], until / 2, until)
    last = course[-1].at(end)
    for t in times:
        time = arb_of(t)
        state = last
        if time < last[2]:
            if time > course[0].at(ends[-1])[2]:
                which = len(ends) - 1
            else:
                which = 0
            if which == len(ends) - 1:
                high = float(end)
            else:
                high = float(ends[1])
            state = course[which].at(
                course[which].bisected(partial(beyond, 2, time), float(ends[which]), high)
            )
        rest = time - state[2]
        w, v, _, y, vy, turn = state
        depth = w * w + v * rest
        nothing = arb(0)
        yield (
            t,
            dict(
                zip(
                    AXES,
                    (
                        depth - radius,
                        y + vy * rest,
                        nothing,
                        v,
                        vy,
                        nothing,
                        nothing,
                        nothing,
                        turn / radius,
                    ),
                    strict=True,
                )
            ),
        )


def sliding(ratio: arb, mu: arb, s: Any, y: Sequence[Any]) -> list[Any]:
    """Rates of w, v, t, y, v_y and R omega in s."""
    w, v, _, _, vy, _ = y
    push = ratio * w * w * w * w
    return [v / 2, -push, w, vy * w, -mu * push, -mu * push * 5 / 2]


def bouncing(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Falls and contacts by turns; the apexes where the velocity is zero.

    A phase lasts about `span`: the time to fall back to the floor, or half a period of the contact.
    Its end is looked for in steps of a sixteenth of that, and found there by the secant.
    """
    mass, radius, gravity = (arb_of(p[name]) for name in ("mass", "radius", "gravity"))
    k, c = (arb_of(p[name]) / mass for name in ("stiffness", "damping"))
    y = arb_of(p["height"])
    v = arb(0)
    begin = arb(0)
    waiting = list(times)
    bounces = 0
    falls = True
    tops = len([name for name in claimed if name.startswith("apex_")])
    while waiting or bounces <= tops:
        if falls:
            field = partial(falling, gravity)
        else:
            field = partial(pressing, k, c, gravity, radius)
        phase = Solution(field, [y, v], begin=begin)
        span = float(
            ((v + (v * v + 2 * gravity * (y - radius)).sqrt()) / gravity)
            if falls
            else arb.pi() / k.sqrt()
        )
        looks = (float(begin) + span * n / 16 for n in range(2, 99))
        after = next(t for t in looks if (phase.at(arb(t))[0] < radius) == falls)
        if falls and bounces and bounces <= tops:
            top = phase.crossing(lambda s: s[1], float(begin) + span / 2, span / 32)
            yield None, {f"apex_{bounces}": phase.at(top)[0]}
        end = phase.crossing(lambda s: s[0] - radius, after - span / 32, span / 32)
        while waiting and arb_of(waiting[0]) < end:
            t = waiting.pop(0)
            now = phase.at(t)
            yield t, dict.fromkeys(AXES, arb(0)) | {"r.y": now[0], "v.y": now[1]}
        begin = end
        y = radius
        v = phase.at(end)[1]
        bounces = bounces + (not falls)
        falls = not falls


def falling(gravity: arb, t: Any, s: Sequence[Any]) -> list[Any]:
    """The rates of (y, v) for y'' = -g."""
    return [s[1], s[1] * 0 - gravity]


def pressing(k: arb, c: arb, gravity: arb, radius: arb, t: Any, s: Sequence[Any]) -> list[Any]:
    """y'' = k (R - y) - c y' - g."""
    return [s[1], (radius - s[0]) * k - s[1] * c - gravity]


def alike(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Two spheres head-on under Hertz's law."""
    halved = arb_of(p["mass"]) / 2
    yield from contacts.hertz(
        {"effective_mass": halved, "stiffness": p["hertz"], "closing_speed": p["speed"]},
        times,
        claimed,
    )


def spun(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Two spheres that spin about z and close head-on under the linear law."""
    spins = (Fraction(0), Fraction(0), p["spins"][0], Fraction(0), Fraction(0), p["spins"][1])
    yield from two_spheres(
        {**p, "closing_speed": p["speed"], "angle": Fraction(0), "spins": spins}, times, claimed
    )


MEMBERS: dict[str, Callable[[Mapping[str, Any], Sequence[Fraction], Claimed], Said]] = {
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
"""Every member of the case."""


def impact(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The impact under the law of the member."""
    yield from MEMBERS[p["member"]](impact_numbers(p), times, claimed)


WITNESSES = {"impact-benchmarks": Witness(METHOD, impact)}
