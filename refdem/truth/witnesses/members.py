"""Witnesses of the impact benchmarks that no other collision is like: a stack, a slide, a squeeze,
Mindlin's spring, a prescribed path.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.witnesses.collisions import SIDES, Colliding, Spheres, Value, flown, phases
from refdem.truth.witnesses.taylor import Solution
from refdem.truth.witnesses.testimony import Claimed, Said

LEVERS = {"R": Fraction(0), "R-d/2": Fraction(1, 2), "R-d": Fraction(1)}


def nine(
    number: str, x: Any = 0, y: Any = 0, vx: Any = 0, vy: Any = 0, spin: Any = 0
) -> dict[str, arb]:
    """The quantities of a body that stays in the plane."""
    values = {"r": (x, y, 0), "v": (vx, vy, 0), "omega": (0, 0, spin)}
    return {
        f"{kind}{number}.{axis}": arb(value)
        for kind, three in values.items()
        for axis, value in zip("xyz", three, strict=True)
    }


def stacked(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Newton's law for both; nothing is said once a contact has opened."""
    names = ("stiffness", "damping", "gravity", "mass", "upper", "radius", "height")
    k, c, g, low, high, radius, ceiling = (arb_of(p[name]) for name in names)
    zero = arb(0)

    def overlaps(s: Sequence[Any]) -> tuple[Any, Any, Any]:
        return radius - s[0], s[0] + 2 * radius - s[2], s[2] + radius - ceiling

    def rates(t: Any, s: Sequence[Any]) -> list[Any]:
        floor, middle, top = (
            k * d + c * u for d, u in zip(overlaps(s), (-s[1], s[1] - s[3], s[3]), strict=True)
        )
        return [s[1], (floor - middle) / low - g, s[3], (middle - top) / high - g]

    found = Solution(rates, [ceiling / 4, zero, 3 * ceiling / 4, zero])
    for t in times:
        now = found.at(t)
        if min(map(float, overlaps(now))) < 0:
            return
        yield t, nine("1", y=now[0], vy=now[1]) | nine("2", y=now[2], vy=now[3])


