"""Witnesses of colliding spheres: Newton's law in Cartesian vectors, phase by phase; switches by
sign changes on a grid and the secant.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.spinning_pair import spinning
from refdem.truth.witnesses.taylor import Solution
from refdem.truth.witnesses.testimony import Claimed, Said, Witness

METHOD = (
    "Taylor integration in Cartesian coordinates, phase by phase, at 58 digits, unproven"
    " (refdem/truth/witnesses/collisions.py)"
)
GRID = 256
"""Looks for a switch in the claimed duration; the first ones after a switch are 2^-12 of that
apart, then twice as far, and so on.
"""
Value = Callable[[Sequence[Any]], Any]


class Colliding(ABC):
    """A contact phase by phase, under the linear law: what ends a phase, and what begins.

    State x, y, vx, vy of r1 - r2, spins about z, stretch of the tangential spring, if a class says
    nothing else. Friction f on body 1 along t = e turned by +90 degrees, e = r/|r|; its torque on
    each is -l f.
    """

    k: arb
    kt: arb
    mu: arb
    reach: arb
    beta: arb
    pulls: bool

    @abstractmethod
    def geometry(self, s: Sequence[Any]) -> tuple[Any, Any, Any, Any, Any, Any]:
        """e, distance, velocities along e and t, normal force."""

    @abstractmethod
    def slip(self, s: Sequence[Any]) -> Any:
        """Velocity of the surfaces against each other along t."""

    @abstractmethod
    def holding(self, s: Sequence[Any]) -> Any:
        """The friction f with which slip' = 0."""

    @abstractmethod
    def growth(self, s: Sequence[Any]) -> Any:
        """The rate dF/dt of the normal force."""

    @abstractmethod
    def law(self, phase: str) -> Value:
        """Friction in a phase: free, slip+, slip-, stick, hold."""

    @abstractmethod
    def field(self, friction: Value) -> Callable[[Any, Sequence[Any]], list[Any]]:
        """The rates under a friction."""

    @abstractmethod
    def after(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        """Phase and state after what ends one."""

    def force(self, s: Sequence[Any]) -> Any:
        """The force along the normal."""
        return self.geometry(s)[5]

    def overlap(self, s: Sequence[Any]) -> Any:
        """The overlap of the two surfaces."""
        return self.reach - self.geometry(s)[2]

    def plain_law(self, phase: str) -> Value:
        """Friction in a phase of a state whose seventh number is the stretch."""
        if phase == "slip-":
            side = -1
        else:
            side = 1
        laws: dict[str, Value] = {
            "stick": lambda s: -self.kt * s[6],
            "hold": self.holding,
            "free": lambda s: 0 * s[0],
        }
        return laws.get(phase, lambda s: -side * self.mu * self.force(s))

    def spared(self, phase: str, side: int, s: Sequence[Any]) -> Any:
        """What friction has left towards one side of its limit."""
        return self.mu * self.force(s) + side * self.law(phase)(s)

    def ends(self, phase: str) -> dict[str, Value]:
        """What is positive within a phase, by what follows."""
        if phase in ("stick", "hold"):
            return {
                f"slip{sign}": partial(self.spared, phase, side) for sign, side in SIDES.items()
            }
        if phase == "free":
            return {"apart": self.overlap if self.pulls else self.force}
        side = SIDES[phase[-1]]

        def back(s: Any) -> Any:
            if self.kt > 0:
                return side * self.kt * self.slip(s) - self.mu * self.growth(s)
            return side * self.slip(s)

        return {"caught": back, ("free" if self.pulls else "apart"): self.force}

    def begin(self, s: Sequence[arb]) -> str:
        """The name of the phase that begins at touch."""
        slip = self.slip(s)
        force = self.force(s)
        if not self.mu > 0:
            return "free"
        if not (slip > 0 or slip < 0) or (self.kt > 0 and force > 0):
            holds = self.kt > 0 or abs(self.holding(s)) < self.mu * force
            if holds:
                return "stick" if self.kt > 0 else "hold"
            if self.holding(s) > 0:
                return "slip-"
            return "slip+"
        slides = not self.kt > 0 or self.kt * abs(slip) > self.mu * self.growth(s)
        if slides:
            return "slip+" if slip > 0 else "slip-"
        return "stick"

    def caught_or_slipped(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        """Phase and state after what ends one."""
        if then != "caught":
            return then, list(s)
        if self.kt > 0:
            return "stick", [*s[:6], SIDES[phase[-1]] * self.mu * self.force(s) / self.kt]
        holds = abs(self.holding(s)) < self.mu * self.force(s)
        return "hold" if holds else "slip-" if phase == "slip+" else "slip+", list(s)


class Spheres(Colliding):
    """Two free spheres that touch."""

    def __init__(self, p: Mapping[str, Any]) -> None:
        masses = [arb_of(mass) for mass in p["masses"]]
        self.radii = [arb_of(radius) for radius in p["radii"]]
        self.reach = self.radii[0] + self.radii[1]
        self.moments = [m * r * r * 2 / 5 for m, r in zip(masses, self.radii, strict=True)]
        self.mass = masses[0] * masses[1] / (masses[0] + masses[1])
        self.beta = {"R": arb(0), "R-d/2": arb(1) / 2, "R-d": arb(1)}[str(p["branch"])]
        names = ("stiffness", "damping", "tangential_stiffness", "friction")
        self.k, self.c, self.kt, self.mu = (arb_of(p[name]) for name in names)
        self.pulls = p["cutoff"] == "zero_overlap" and p["damping"] > 0

    def geometry(self, s: Sequence[Any]) -> tuple[Any, Any, Any, Any, Any, Any]:
        """e, distance, velocities along e and t, normal force."""
        x, y, vx, vy = s[:4]
        distance = (x * x + y * y).sqrt()
        ex = x / distance
        ey = y / distance
        along = vx * ex + vy * ey
        return (
            ex,
            ey,
            distance,
            along,
            vy * ex - vx * ey,
            self.k * (self.reach - distance) - self.c * along,
        )

    def levers(self, distance: Any) -> list[Any]:
        return [radius - self.beta * (self.reach - distance) for radius in self.radii]

    def slip(self, s: Sequence[Any]) -> Any:
        _, _, distance, _, across, _ = self.geometry(s)
        first, second = self.levers(distance)
        return across - first * s[4] - second * s[5]

    def holding(self, s: Sequence[Any]) -> Any:
        """The f with slip' = 0: 0 = f/m - v_e v_t/|r| - beta v_e (w1 + w2) + f (l1^2/J1 +
        l2^2/J2).
        """
        _, _, distance, along, across, _ = self.geometry(s)
        ease = 1 / self.mass + sum(
            lever * lever / moment
            for lever, moment in zip(self.levers(distance), self.moments, strict=True)
        )
        return (along * across / distance + self.beta * along * (s[4] + s[5])) / ease

    def growth(self, s: Sequence[Any]) -> Any:
        """dF/dt = k d' + c d'', d'' = -F/m - v_t^2/|r|."""
        _, _, distance, along, across, force = self.geometry(s)
        return -self.k * along - self.c * (force / self.mass + across * across / distance)

    def field(self, friction: Value) -> Callable[[Any, Sequence[Any]], list[Any]]:
        """The rates under a friction."""

        def rates(t: Any, s: Sequence[Any]) -> list[Any]:
            ex, ey, distance, _, _, force = self.geometry(s)
            f = friction(s)
            spun = [
                -lever * f / moment
                for lever, moment in zip(self.levers(distance), self.moments, strict=True)
            ]
            return [
                s[2],
                s[3],
                (force * ex - f * ey) / self.mass,
                (force * ey + f * ex) / self.mass,
                *spun,
                self.slip(s),
            ]

        return rates

    def law(self, phase: str) -> Value:
        return self.plain_law(phase)

    def after(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        return self.caught_or_slipped(phase, then, s)


SIDES = {"+": 1, "-": -1}


def phases(pair: Colliding, start: Sequence[arb], longest: float) -> Iterator[tuple[Solution, arb]]:
    """Each phase as a solution, and when it ends."""
    phase = pair.begin(start)
    s = list(start)
    t = arb(0)
    while phase != "apart":
        solution = Solution(pair.field(pair.law(phase)), s, begin=t)
        found = first_switch(solution, pair.ends(phase), float(t), longest)
        if found is None:
            return
        then, end = found
        yield solution, end
        phase, s = pair.after(phase, then, solution.at(end))
        t = end


def first_switch(
    solution: Solution, values: Mapping[str, Value], begin: float, longest: float
) -> tuple[str, arb] | None:
    """Which function is the first to fall through zero, and when."""
    low = begin + longest / GRID / 4096
    step = longest / GRID / 4096
    while low < 1.1 * longest:
        high = low + step
        state = solution.at(arb(high))
        fallen = [name for name, value in values.items() if value(state) < 0]
        crossings = [
            (solution.crossing(values[name], (low + high) / 2, (high - low) / 2), name)
            for name in fallen
        ]
        if crossings:
            time, name = min(crossings, key=lambda pair: float(pair[0]))
            return name, time
        low = high
        step = min(2 * step, longest / GRID)
    return None


def two_spheres(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """What turns out of the plane is said by spinning_pair.py; nothing is said of a contact in the
    plane that never ends.
    """
    spins = vector(p, "spins")
    masses = vector(p, "masses")
    slips = number(p, "angle") or any(spins[axis] for axis in (1, 2, 4, 5))
    if number(p, "friction") > 0 and slips and any(spins[axis] for axis in (0, 1, 3, 4)):
        yield from spinning(p, times, claimed)
        return
    if "duration" not in claimed:
        return
    pair = Spheres(p)
    speed = arb_of(number(p, "closing_speed"))
    sine, cosine = arb_of(number(p, "angle")).sin_cos()
    start = [
        -pair.reach,
        arb(0),
        speed * cosine,
        speed * sine,
        arb_of(spins[2]),
        arb_of(spins[5]),
        arb(0),
    ]
    course = list(phases(pair, start, float(claimed["duration"])))
    if not course:
        return
    end = course[-1][1]
    last = course[-1][0].at(course[-1][1])
    yield None, {"duration": end}
    for t in times:
        now = next(
            (solution.at(t) for solution, until in course if arb_of(t) < until), None
        ) or flown(last, arb_of(t) - end)
        found = {
            f"omega{body + 1}.{'xyz'[i]}": arb_of(spins[3 * body + i])
            for body in (0, 1)
            for i in (0, 1)
        }
        for body, sign in ((1, 1), (2, -1)):
            share = arb_of(sign * masses[2 - body] / sum(masses))
            found |= {
                f"{kind}{body}.{axis}": share * now[2 * (kind == "v") + "xy".index(axis)]
                for kind in "rv"
                for axis in "xy"
            }
        yield t, found | {"omega1.z": now[4], "omega2.z": now[5]}


def flown(s: Sequence[arb], t: arb) -> list[arb]:
    """The state after a free flight of time t."""
    return [s[0] + s[2] * t, s[1] + s[3] * t, *s[2:]]


def pressed(mass: arb, stiffness: arb, exponent: Fraction, speed: arb) -> tuple[Solution, arb]:
    """m d'' = -k d^n from touch in w = sqrt(d), by a time s with dt = 2 w ds: w' = v, v' = -(2k/m)
    w^(2n+1), t' = 2w; and the s at which v = 0.
    """
    power = int(2 * exponent + 1)

    def field(s: Any, y: Sequence[Any]) -> list[Any]:
        steep = y[0]
        for _ in range(power - 1):
            steep = steep * y[0]
        return [y[1], -2 * stiffness / mass * steep, 2 * y[0]]

    found = Solution(field, [arb(0), speed, arb(0)])
    # Any small step finds where v changes its sign; the crossing is refined from there.
    step = float((mass / stiffness / speed).mid()) ** (1 / (power + 1)) / 8
    high = step
    while found.at(arb(high))[1] > 0:
        high += step
    return found, found.crossing(lambda y: y[1], high - step / 2, step / 2)


def at_time(found: Solution, turn: arb, t: arb) -> tuple[arb, arb]:
    """Overlap and rate at the time t since touch, up to a little beyond the turn, from the curve in
    s.
    """
    low = 0.0
    high = float(turn) * 1.01
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if found.at(arb(middle))[2] < t else (low, middle)
    s = found.crossing(lambda y: y[2] - t, (low + high) / 2, (high - low) / 2 + float(turn) * 1e-9)
    w, v, _ = found.at(s)
    return w * w, v


def hertz(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The way out is the way in, run back."""
    mass, stiffness, speed = (
        arb_of(number(p, name)) for name in ("effective_mass", "stiffness", "closing_speed")
    )
    found, turn = pressed(mass, stiffness, Fraction(3, 2), speed)
    w, _, half = found.at(turn)
    yield None, {"duration": 2 * half, "max_overlap": w * w, "max_force": stiffness * w * w * w}
    for t in times:
        time = arb_of(t)
        left = 2 * half - time
        if left < 0:
            yield t, {"overlap": speed * left, "v": -speed}
            continue
        overlap, rate = at_time(found, turn, time if time < half else left)
        yield t, {"overlap": overlap, "v": rate if time < half else -rate}


def wedge(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The collision with a wedge: in with k2 d^2, out with k1 d."""
    mass, k1, k2, speed = (
        arb_of(number(p, name)) for name in ("mass", "k1", "k2", "closing_speed")
    )
    found, turn = pressed(mass, k2, Fraction(2), speed)
    w, _, half = found.at(turn)
    out = Solution(lambda t, y: [y[1], -k1 / mass * y[0]], [w * w, arb(0)])
    lasts = 1.5708 * float((mass / k1).sqrt())
    end = out.crossing(lambda y: y[0], lasts, lasts / 16)
    last = out.at(end)[1]
    yield (
        None,
        {
            "duration": half + end,
            "max_overlap": w * w,
            "energy_change": mass / 2 * (last * last - speed * speed),
        },
    )
    for t in times:
        since = arb_of(t) - half
        if since < 0:
            overlap, rate = at_time(found, turn, arb_of(t))
        else:
            overlap, rate = out.at(since) if since < end else [last * (since - end), last]
        yield t, {"overlap": overlap, "v": rate}


def tent(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The force by its definition, from edge to edge."""
    mass, k1, x1, x2, x0, v0 = (number(p, name) for name in ("mass", "k1", "x1", "x2", "x0", "v0"))
    edges = (x1, Fraction(0), x2)
    waiting = list(times)
    begin = arb(0)
    state = [arb_of(x0), arb_of(v0)]
    region = sum(x0 > edge or (x0 == edge and v0 > 0) for edge in (x1, Fraction(0), x2))
    slopes = (Fraction(0), k1, k1 * x1 / x2, Fraction(0))
    yield None, {"work": arb_of(-k1 * x1 / 2) * arb_of(x2 - x1)}
    step = float((mass / max(k1, -slopes[2])) ** Fraction(1)) ** 0.5 / 16
    while waiting:
        slope = slopes[region] / mass
        if region == 1:
            root = edges[0]
        else:
            root = edges[2]
        phase = Solution(partial(flank, arb_of(slope), arb_of(root)), state, begin=begin)
        end, side = next_edge(
            phase,
            [edges[i] for i in (region - 1, region) if 0 <= i < 3],
            begin,
            step,
            float(waiting[-1]),
        )
        while waiting and (end is None or arb_of(waiting[0]) < end):
            t = waiting.pop(0)
            yield t, dict(zip(("x", "v"), phase.at(t), strict=True))
        if end is not None:
            begin = end
            state = [arb_of(side), phase.at(end)[1]]
            region += 1 if state[1] > 0 else -1


def flank(slope: arb, root: arb, t: Any, y: Sequence[Any]) -> list[Any]:
    """The rates of (x, v) for x'' = slope (x - root)."""
    return [y[1], slope * (y[0] - root)]


def beyond(edge: arb, y: Sequence[arb]) -> arb:
    """How far the first coordinate is beyond an edge."""
    return y[0] - edge


def next_edge(
    phase: Solution, edges: Sequence[Fraction], begin: arb, step: float, until: float
) -> tuple[arb | None, Fraction]:
    """When an edge is passed first, and which; None if none is before `until`."""
    low = float(begin) + step / 1024
    while low < until:
        high = low + step
        for edge in edges:
            before, after = (phase.at(arb(t))[0] - arb_of(edge) for t in (low, high))
            if (before < 0) != (after < 0):
                return (
                    phase.crossing(partial(beyond, arb_of(edge)), (low + high) / 2, step / 2),
                    edge,
                )
        low = high
    return None, Fraction(0)


WITNESSES = {
    "two-spheres": Witness(METHOD, two_spheres),
    "hertz-spheres": Witness(METHOD, hertz),
    "asymmetric-field": Witness(METHOD, tent),
    "wedge-collision": Witness(METHOD, wedge),
}
