"""Witness of spheres on a line: the next impact is the earliest of all pairs, in ball arithmetic;
the velocities after it come from the balance equations of the pair by elimination.

No code of the truth is used: there is no list of impacts, and no rational arithmetic after the
start.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from flint import arb, arb_mat

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness

METHOD = (
    "the next impact of all pairs in balls, speeds from the balances of the pair by elimination,"
    " unproven (refdem/truth/witnesses/lines_of_impacts.py)"
)


class Line:
    """The spheres at the time `now` [s]: masses, radii, positions and velocities, as Arb balls.

    `told` collects the scalars of the impacts so far, by name.
    """

    def __init__(self, p: Mapping[str, Exact]) -> None:
        count = int(number(p, "balls"))
        self.masses = [arb_of(x) for x in vector(p, "masses")[:count]]
        self.radii = [arb_of(x) for x in vector(p, "radii")[:count]]
        self.v = [arb_of(x) for x in vector(p, "velocities")[:count]]
        self.restitution = arb_of(number(p, "restitution"))
        self.now = arb(0)
        self.impacts = 0
        self.told: dict[str, arb] = {}
        # x_k = x_(k-1) + R_(k-1) + gap + R_k
        self.x = [arb(0)]
        edge = self.radii[0]
        for k, gap in enumerate(vector(p, "gaps")[: count - 1], start=1):
            self.x.append(edge + arb_of(gap) + self.radii[k])
            edge = self.x[k] + self.radii[k]

    def places(self, t: arb) -> list[arb]:
        """The centres x + v (t - now) [m], for t up to the next impact."""
        return [x + v * (t - self.now) for x, v in zip(self.x, self.v, strict=True)]

    def next_impact(self) -> tuple[arb, int] | None:
        """The time [s] and the left sphere of the next impact; None if no pair approaches."""
        # Neighbours with v_k > v_(k+1) meet after gap/(v_k - v_(k+1)).
        first = None
        for k in range(len(self.x) - 1):
            closing = self.v[k] - self.v[k + 1]
            if not closing > 0:
                continue
            gap = self.x[k + 1] - self.radii[k + 1] - self.x[k] - self.radii[k]
            when = self.now + gap / closing
            if first is None or float(when.mid()) < float(first[0].mid()):
                first = when, k
        return first

    def strike(self, when: arb, k: int) -> None:
        """Advances to the time `when`, and solves the impact of the spheres k and k + 1."""
        self.x = self.places(when)
        self.now = when
        self.impacts += 1
        name = f"impact_{self.impacts}"
        self.told[name] = when
        self.told[f"{name}_closing"] = self.v[k] - self.v[k + 1]
        self.told[f"{name}_body"] = arb(k)
        self.told[f"{name}_other"] = arb(k + 1)
        # m1 u1 + m2 u2 = m1 v1 + m2 v2,   u2 - u1 = e (v1 - v2)
        momentum = self.masses[k] * self.v[k] + self.masses[k + 1] * self.v[k + 1]
        parting = self.restitution * (self.v[k] - self.v[k + 1])
        rows = arb_mat([[self.masses[k], self.masses[k + 1]], [arb(-1), arb(1)]])
        speeds = rows.solve(arb_mat([[momentum], [parting]]))
        self.v[k] = speeds[0, 0]
        self.v[k + 1] = speeds[1, 0]

    def energy(self) -> arb:
        """The kinetic energy sum of m v^2/2 of all spheres [J]."""
        found = arb(0)
        for m, v in zip(self.masses, self.v, strict=True):
            found += m * v * v / 2
        return found


def newtons_cradle(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The states at the times, then the scalars of all impacts, including later ones."""
    line = Line(p)
    before = line.energy()
    for t in times:
        until = arb_of(t)
        while (coming := line.next_impact()) is not None and coming[0] < until:
            line.strike(*coming)
        values: dict[str, arb] = {}
        for k, (x, v) in enumerate(zip(line.places(until), line.v, strict=True), start=1):
            values[f"r{k}.x"] = x
            values[f"v{k}.x"] = v
        yield t, values
    while (coming := line.next_impact()) is not None:
        line.strike(*coming)
    yield (
        None,
        {
            "impacts": arb(line.impacts),
            "last_impact_time": line.now,
            "energy_lost": before - line.energy(),
            **line.told,
        },
    )


WITNESSES = {"newtons-cradle": Witness(METHOD, newtons_cradle)}