def sliding_to_roll(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """All five coordinates under weight, floor and friction; friction ends with the slip."""
    names = ("mass", "radius", "stiffness", "gravity", "friction", "speed")
    m, radius, k, g, mu, speed = (arb_of(p[name]) for name in names)

    def rates(push: arb, t: Any, s: Sequence[Any]) -> list[Any]:
        normal = k * (radius - s[1])
        rub = -push * normal
        return [s[2], s[3], rub / m, normal / m - g, rub * radius / (m * radius * radius * 2 / 5)]

    zero = arb(0)
    slides = Solution(partial(rates, mu), [zero, radius - m * g / k, speed, zero, zero])
    near = float(claimed["roll_time"])
    end = slides.crossing(lambda s: s[2] + radius * s[4], near, near / 128)
    rolls = Solution(partial(rates, zero), slides.at(end), begin=end)
    last = rolls.at(end)[2]
    yield (
        None,
        {
            "roll_time": end,
            "roll_speed": last,
            "speed_ratio": last / speed,
            "time_ratio": mu * g * end / speed,
        },
    )
    for t in times:
        x, y, u, v, spin = (slides if arb_of(t) < end else rolls).at(t)
        yield t, nine("", x, y, u, v, spin)


class Trio(Colliding):
    """A sphere between two others, each with its own equation, no symmetry used: x, y, vx, vy, spin
    of each, then both springs.

    Both contacts are in one phase, which the first one's switches end: if the second were not its
    image, its values would be denied.
    """

    def __init__(self, p: Mapping[str, Any]) -> None:
        radii = (p["partner_radius"], p["radius"])
        self.two = Spheres({**p, "masses": (p["large"], p["mass"]), "radii": radii})
        self.k = self.two.k
        self.c = self.two.c
        self.kt = self.two.kt
        self.mu = self.two.mu
        self.reach = self.two.reach
        self.pulls = self.two.pulls
        self.masses = [arb_of(p[name]) for name in ("large", "mass", "large")]
        self.inertias = [self.two.moments[0], self.two.moments[1], self.two.moments[0]]

    def pair(self, i: int, s: Sequence[Any]) -> list[Any]:
        """The outer body i (0, 2) against the middle one, as a pair is said in Spheres."""
        outer = s[5 * i : 5 * i + 5]
        middle = s[5:10]
        return [
            *(a - b for a, b in zip(outer[:4], middle[:4], strict=True)),
            outer[4],
            middle[4],
            s[15 + i // 2],
        ]

    def of_two(self, s: Sequence[Any]) -> Sequence[Any]:
        """The first contact of a state of all three; a state of two is one already."""
        if len(s) == 17:
            return self.pair(0, s)
        return s

    def holding(self, s: Sequence[Any]) -> Any:
        return self.two.holding(self.of_two(s))

    def geometry(self, s: Sequence[Any]) -> tuple[Any, Any, Any, Any, Any, Any]:
        return self.two.geometry(self.of_two(s))

    def slip(self, s: Sequence[Any]) -> Any:
        return self.two.slip(self.of_two(s))

    def growth(self, s: Sequence[Any]) -> Any:
        """The rate of the normal force, with the accelerations of both bodies."""
        pair = self.pair(0, s)
        ex, ey, distance, along, across, _ = self.geometry(pair)
        rates = self.field(self.law("slip+" if float(self.slip(pair)) > 0 else "slip-"))(None, s)
        nearing = (
            (rates[2] - rates[7]) * ex + (rates[3] - rates[8]) * ey + across * across / distance
        )
        return -self.k * along - self.c * nearing

    def law(self, phase: str) -> Value:
        plain = self.two.law(phase)
        return lambda s: plain(self.of_two(s))

    def field(self, friction: Value) -> Callable[[Any, Sequence[Any]], list[Any]]:
        def rates(t: Any, s: Sequence[Any]) -> list[Any]:
            push = [[0, 0] for _ in range(3)]
            twist = [0, 0, 0]
            slips = []
            for i in (0, 2):
                pair = self.pair(i, s)
                ex, ey, distance, _, _, force = self.geometry(pair)
                f = friction(pair)
                own, other = self.two.levers(distance)
                along = force * ex - f * ey
                across = force * ey + f * ex
                for body, sense, lever in ((i, 1, own), (1, -1, other)):
                    push[body] = [push[body][0] + sense * along, push[body][1] + sense * across]
                    twist[body] = twist[body] - lever * f
                slips.append(self.slip(pair))
            moved = [
                [
                    s[5 * n + 2],
                    s[5 * n + 3],
                    *(x / self.masses[n] for x in push[n]),
                    twist[n] / self.inertias[n],
                ]
                for n in range(3)
            ]
            return [*moved[0], *moved[1], *moved[2], *slips]

        return rates

    def after(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        if then != "caught":
            return then, list(s)
        limits = [
            SIDES[phase[-1]] * self.mu * self.force(self.pair(i, s)) / self.kt for i in (0, 2)
        ]
        return "stick", [*s[:15], *limits]


def squeezed(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Three bodies; without a tangential spring nothing is said."""
    if not p["tangential_stiffness"]:
        return
    trio = Trio(p)
    zero = arb(0)
    along, across, spin = (arb_of(p[name]) for name in ("normal", "across", "partner_spin"))
    start = [-trio.reach, zero, along, across, spin, *[zero] * 4, arb_of(p["spin"])]
    start += [trio.reach, zero, -along, -across, spin, zero, zero]
    course = list(phases(trio, start, float(claimed["duration"])))
    end = course[-1][1]
    last = course[-1][0].at(course[-1][1])
    yield None, {"duration": end}
    for t in times:
        now = next((solution.at(t) for solution, until in course if arb_of(t) < until), None)
        if now is None:
            now = [
                value for n in range(3) for value in flown(last[5 * n : 5 * n + 5], arb_of(t) - end)
            ]
        yield (
            t,
            {
                name: value
                for n in range(3)
                for name, value in nine(str(n + 1), *now[5 * n : 5 * n + 5]).items()
            },
        )


class Mindlin:
    """m d'' = -k d^(3/2), friction k_t sqrt(d) stretch or mu k d^(3/2), with d = w^2, dt = w ds;
    state w, v, t, v_y, R w_z, y, stretch.

    Friction acts against a slip that is positive at touch: the image of one that is not.
    """

    def __init__(self, p: Mapping[str, Any]) -> None:
        self.k, self.kt = (arb_of(p[name]) / arb_of(p["mass"]) for name in ("hertz", "mindlin"))
        self.mu, self.radius = (arb_of(p[name]) for name in ("friction", "radius"))
        normal = arb_of(p["normal"])
        across = arb_of(p["across"])
        turning = arb_of(p["radius"] * p["spin"])
        if across + turning < 0:
            self.side = -1
        else:
            self.side = 1
        self.start = [
            arb(0),
            normal,
            arb(0),
            self.side * across,
            self.side * turning,
            arb(0),
            arb(0),
        ]
        self.step = float(normal) ** -0.6 * (1.25 / float(self.k)) ** 0.2 / 16

    def rates(self, side: int, s: Any, y: Sequence[Any]) -> list[Any]:
        """The rates by s, while it sticks (0) or slides to a side."""
        w, v, _, vy, spin, _, stretch = y
        if side == 0:
            pull = w * self.kt * stretch
        else:
            pull = side * self.mu * self.k * w * w * w
        f = -pull * w
        return [v / 2, -self.k * w * w * w * w, w, f, f * 5 / 2, vy * w, (vy + spin) * w]

    def spare(self, side: int, y: Sequence[Any]) -> Any:
        """What a stick has left towards a side."""
        return self.mu * self.k * y[0] * y[0] - side * self.kt * y[6]

    def surplus(self, side: int, y: Sequence[Any]) -> Any:
        """The rate by which a slide exceeds that of its limit."""
        return side * self.kt * (y[3] + y[4]) - self.mu * self.k * y[1]

    def phases(self) -> Iterator[tuple[Solution, arb]]:
        """(solution, end in s) until the sphere parts from the wall."""
        if self.surplus(1, self.start) > 0:
            side = 1
        else:
            side = 0
        s = arb(0)
        state = list(self.start)
        while True:
            solution = Solution(partial(self.rates, side), state, begin=s)
            ends: dict[int | str, Value] = {"apart": lambda y: y[0]}
            sticks: dict[int | str, Value] = {
                1: partial(self.spare, 1),
                -1: partial(self.spare, -1),
            }
            then, end = self.first(
                solution,
                ends | ({"caught": partial(self.surplus, side)} if side else sticks),
                float(s),
            )
            yield solution, end
            if then == "apart":
                return
            state = solution.at(end)
            if then == "caught":
                state[6] = side * self.mu * self.k / self.kt * state[0] * state[0]
            if then == "caught":
                side = 0
            else:
                side = int(then)
            s = end

    def first(
        self, solution: Solution, ends: Mapping[int | str, Value], low: float
    ) -> tuple[int | str, arb]:
        """Which function is the first to fall through zero, and where."""
        while True:
            high = low + self.step
            fallen = [name for name, value in ends.items() if value(solution.at(arb(high))) < 0]
            if fallen:
                found = [
                    (solution.bisected(ends[name], low + self.step / 1024, high), name)
                    for name in fallen
                ]
                end, name = min(found, key=lambda pair: float(pair[0]))
                return name, end
            low = high


def mindlin_wall(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Mindlin's spring on Hertz's contact."""
    law = Mindlin(p)
    course = list(law.phases())
    last = course[-1][0].at(course[-1][1])
    yield (
        None,
        {
            "duration": last[2],
            "rebound_across": law.side * last[3],
            "rebound_spin": law.side * last[4] / law.radius,
        },
    )
    for t in times:
        time = arb_of(t)
        state = last
        if time < last[2]:
            solution, end = next(phase for phase in course if time < phase[0].at(phase[1])[2])
            state = solution.at(
                solution.bisected(partial(late, time), float(solution.begins[0]), float(end))
            )
        w, v, then, vy, turning, y, _ = state
        rest = time - then
        yield (
            t,
            nine(
                "",
                w * w + v * rest - law.radius,
                law.side * (y + vy * rest),
                v,
                law.side * vy,
                law.side * turning / law.radius,
            ),
        )


def late(time: arb, y: Sequence[arb]) -> arb:
    """How much later than a time the state is."""
    return y[2] - time


OTHER_SLIP = {"slip+": "slip-", "slip-": "slip+"}


class Passing(Colliding):
    """Along x, body 1 at the origin and body 2 at (x, b) with a constant spin: momentum given to
    body 1, its torque's, and the spring.
    """

    def __init__(self, p: Mapping[str, Any]) -> None:
        names = (
            "radius",
            "partner_radius",
            "stiffness",
            "tangential_stiffness",
            "friction",
            "off",
            "speed",
            "partner_spin",
            "begin",
        )
        one, two, self.k, self.kt, self.mu, self.b, self.speed, self.spin, self.begins = (
            arb_of(p[name]) for name in names
        )
        self.radii = [one, two]
        self.reach = one + two
        self.beta = arb_of(LEVERS[str(p["branch"])])
        self.pulls = False

    def levers(self, distance: Any) -> list[Any]:
        """The levers l_i = R_i - beta d."""
        return [radius - self.beta * (self.reach - distance) for radius in self.radii]

    def holding(self, s: Sequence[Any]) -> Any:
        """The spins stay what they are: no friction that keeps a slip at zero is asked for."""
        raise AssertionError("a prescribed path has no hold")

    def geometry(self, s: Sequence[Any]) -> tuple[Any, Any, Any, Any, Any, Any]:
        """The normal is from 1 to 2, the tangent is it turned by +90 degrees; the rest as of
        Spheres.
        """
        distance = (s[0] * s[0] + self.b * self.b).sqrt()
        ex = s[0] / distance
        ey = self.b / distance
        return ex, ey, distance, self.speed * ex, -self.speed * ey, self.k * (self.reach - distance)

    def slip(self, s: Sequence[Any]) -> Any:
        _, _, distance, _, across, _ = self.geometry(s)
        return across - self.levers(distance)[1] * self.spin

    def growth(self, s: Sequence[Any]) -> Any:
        return -self.k * self.geometry(s)[3]

    def law(self, phase: str) -> Value:
        """The law of a phase, a function of the state: the force F_t on body 2 along the tangent.

        A stick has F_t = -k_t s with the spring's stretch s, the last coordinate of the state; a
        slip has F_t = -mu F_n or mu F_n, against the slip.
        """
        if phase == "slip-":
            side = -1
        else:
            side = 1
        if phase == "stick":
            return lambda s: -self.kt * s[4]
        return lambda s: -side * self.mu * self.force(s)

    def field(self, friction: Value) -> Callable[[Any, Sequence[Any]], list[Any]]:
        def rates(t: Any, s: Sequence[Any]) -> list[Any]:
            ex, ey, distance, _, _, force = self.geometry(s)
            f = friction(s)
            given = [-force * ex + f * ey, -force * ey - f * ex, -self.levers(distance)[0] * f]
            return [s[0] * 0 + self.speed, *given, self.slip(s)]

        return rates

    def after(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        if then != "caught":
            return then, list(s)
        if not self.kt > 0:
            # A slip that is prescribed passes through zero.
            return OTHER_SLIP[phase], list(s)
        return "stick", [*s[:4], SIDES[phase[-1]] * self.mu * self.force(s) / self.kt]


def frame(part: int, *rows: Sequence[int]) -> list[list[Fraction]]:
    """A rotation matrix with rational entries."""
    return [[Fraction(x, part) for x in row] for row in rows]


def passing(
    axes: Sequence[Sequence[Fraction]],
    p: Mapping[str, Any],
    times: Sequence[Fraction],
    claimed: Claimed,
) -> Said:
    """What the contact gives body 1; `axes` has those of the plane and its normal as columns."""
    law = Passing(p)
    zero = arb(0)
    half = (law.reach * law.reach - law.b * law.b).sqrt()
    touch = (law.begins - half) / law.speed
    lasts = 2 * half / law.speed
    course = []
    last = [-half, zero, zero, zero, zero]
    for solution, end in phases(law, last, float(lasts)):
        course.append((solution, end))
        last = solution.at(end)
    for t in times:
        time = arb_of(t) - touch
        if time < 0:
            now = [zero] * 5
        else:
            now = next((solution.at(time) for solution, until in course if time < until), last)
        way = arb_of(p["speed"] * t - p["begin"])
        seen = {"impulse": (now[1], now[2], zero), "turning": (zero, zero, now[3])}
        seen |= {"r": (way, law.b, zero), "v": (law.speed, zero, zero)}
        yield (
            t,
            {
                f"{name}.{axis}": total(row, vector)
                for name, vector in seen.items()
                for axis, row in zip("xyz", axes, strict=True)
            },
        )


def total(row: Sequence[Fraction], vector: Sequence[arb]) -> arb:
    """The component of a vector along one axis of space."""
    return sum((arb_of(Fraction(a)) * b for a, b in zip(row, vector, strict=True)), arb(0))
