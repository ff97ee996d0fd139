"""Witness of a break of billiards: after each impact the time at which each pair touches is found
by bisection of its gap, and the earliest one is taken; every impact is a linear system
(rigid_impacts.py).

Neither the quadratic equation of the truth for the times nor its closed form of the impulses is
used. Only midpoints of balls are carried from impact to impact, so that nothing is proved.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import combinations

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.rigid_impacts import (
    LAW,
    Sphere,
    Triple,
    along,
    energy,
    length,
    meeting,
    struck,
)

METHOD = (
    "gaps of all pairs to their narrowest, the first to close by bisection, impulses from the"
    " balance equations by elimination, unproven (refdem/truth/witnesses/breaks.py)"
)


class Table:
    """Cue ball and rack at the time `now` [s], and the scalars `told` of the impacts so far."""

    def __init__(self, p: Mapping[str, Exact]) -> None:
        masses = [arb_of(x) for x in vector(p, "masses")]
        radii = [arb_of(x) for x in vector(p, "radii")]
        factor = arb_of(number(p, "inertia_factor"))
        moments = [factor * m * r * r for m, r in zip(masses, radii, strict=True)]
        reach = radii[0] + radii[1]
        place = [-arb_of(number(p, "distance")) * reach, arb_of(number(p, "offset")) * reach]
        velocity = [*(arb_of(x) for x in vector(p, "velocity")), arb(0)]
        spin = [arb(0), arb(0), arb_of(number(p, "spin"))]
        cue = Sphere(masses[0], moments[0], radii[0], [*place, arb(0)], velocity, spin)
        self.balls = [cue]
        pitch = 2 * radii[1] + arb_of(number(p, "gap"))
        across = -pitch / 2
        for count in range(1, int(number(p, "rows")) + 1):
            # Row k = count - 1 = 0, 1, ... has x = 7/8 k pitch and y = (j - k/2) pitch, j = 0..k.
            depth = (count - 1) * pitch * 7 / 8
            across = pitch * (1 - count) / 2
            for k in range(count):
                centre = [depth, across + k * pitch, arb(0)]
                still = [arb(0)] * 3
                self.balls.append(Sphere(masses[1], moments[1], radii[1], centre, still, still))
        self.law = {name: arb_of(number(p, name)) for name in LAW}
        self.now = arb(0)
        self.impacts = 0
        self.told: dict[str, arb] = {}

    def closing_after(self, first: Sphere, second: Sphere) -> arb | None:
        """The time [s] until two spheres touch; None if they do not approach or pass each other."""
        apart = [b - a for a, b in zip(first.r, second.r, strict=True)]
        relative = [b - a for a, b in zip(first.v, second.v, strict=True)]
        square = along(relative, relative)
        approach = -along(apart, relative)
        if not approach > 0:
            return None
        # With d = r2 - r1 and w = v2 - v1 the centres are nearest at t = -(d . w)/w^2. The gap
        # |d + w t| - R1 - R2 decreases up to there.
        nearest = (approach / square).mid()
        reach = first.radius + second.radius

        def gap(t: arb) -> arb:
            branch = [d + w * t for d, w in zip(apart, relative, strict=True)]
            return arb(length(branch) - reach)

        if gap(nearest) > 0:
            return None
        return meeting(gap, nearest)

    def next_impact(self) -> tuple[arb, int, int] | None:
        """The time [s] and the numbers of the two spheres that touch first; None if none do."""
        first = None
        for i, j in combinations(range(len(self.balls)), 2):
            wait = self.closing_after(self.balls[i], self.balls[j])
            if wait is not None and (first is None or wait < first[0]):
                first = wait, i, j
        if first is None:
            return None
        return self.now + first[0], first[1], first[2]

    def strike(self, when: arb, i: int, j: int) -> None:
        """Advances all spheres to the time `when`, and solves the impact of spheres i and j."""
        elapsed = when - self.now
        for ball in self.balls:
            ball.r = middles(ball.at(elapsed))
        self.now = when.mid()
        pair = [self.balls[i], self.balls[j]]
        branch = [b - a for a, b in zip(pair[0].r, pair[1].r, strict=True)]
        distance = length(branch)
        normal = [x / distance for x in branch]
        self.impacts += 1
        name = f"impact_{self.impacts}"
        # The closing speed (v_i - v_j) . n, with n = (r_j - r_i)/|r_j - r_i|.
        closing = along(pair[0].v, normal) - along(pair[1].v, normal)
        self.told[name] = when
        self.told[f"{name}_closing"] = closing
        self.told[f"{name}_body"] = arb(i)
        self.told[f"{name}_other"] = arb(j)
        velocities, _ = struck(pair, normal, self.law)
        for body, ball in enumerate(pair):
            ball.v = middles(velocities[6 * body : 6 * body + 3])
            ball.omega = middles(velocities[6 * body + 3 : 6 * body + 6])

    def energy(self) -> arb:
        """The kinetic energy of all balls [J]."""
        velocities: list[arb] = []
        for ball in self.balls:
            velocities += [*ball.v, *ball.omega]
        return energy(self.balls, velocities)


def middles(triple: Triple) -> Triple:
    """The midpoints of three balls."""
    return [x.mid() for x in triple]


def billiard_break(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The states at the times, then the scalars of all impacts, including later ones."""
    table = Table(p)
    before = table.energy()
    coming = table.next_impact()
    for t in times:
        until = arb_of(t)
        while coming is not None and coming[0] < until:
            table.strike(*coming)
            coming = table.next_impact()
        values: dict[str, arb] = {}
        for number_of_ball, ball in enumerate(table.balls):
            place = ball.at(until - table.now)
            for axis, name in enumerate("xy"):
                values[f"r{number_of_ball}.{name}"] = place[axis]
                values[f"v{number_of_ball}.{name}"] = ball.v[axis]
            values[f"omega{number_of_ball}.z"] = ball.omega[2]
        yield t, values
    while coming is not None:
        table.strike(*coming)
        coming = table.next_impact()
    yield (
        None,
        {
            "impacts": arb(table.impacts),
            "last_impact_time": table.now,
            "energy_lost": before - table.energy(),
            **table.told,
        },
    )


WITNESSES = {"billiard-break": Witness(METHOD, billiard_break)}
