"""Witness of rigid impacts: velocities and impulse after the impact from a linear system, the time
of impact by bisection.

The formulas of the truth are not used. The unknowns are the velocities v' and angular velocities
omega' after the impact and the impulse P on the first body. With the relative velocity g of the
two contact points, the normal n and two tangents t_i they satisfy

    m (v' - v) = +-P,   J (omega' - omega) = r x (+-P) about each centre,
    n.g' = -e n.g,   t_i.g' = -b t_i.g,

a linear system that is solved by elimination. If its solution has |P_t| > mu P_n, the contact
slides, and the last two equations are replaced by two for the impulse: P has no component at right
angles to both n and the slip, and its component against the slip is mu P_n.
"""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb, arb_mat

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness

METHOD = (
    "balance equations of both bodies and of the contact by elimination, time of impact by"
    " bisection, unproven (refdem/truth/witnesses/rigid_impacts.py)"
)
HALVINGS = 300
"""Bisections of the time of impact: 2^-300 of the interval is beyond the bits of a cross-check."""
LAW = ("restitution", "tangential_restitution", "friction")
Triple = list[Any]


class Sphere:
    """Mass, moment of inertia, radius, position, velocity and spin of one sphere, as Arb balls."""

    def __init__(
        self, mass: arb, moment: arb, radius: arb, r: Triple, v: Triple, omega: Triple
    ) -> None:
        self.mass = mass
        self.moment = moment
        self.radius = radius
        self.r = r
        self.v = v
        self.omega = omega

    def at(self, t: arb) -> Triple:
        """The centre (3,) after a free flight of t [s]."""
        return [r + v * t for r, v in zip(self.r, self.v, strict=True)]


def product(a: Sequence[Any], b: Sequence[Any]) -> Triple:
    """The vector product a x b of two vectors (3,)."""
    return [a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3] for i in range(3)]


