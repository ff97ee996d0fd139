"""Witness of two spheres that spin about any axes: Newton's and Euler's laws for each body, with
cross products, phase by phase.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property, partial
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.taylor import Solution
from refdem.truth.witnesses.testimony import Claimed, Said

GRID = 256
"""Looks for a switch in a contact; the first ones after a switch are 2^-12 of that apart, then
twice as far, and so on.
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


class Moment:
    """What follows from one state; each of it is worked out once."""

    def __init__(self, its: "Bodies", s: Vector) -> None:
        self.its = its
        self.s = s
        self.apart = plus(s[3:6], s[12:15], -1)
        way = plus(s[9:12], s[0:3], -1)
        self.distance = dot(way, way).sqrt()
        self.normal = [x / self.distance for x in way]
        self.along = dot(self.apart, self.normal)
        self.overlap = its.radii[0] + its.radii[1] - self.distance

    @cached_property
    def force(self) -> Any:
        """The normal force between the two spheres."""
        return self.its.k * self.overlap + self.its.c * self.along

    @cached_property
    def arms(self) -> list[list[Any]]:
        """The vectors (3) from the centres to where friction acts."""
        shorter = self.its.beta * self.overlap
        return [
            [x * (radius - shorter) * sense for x in self.normal]
            for radius, sense in zip(self.its.radii, (1, -1), strict=True)
        ]

    @cached_property
    def slip(self) -> list[Any]:
        """Tangential velocity of surface 1 against surface 2."""
        s = self.s
        (one, other) = self.arms
        first = plus(s[3:6], crossed(s[6:9], one))
        second = plus(s[12:15], crossed(s[15:18], other))
        apart = plus(first, second, -1)
        return plus(apart, self.normal, -dot(apart, self.normal))

    @cached_property
    def across(self) -> list[Any]:
        """Relative velocity of 1 but for what is along the normal."""
        return plus(self.apart, self.normal, -self.along)

    @cached_property
    def growth(self) -> Any:
        """dF/dt = k d' + c d'': d' = v.n, d'' = a.n + v.n', n' = -(v across)/distance."""
        pressed = -self.force * (1 / self.its.masses[0] + 1 / self.its.masses[1])
        return self.its.k * self.along + self.its.c * (
            pressed - dot(self.apart, self.across) / self.distance
        )

    @cached_property
    def lag(self) -> Any:
        """How much faster the slip stretches the spring than the limit grows, as rates of force."""
        stretch = self.s[18:21]
        return (
            self.its.kt * dot(self.slip, stretch) / dot(stretch, stretch).sqrt()
            - self.its.mu * self.growth
        )

    def friction(self, phase: str) -> list[Any]:
        """The friction force (3) on body 1, where the spring stands or the surfaces slip."""
        if phase in ("stick", "clip"):
            return [x * -self.its.kt for x in self.s[18:21]]
        if phase == "free":
            return [x * 0 for x in self.s[:3]]
        limit = self.its.mu * self.force / dot(self.slip, self.slip).sqrt()
        return [-x * limit for x in self.slip]

    def stretching(self, phase: str) -> list[Any]:
        """The rate (3) of the spring: it turns with the normal and takes the slip; clipped, it
        keeps mu F/k_t in place of its own growth.
        """
        stretch = self.s[18:21]
        if phase not in ("stick", "clip"):
            return [x * 0 for x in stretch]
        turn = [-x / self.distance for x in self.across]
        carried = plus(self.slip, crossed(crossed(self.normal, turn), stretch))
        if phase == "stick":
            return carried
        return plus(
            carried,
            stretch,
            self.growth / self.force - dot(self.slip, stretch) / dot(stretch, stretch),
        )


