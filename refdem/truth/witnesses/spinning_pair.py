"""Witness of two spheres that spin about any axes: Newton's and Euler's laws of each body in
vectors in space, phase by phase.

The state s is r, v, omega of body 1 (0 to 8), the same of body 2 (9 to 17), and the stretch of the
tangential spring (18 to 20), each with three components in axes of space. n = (r2 - r1)/|r2 - r1|
is the unit vector from body 1 to body 2, d = R1 + R2 - |r2 - r1| the overlap and v = v1 - v2 the
relative velocity, so that d' = v.n. The normal force F = k d + c v.n acts along -n on body 1 and
along n on body 2.

Phases: "free" (no friction), "slip" (k_t = 0), "stick" (the spring is within its limit), "clip"
(the spring stays at its limit mu F/k_t); "apart" ends the contact.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property, partial
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.cross_check import Claimed, Results
from refdem.truth.witnesses.taylor import Solution

GRID = 256
"""Steps per claimed duration in the search for the end of a phase. The first step after a switch is
2^-12 of that, and each next one twice as long, up to the full step.
"""
Vector = Sequence[Any]


def dot(a: Vector, b: Vector) -> Any:
    """The dot product a . b of two vectors."""
    return sum((x * y for x, y in zip(a[1:], b[1:], strict=True)), a[0] * b[0])


def crossed(a: Vector, b: Vector) -> list[Any]:
    """The cross product a x b of two vectors (3)."""
    return [a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3] for i in range(3)]


def plus(a: Vector, b: Vector, factor: Any = 1) -> list[Any]:
    """The vector a + factor b, component by component."""
    return [x + y * factor for x, y in zip(a, b, strict=True)]


class ContactState:
    """The geometry and the forces of a contact in one state, each computed once."""

    def __init__(self, bodies: "Bodies", s: Vector) -> None:
        # v = v1 - v2,  n = (r2 - r1)/|r2 - r1|,  d = R1 + R2 - |r2 - r1|
        self.bodies = bodies
        self.s = s
        self.velocity = plus(s[3:6], s[12:15], -1)
        branch = plus(s[9:12], s[0:3], -1)
        self.distance = dot(branch, branch).sqrt()
        self.normal = [x / self.distance for x in branch]
        self.along = dot(self.velocity, self.normal)
        self.overlap = bodies.radii[0] + bodies.radii[1] - self.distance

    @cached_property
    def force(self) -> Any:
        """The normal force F = k d + c v.n."""
        return self.bodies.k * self.overlap + self.bodies.c * self.along

    @cached_property
    def arms(self) -> list[list[Any]]:
        """The arms (3) of the slip from the centres: (R1 - beta d) n and -(R2 - beta d) n."""
        return self._shortened(self.bodies.beta)

    @cached_property
    def torque_arms(self) -> list[list[Any]]:
        """The arms (3) of the torque of friction, of the same form with the beta of the torque."""
        return self._shortened(self.bodies.torque_beta)

    def _shortened(self, beta: Any) -> list[list[Any]]:
        """The vectors (R1 - beta d) n and -(R2 - beta d) n (3)."""
        shortening = beta * self.overlap
        return [
            [x * (radius - shortening) * sign for x in self.normal]
            for radius, sign in zip(self.bodies.radii, (1, -1), strict=True)
        ]

    @cached_property
    def slip(self) -> list[Any]:
        """The tangential velocity (3) of surface 1 relative to surface 2."""
        # u = (v1 + omega1 x arm1) - (v2 + omega2 x arm2);  slip = u - (u . n) n
        s = self.s
        arm1, arm2 = self.arms
        surface1 = plus(s[3:6], crossed(s[6:9], arm1))
        surface2 = plus(s[12:15], crossed(s[15:18], arm2))
        relative = plus(surface1, surface2, -1)
        return plus(relative, self.normal, -dot(relative, self.normal))

    @cached_property
    def across(self) -> list[Any]:
        """The tangential part v - (v.n) n (3) of the relative velocity."""
        return plus(self.velocity, self.normal, -self.along)

    @cached_property
    def growth(self) -> Any:
        """The rate dF/dt = k d' + c d'' of the normal force.

        d' = v.n and d'' = a.n + v.n', with a.n = -F (1/m1 + 1/m2) and n' = -(v - (v.n) n)/|r|,
        r = r1 - r2.
        """
        bodies = self.bodies
        # dF/dt = k v.n + c (a.n + v.n'), and v.n' = -v . (v - (v.n) n)/|r|.
        normal_acceleration = -self.force * (1 / bodies.masses[0] + 1 / bodies.masses[1])
        turning = dot(self.velocity, self.across) / self.distance
        return bodies.k * self.along + bodies.c * (normal_acceleration - turning)

    @cached_property
    def excess(self) -> Any:
        """The rate [N/s] at which the slip would stretch a spring at its limit beyond that limit.

        It is k_t slip.s/|s| - mu dF/dt with the stretch s. The contact sticks again where it
        becomes 0.
        """
        stretch = self.s[18:21]
        stretching = self.bodies.kt * dot(self.slip, stretch) / dot(stretch, stretch).sqrt()
        return stretching - self.bodies.mu * self.growth

    def friction(self, phase: str) -> list[Any]:
        """The friction force (3) on body 1 in a phase.

        stick and clip: -k_t s with the stretch s; slip: -mu F slip/|slip|; free: 0.
        """
        if phase in ("stick", "clip"):
            return [x * -self.bodies.kt for x in self.s[18:21]]
        if phase == "free":
            return [x * 0 for x in self.s[:3]]
        limit = self.bodies.mu * self.force / dot(self.slip, self.slip).sqrt()
        return [-x * limit for x in self.slip]

    def stretch_rate(self, phase: str) -> list[Any]:
        """The rate (3) of the spring's stretch s.

        stick: s' = slip + (n x n') x s; the second term turns s with the normal.
        clip: |s| = mu F/k_t, so that |s|'/|s| = F'/F. The part (slip . s)/(s . s) s of s' along s
        is replaced by (F'/F) s.
        """
        stretch = self.s[18:21]
        if phase not in ("stick", "clip"):
            return [x * 0 for x in stretch]
        normal_rate = [-x / self.distance for x in self.across]
        turned = crossed(crossed(self.normal, normal_rate), stretch)
        # s' = slip + (n x n') x s while the contact sticks.
        free_rate = plus(self.slip, turned)
        if phase == "stick":
            return free_rate
        # At the limit: s' + (F'/F - (slip . s)/(s . s)) s, so that |s|'/|s| = F'/F.
        own_growth = dot(self.slip, stretch) / dot(stretch, stretch)
        return plus(free_rate, stretch, self.growth / self.force - own_growth)


class Bodies:
    """Two spheres with their contact law, from the parameters of the case two-spheres."""

    def __init__(self, p: Mapping[str, Exact]) -> None:
        self.masses = [arb_of(mass) for mass in vector(p, "masses")]
        self.radii = [arb_of(radius) for radius in vector(p, "radii")]
        self.moments = [m * r * r * 2 / 5 for m, r in zip(self.masses, self.radii, strict=True)]
        # beta of the arms of the slip and of the torque; "slip-R" has 0 and 1/2.
        branch = str(p["branch"])
        self.beta = {"R": arb(0), "R-d/2": arb(1) / 2, "R-d": arb(1), "slip-R": arb(0)}[branch]
        self.torque_beta = self.beta
        if branch == "slip-R":
            self.torque_beta = arb(1) / 2
        names = ("stiffness", "damping", "tangential_stiffness", "friction")
        self.k, self.c, self.kt, self.mu = (arb_of(number(p, name)) for name in names)
        self.pulls = p["cutoff"] == "zero_overlap" and number(p, "damping") > 0

    def start(self, p: Mapping[str, Exact]) -> list[arb]:
        """The state at first touch: the centres on the x axis, the centre of mass at rest.

        r1 - r2 = (-(R1 + R2), 0, 0), and v1 - v2 has the size of the closing speed and makes the
        angle `angle` with the x axis. Each body has the share m2/(m1 + m2) or -m1/(m1 + m2).
        """
        spins = vector(p, "spins")
        m1, m2 = self.masses
        radii_sum = sum(self.radii, arb(0))
        speed = arb_of(number(p, "closing_speed"))
        sine, cosine = arb_of(number(p, "angle")).sin_cos()
        zero = arb(0)
        state: list[arb] = []
        for share, spin in ((m2 / (m1 + m2), spins[:3]), (-m1 / (m1 + m2), spins[3:])):
            # r1 - r2 = (-(R1 + R2), 0, 0): body 1 has the share m2/M, body 2 the share -m1/M.
            position = [-share * radii_sum, zero, zero]
            velocity = [share * speed * cosine, share * speed * sine, zero]
            state += [*position, *velocity, *map(arb_of, spin)]
        return [*state, zero, zero, zero]

    def overlap(self, s: Vector) -> Any:
        """The overlap d of the spheres in state s."""
        return ContactState(self, s).overlap

    def force(self, s: Vector) -> Any:
        """The normal force between the spheres in state s."""
        return ContactState(self, s).force

    def rates(self, phase: str, t: Any, s: Vector) -> list[Any]:
        """The right-hand side of the equations of motion in a phase.

        r1' = v1,    m1 v1' = f - F n,     J1 omega1' = arm1 x f,
        r2' = v2,    m2 v2' = -f + F n,    J2 omega2' = arm2 x (-f)
        """
        contact = ContactState(self, s)
        friction = contact.friction(phase)
        total_force = plus(friction, contact.normal, -contact.force)
        rates: list[Any] = []
        for i, sign in ((0, 1), (1, -1)):
            torque = crossed(contact.torque_arms[i], friction)
            velocity = s[9 * i + 3 : 9 * i + 6]
            acceleration = [x * sign / self.masses[i] for x in total_force]
            spin_rate = [x * sign / self.moments[i] for x in torque]
            rates += [*velocity, *acceleration, *spin_rate]
        return [*rates, *contact.stretch_rate(phase)]

    def ends(self, phase: str) -> dict[str, Callable[[Vector], Any]]:
        """The functions that are positive within a phase, by the name of what follows their zero.

        The contact ends where d = 0 if the normal force may pull (`pulls`), otherwise where F = 0.
        """
        if phase == "stick":
            return {"clip": self.margin}
        if phase == "free":
            if self.pulls:
                return {"apart": self.overlap}
            return {"apart": self.force}
        ends: dict[str, Callable[[Vector], Any]] = {}
        if self.pulls:
            ends["free"] = self.force
        else:
            ends["apart"] = self.force
        if phase == "clip":
            ends["stick"] = lambda s: ContactState(self, s).excess
        return ends

    def margin(self, s: Vector) -> Any:
        """How far the force of the spring is from its limit in state s, mu F - k_t |stretch|."""
        return self.mu * self.force(s) - self.kt * dot(s[18:21], s[18:21]).sqrt()


def spinning(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """r, v and omega of both spheres, and the duration of the contact if that is claimed.

    No values are given for spheres without slip at first touch: friction has no direction there.
    """
    pair = Bodies(p)
    if all(component == 0 for component in ContactState(pair, pair.start(p)).slip):
        return
    if "duration" in claimed:
        longest = float(claimed["duration"])
    else:
        longest = float(max(times))
    contact = list(phases(pair, pair.start(p), longest))
    last_phase, end = contact[-1]
    if "duration" in claimed:
        yield None, {"duration": end}
    names = [
        f"{name}{body}.{axis}" for body in (1, 2) for name in ("r", "v", "omega") for axis in "xyz"
    ]
    for t in times:
        time = arb_of(t)
        solution = next((solution for solution, until in contact if time <= until), None)
        if solution is None:
            state = flown(last_phase.at(end), time - end)
        else:
            state = solution.at(t)
        # The last three components of the state, the stretch, have no name.
        yield t, dict(zip(names, state, strict=False))


def phases(pair: Bodies, s: list[arb], longest: float) -> Iterator[tuple[Solution, arb]]:
    """Each phase as its solution and its end [s].

    A phase without an end is cut off at 1.1 `longest` [s].
    """
    if pair.kt > 0:
        phase = "stick"
    else:
        phase = "slip"
    t = arb(0)
    while phase != "apart":
        solution = Solution(partial(pair.rates, phase), s, begin=t)
        end = switch(solution, pair.ends(phase), float(t), longest)
        if end is None:
            yield solution, arb(1.1 * longest)
            return
        phase, t = end
        yield solution, t
        s = solution.at(t)


def switch(
    solution: Solution, values: Mapping[str, Callable[[Vector], Any]], begin: float, longest: float
) -> tuple[str, arb] | None:
    """The name and the time of the first function that falls below 0; None if none does.

    The functions are sampled in steps that grow (GRID), and a zero is refined by the secant method.
    """
    # A function may be 0 at `begin` itself: the search starts 2^-12 of a grid step later.
    low = begin + longest / GRID / 4096
    step = longest / GRID / 4096
    while low < 1.1 * longest:
        high = low + step
        fallen = [name for name, value in values.items() if value(solution.at(arb(high))) < 0]
        if fallen:
            crossings = [
                (solution.crossing(values[name], (low + high) / 2, (high - low) / 2), name)
                for name in fallen
            ]
            time, name = min(crossings, key=lambda pair: float(pair[0]))
            return name, time
        low = high
        step = min(2 * step, longest / GRID)
    return None


def flown(s: Sequence[arb], t: arb) -> list[arb]:
    """The state of both bodies after a free flight of t [s]: r + v t, the rest unchanged."""
    moved = list(s)
    for i in (0, 9):
        moved[i : i + 3] = plus(s[i : i + 3], s[i + 3 : i + 6], t)
    return moved