def along(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """The scalar product of two vectors (3,)."""
    return sum((x * y for x, y in zip(a, b, strict=True)), arb(0))


def length(a: Sequence[Any]) -> arb:
    """The length of a vector; where its ball contains 0, a ball of all lengths from 0 on."""
    square = along(a, a)
    if square > 0:
        return arb(square.sqrt())
    return arb(0).union(arb(square.abs_upper()).sqrt())


def tangents(normal: Sequence[arb]) -> tuple[Triple, Triple]:
    """Two vectors at right angles to the normal and to each other, not normalised."""
    # t1 = n x e_i with the axis i along which n is smallest, and t2 = n x t1.
    least = min(range(3), key=lambda axis: abs(float(normal[axis])))
    axis = [arb(int(i == least)) for i in range(3)]
    first = product(normal, axis)
    return first, product(normal, first)


class Equations:
    """The linear system of one impact: rows of coefficients, and their right-hand sides.

    The unknowns are v' and omega' of each sphere (6 numbers a sphere), then the impulse P on the
    first sphere. With one sphere the other body is a wall at rest.
    """

    def __init__(self, spheres: Sequence[Sphere], normal: Triple) -> None:
        self.spheres = spheres
        self.normal = normal
        self.count = 6 * len(spheres) + 3
        self.rows: list[list[arb]] = []
        self.sides: list[arb] = []
        self.impulse = 6 * len(spheres)

    def blank(self) -> list[arb]:
        """A row of coefficients that are all zero."""
        return [arb(0)] * self.count

    def add(self, row: list[arb], side: arb) -> None:
        """Appends an equation: the row of coefficients times the unknowns is `side`."""
        self.rows.append(row)
        self.sides.append(side)

    def balances(self) -> None:
        """Adds the balance of momentum and of angular momentum of each sphere.

        m v' - s P = m v and J omega' - s r x P = J omega, with s = 1 for the first sphere and -1
        for the second one, and the arm r = s R n from the centre to the contact point.
        """
        for body, sphere in enumerate(self.spheres):
            sign = 1 - 2 * body
            first = 6 * body
            lever = [sign * sphere.radius * x for x in self.normal]
            for axis in range(3):
                row = self.blank()
                row[first + axis] = sphere.mass
                row[self.impulse + axis] = arb(-sign)
                self.add(row, sphere.mass * sphere.v[axis])
            for axis in range(3):
                row = self.blank()
                row[first + 3 + axis] = sphere.moment
                # (lever x P)_axis, with P on the first sphere and -P on the second.
                row[self.impulse + (axis + 2) % 3] = -sign * lever[(axis + 1) % 3]
                row[self.impulse + (axis + 1) % 3] = sign * lever[(axis + 2) % 3]
                self.add(row, sphere.moment * sphere.omega[axis])

    def contact_row(self, direction: Triple) -> list[arb]:
        """The coefficients of the relative velocity of the contact points along a direction.

        d . g = sum of s (d . v + d . (omega x r)) over the spheres, s = 1 and -1, r = s R n.
        """
        row = self.blank()
        for body, sphere in enumerate(self.spheres):
            sign = 1 - 2 * body
            lever = [sign * sphere.radius * x for x in self.normal]
            # direction.(omega x lever) = omega.(lever x direction).
            turned = product(lever, direction)
            for axis in range(3):
                row[6 * body + axis] = sign * direction[axis]
                row[6 * body + 3 + axis] = sign * turned[axis]
        return row

    def contact_speed(self, direction: Triple) -> arb:
        """The relative velocity of the contact points along a direction before the impact [m/s]."""
        before = []
        for sphere in self.spheres:
            before += [*sphere.v, *sphere.omega]
        before += [arb(0)] * 3
        return arb(along(self.contact_row(direction), before))

    def solved(self) -> list[arb]:
        """The unknowns, by elimination."""
        column = arb_mat([[side] for side in self.sides])
        unknowns = arb_mat(self.rows).solve(column)
        return [unknowns[row, 0] for row in range(self.count)]


def sticking(spheres: Sequence[Sphere], normal: Triple, e: arb, b: arb) -> list[arb]:
    """The unknowns of an impact without the friction limit: n.g' = -e n.g, t_i.g' = -b t_i.g."""
    system = Equations(spheres, normal)
    system.balances()
    system.add(system.contact_row(normal), -e * system.contact_speed(normal))
    for tangent in tangents(normal):
        system.add(system.contact_row(tangent), -b * system.contact_speed(tangent))
    return system.solved()


def sliding(spheres: Sequence[Sphere], normal: Triple, e: arb, mu: arb) -> list[arb]:
    """The unknowns of an impact at the friction limit: n.g' = -e n.g, and |P_t| = mu P_n.

    P lies in the plane of the normal n and of the slip before the impact, and P_t points against
    that slip.
    """
    system = Equations(spheres, normal)
    system.balances()
    system.add(system.contact_row(normal), -e * system.contact_speed(normal))
    first, second = tangents(normal)
    # The slip g_t = sum of (t_i . g)/(t_i . t_i) t_i; `against` is the unit vector a along it.
    parts = [system.contact_speed(t) / along(t, t) for t in (first, second)]
    slip = [parts[0] * x + parts[1] * y for x, y in zip(first, second, strict=True)]
    slip_speed = along(slip, slip).sqrt()
    against = [x / slip_speed for x in slip]
    across = product(normal, against)
    # P . (n x a) = 0 with the unit slip a.
    row = system.blank()
    row[system.impulse :] = across
    system.add(row, arb(0))
    # P.a = -mu |P.n|; P.n < 0 on the first sphere, so that P.a - mu P.n = 0.
    row = system.blank()
    row[system.impulse :] = [a - mu * n for a, n in zip(against, normal, strict=True)]
    system.add(row, arb(0))
    return system.solved()


def struck(
    spheres: Sequence[Sphere], normal: Triple, law: Mapping[str, arb]
) -> tuple[list[arb], Triple]:
    """The velocities after the impact, and the impulse on the first sphere."""
    # P_n = -P . n and P_t = P + P_n n; sliding if |P_t| > mu P_n.
    e = law["restitution"]
    unknowns = sticking(spheres, normal, e, law["tangential_restitution"])
    impulse = unknowns[-3:]
    pressing = -along(impulse, normal)
    rubbing = [p + pressing * n for p, n in zip(impulse, normal, strict=True)]
    mu = law["friction"]
    if along(rubbing, rubbing) > mu * mu * pressing * pressing:
        unknowns = sliding(spheres, normal, e, mu)
    return unknowns[:-3], unknowns[-3:]


def meeting(gap: Callable[[arb], arb], late: arb) -> arb:
    """The time in [0, late] at which `gap` changes from positive to negative, by bisection."""
    low = arb(0)
    high = late
    for _ in range(HALVINGS):
        middle = ((low + high) / 2).mid()
        if gap(middle) > 0:
            low = middle
        else:
            high = middle
    return high


def energy(spheres: Sequence[Sphere], velocities: Sequence[arb]) -> arb:
    """The kinetic energy sum of m v^2/2 + J omega^2/2 at these velocities [J]."""
    total = arb(0)
    for body, sphere in enumerate(spheres):
        v = velocities[6 * body : 6 * body + 3]
        omega = velocities[6 * body + 3 : 6 * body + 6]
        total += sphere.mass * along(v, v) / 2 + sphere.moment * along(omega, omega) / 2
    return total


def said(
    spheres: Sequence[Sphere],
    impact_time: arb,
    normal: Triple,
    law: Mapping[str, arb],
    times: Sequence[Fraction],
) -> Results:
    """The scalars, and the states at the times, of a motion with one impact.

    Each sphere moves uniformly before and after the impact.
    """
    after, impulse = struck(spheres, normal, law)
    before: list[arb] = []
    for sphere in spheres:
        before += [*sphere.v, *sphere.omega]
    pressing = -along(impulse, normal)
    rubbing = [p + pressing * n for p, n in zip(impulse, normal, strict=True)]
    yield (
        None,
        {
            "impact_time": impact_time,
            "normal_impulse": pressing,
            "tangential_impulse": length(rubbing),
            "energy_lost": energy(spheres, before) - energy(spheres, after),
        },
    )
    for t in times:
        since = arb_of(t) - impact_time
        values: dict[str, arb] = {}
        for body, sphere in enumerate(spheres):
            v = sphere.v
            omega = sphere.omega
            place = sphere.at(arb_of(t))
            if since > 0:
                v = after[6 * body : 6 * body + 3]
                omega = after[6 * body + 3 : 6 * body + 6]
                met = sphere.at(impact_time)
                place = [r + speed * since for r, speed in zip(met, v, strict=True)]
            for kind, triple in (("r", place), ("v", v), ("omega", omega)):
                for axis, name in enumerate("xyz"):
                    values[f"{kind}{body + 1}.{name}"] = triple[axis]
        yield t, values


def hard_spheres(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Two free spheres in the frame of their centre of mass."""
    masses = [arb_of(x) for x in vector(p, "masses")]
    radii = [arb_of(x) for x in vector(p, "radii")]
    factors = [arb_of(x) for x in vector(p, "inertia_factors")]
    spins = [arb_of(x) for x in vector(p, "spins")]
    speed = arb_of(number(p, "closing_speed"))
    reach = radii[0] + radii[1]
    # Distance and offset are in units of the sum of the radii.
    relative = (number(p, "distance"), *vector(p, "offset"))
    branch_at_start = [reach * arb_of(x) for x in relative]
    spheres = []
    for this, other, sign in ((0, 1, -1), (1, 0, 1)):
        # About the centre of mass: r1 = -m2/(m1 + m2) r, r2 = m1/(m1 + m2) r with r = r2 - r1.
        share = sign * masses[other] / (masses[0] + masses[1])
        moment_of_inertia = factors[this] * masses[this] * radii[this] * radii[this]
        place = [share * x for x in branch_at_start]
        velocity = [-share * speed, arb(0), arb(0)]
        spin = spins[3 * this : 3 * this + 3]
        spheres.append(Sphere(masses[this], moment_of_inertia, radii[this], place, velocity, spin))

    def branch(t: arb) -> Triple:
        """The branch vector r2 - r1 of the centres at t."""
        return [b - a for a, b in zip(spheres[0].at(t), spheres[1].at(t), strict=True)]

    # The spheres touch where |r2 - r1| = R1 + R2. When the x component of r2 - r1 is 0, their
    # distance is below R1 + R2, which gives the upper end of the bisection.
    too_late = branch_at_start[0] / speed
    impact_time = meeting(lambda t: along(branch(t), branch(t)) - reach * reach, too_late)
    normal = [x / reach for x in branch(impact_time)]
    law = {name: arb_of(number(p, name)) for name in LAW}
    yield from said(spheres, impact_time, normal, law, times)


def hard_wall(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """One sphere and a wall through the origin."""
    normal = [arb_of(x) for x in vector(p, "normal")]
    norm = length(normal)
    into = [-x / norm for x in normal]
    mass = arb_of(number(p, "mass"))
    radius = arb_of(number(p, "radius"))
    sphere = Sphere(
        mass,
        arb_of(number(p, "inertia_factor")) * mass * radius * radius,
        radius,
        [arb_of(x) for x in vector(p, "position")],
        [arb_of(x) for x in vector(p, "velocity")],
        [arb_of(x) for x in vector(p, "spin")],
    )
    # With the unit normal n into the wall the sphere touches where -r . n = R. The centre would
    # reach the wall, r . n = 0, at t = -(r . n)/(v . n): the upper end of the bisection.
    through = -along(sphere.r, into) / along(sphere.v, into)
    impact_time = meeting(lambda t: -along(sphere.at(t), into) - radius, through)
    law = {name: arb_of(number(p, name)) for name in LAW}
    for t, values in said([sphere], impact_time, into, law, times):
        if t is None:
            yield t, values
        else:
            yield t, {name.replace("1", ""): value for name, value in values.items()}


WITNESSES = {
    "hard-spheres": Witness(METHOD, hard_spheres),
    "hard-wall": Witness(METHOD, hard_wall),
}