class Bodies:
    """State: r, v, omega of body 1, the same of body 2, stretch of the tangential spring."""

    def __init__(self, p: Mapping[str, Exact]) -> None:
        self.masses, self.radii = (
            [arb_of(x) for x in vector(p, name)] for name in ("masses", "radii")
        )
        self.moments = [m * r * r * 2 / 5 for m, r in zip(self.masses, self.radii, strict=True)]
        self.beta = {"R": arb(0), "R-d/2": arb(1) / 2, "R-d": arb(1)}[str(p["branch"])]
        names = ("stiffness", "damping", "tangential_stiffness", "friction")
        self.k, self.c, self.kt, self.mu = (arb_of(number(p, name)) for name in names)
        self.pulls = p["cutoff"] == "zero_overlap" and number(p, "damping") > 0

    def start(self, p: Mapping[str, Exact]) -> list[arb]:
        """Touching on x, centre of mass at rest."""
        spins, (m1, m2), reach = vector(p, "spins"), self.masses, sum(self.radii, arb(0))
        speed = arb_of(number(p, "closing_speed"))
        (sine, cosine) = arb_of(number(p, "angle")).sin_cos()
        state: list[arb] = []
        for share, turning in ((m2 / (m1 + m2), spins[:3]), (-m1 / (m1 + m2), spins[3:])):
            state += [
                -share * reach,
                arb(0),
                arb(0),
                share * speed * cosine,
                share * speed * sine,
                arb(0),
                *map(arb_of, turning),
            ]
        return [*state, arb(0), arb(0), arb(0)]

    def overlap(self, s: Vector) -> Any:
        return Moment(self, s).overlap

    def force(self, s: Vector) -> Any:
        """The normal force between the spheres in state s."""
        return Moment(self, s).force

    def rates(self, phase: str, t: Any, s: Vector) -> list[Any]:
        """r' = v, m v' = -F n + f, J omega' = arm x f; the reaction on body 2."""
        now = Moment(self, s)
        rub = now.friction(phase)
        push = plus(rub, now.normal, -now.force)
        found: list[Any] = []
        for i, sense in ((0, 1), (1, -1)):
            turned = crossed(now.arms[i], rub)
            found += [
                *s[9 * i + 3 : 9 * i + 6],
                *(x * sense / self.masses[i] for x in push),
                *(x * sense / self.moments[i] for x in turned),
            ]
        return [*found, *now.stretching(phase)]

    def ends(self, phase: str) -> dict[str, Callable[[Vector], Any]]:
        """What is positive within a phase, by what follows."""
        if phase == "free":
            return {"apart": self.overlap if self.pulls else self.force}
        if phase == "stick":
            return {
                "clip": lambda s: self.mu * self.force(s) - self.kt * dot(s[18:21], s[18:21]).sqrt()
            }
        over: dict[str, Callable[[Vector], Any]] = {("free" if self.pulls else "apart"): self.force}
        if phase == "clip":
            over["stick"] = lambda s: Moment(self, s).lag
        return over


def spinning(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The 18 quantities, and when the force ends if that is claimed."""
    pair = Bodies(p)
    if all(part == 0 for part in Moment(pair, pair.start(p)).slip):
        return
    if "duration" in claimed:
        longest = float(claimed["duration"])
    else:
        longest = float(max(times))
    course = list(phases(pair, pair.start(p), longest))
    if "duration" in claimed:
        yield None, {"duration": course[-1][1]}
    names = [
        f"{kind}{body}.{axis}" for body in (1, 2) for kind in ("r", "v", "omega") for axis in "xyz"
    ]
    for t in times:
        now = next((solution.at(t) for solution, until in course if arb_of(t) <= until), None)
        yield (
            t,
            dict(
                zip(
                    names,
                    now or flown(course[-1][0].at(course[-1][1]), arb_of(t) - course[-1][1]),
                    strict=False,
                )
            ),
        )


def phases(pair: Bodies, s: list[arb], longest: float) -> Iterator[tuple[Solution, arb]]:
    """Each phase as a solution, and when it ends, at the latest a little after the longest."""
    if pair.kt > 0:
        phase = "stick"
    else:
        phase = "slip"
    t = arb(0)
    while phase != "apart":
        solution = Solution(partial(pair.rates, phase), s, begin=t)
        found = switch(solution, pair.ends(phase), float(t), longest)
        if found is None:
            yield solution, arb(1.1 * longest)
            return
        phase, t = found
        yield solution, t
        s = solution.at(t)


def switch(
    solution: Solution, values: Mapping[str, Callable[[Vector], Any]], begin: float, longest: float
) -> tuple[str, arb] | None:
    """Which function is the first to fall through zero, and when."""
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
    """The state of both bodies after a free flight."""
    moved = list(s)
    for i in (0, 9):
        moved[i : i + 3] = plus(s[i : i + 3], s[i + 3 : i + 6], t)
    return moved
