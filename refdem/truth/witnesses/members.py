"""Witnesses of the impact benchmarks that need equations of their own: two stacked spheres, sliding
to rolling, a squeezed sphere, Mindlin's spring and a prescribed path.

Each witness integrates Newton's law of every body under the contact law, phase by phase
(collisions.py). The parameters `p` of a member come from impact_numbers.py.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.witnesses.collisions import (
    OTHER_SLIP,
    SIDES,
    Colliding,
    Spheres,
    Value,
    during,
    flown,
    phases,
)
from refdem.truth.witnesses.cross_check import Claimed, Results
from refdem.truth.witnesses.taylor import Solution

LEVERS = {"R": Fraction(0), "R-d/2": Fraction(1, 2), "R-d": Fraction(1)}
"""beta of the lever l_i = R_i - beta d of friction, by the name of the branch."""


def nine(
    number: str, x: Any = 0, y: Any = 0, vx: Any = 0, vy: Any = 0, spin: Any = 0
) -> dict[str, arb]:
    """The nine components of r, v and omega of body `number`, which moves in the x-y plane."""
    vectors = {"r": (x, y, 0), "v": (vx, vy, 0), "omega": (0, 0, spin)}
    quantities = {}
    for name, vector in vectors.items():
        for axis, component in zip("xyz", vector, strict=True):
            quantities[f"{name}{number}.{axis}"] = arb(component)
    return quantities


def stacked(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Two spheres squeezed between floor and ceiling, until one of the contacts opens.

    The state is (y1, v1, y2, v2). Each of the three contacts exerts the force k d + c d' at the
    overlap d.
    """
    names = ("stiffness", "damping", "gravity", "mass", "upper", "radius", "height")
    k, c, g, lower_mass, upper_mass, radius, ceiling = (arb_of(p[name]) for name in names)
    zero = arb(0)

    def overlaps(s: Sequence[Any]) -> tuple[Any, Any, Any]:
        # Floor: d = R - y1; between the spheres: d = 2 R - (y2 - y1); ceiling: d = y2 + R - H.
        y1, _, y2, _ = s
        return radius - y1, y1 + 2 * radius - y2, y2 + radius - ceiling

    def rates(t: Any, s: Sequence[Any]) -> list[Any]:
        _, v1, _, v2 = s
        # d' of the three contacts, and F = k d + c d' of each.
        overlap_rates = (-v1, v1 - v2, v2)
        floor, middle, top = (
            k * d + c * rate for d, rate in zip(overlaps(s), overlap_rates, strict=True)
        )
        # m1 v1' = F_floor - F_middle - m1 g,  m2 v2' = F_middle - F_ceiling - m2 g
        return [v1, (floor - middle) / lower_mass - g, v2, (middle - top) / upper_mass - g]

    solution = Solution(rates, [ceiling / 4, zero, 3 * ceiling / 4, zero])
    for t in times:
        state = solution.at(t)
        if min(map(float, overlaps(state))) < 0:
            return
        y1, v1, y2, v2 = state
        yield t, nine("1", y=y1, vy=v1) | nine("2", y=y2, vy=v2)


def sliding_to_roll(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """A sphere that slides on a floor until it rolls; the state is (x, y, vx, vy, omega).

        m vx' = -mu N,    m vy' = N - m g,    J omega' = -mu N R,
        N = k (R - y),    J = 2/5 m R^2

    The slip vx + R omega is positive at the start. Sliding ends where the slip is 0; the sphere
    then rolls without friction. At the start the overlap is that of rest, R - y = m g/k.
    """
    names = ("mass", "radius", "stiffness", "gravity", "friction", "speed")
    m, radius, k, g, mu, speed = (arb_of(p[name]) for name in names)

    def rates(coefficient: arb, t: Any, s: Sequence[Any]) -> list[Any]:
        # J = 2/5 m R^2, N = k (R - y); f = -mu N acts at the lowest point, with the torque R f.
        inertia = m * radius * radius * 2 / 5
        normal = k * (radius - s[1])
        friction = -coefficient * normal
        return [s[2], s[3], friction / m, normal / m - g, friction * radius / inertia]

    zero = arb(0)
    slides = Solution(partial(rates, mu), [zero, radius - m * g / k, speed, zero, zero])
    # Rolling begins at the zero of the slip vx + R omega.
    roll_time = float(claimed["roll_time"])
    end = slides.crossing(lambda s: s[2] + radius * s[4], roll_time, roll_time / 128)
    rolls = Solution(partial(rates, zero), slides.at(end), begin=end)
    roll_speed = rolls.at(end)[2]
    yield (
        None,
        {
            "roll_time": end,
            "roll_speed": roll_speed,
            "speed_ratio": roll_speed / speed,
            "time_ratio": mu * g * end / speed,
        },
    )
    for t in times:
        if arb_of(t) < end:
            x, y, vx, vy, spin = slides.at(t)
        else:
            x, y, vx, vy, spin = rolls.at(t)
        yield t, nine("", x, y, vx, vy, spin)


class Trio(Colliding):
    """A sphere between two others, with separate equations of motion of all three.

    The state is x, y, vx, vy, omega of each sphere (outer, middle, outer), then the stretch of each
    tangential spring. Both contacts are in the same phase, which ends at the end of the phase of
    the first contact: a half turn about the middle sphere maps each contact to the other one. If
    the motion lost this symmetry, the values would not agree with the truth.
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
        """The state of the contact of outer body i (0 or 2), in the form that `Spheres` has.

        It is (r_i - r_1, v_i - v_1, omega_i, omega_1, stretch).
        """
        outer = s[5 * i : 5 * i + 5]
        middle = s[5:10]
        relative = [a - b for a, b in zip(outer[:4], middle[:4], strict=True)]
        stretch = s[15 + i // 2]
        return [*relative, outer[4], middle[4], stretch]

    def of_two(self, s: Sequence[Any]) -> Sequence[Any]:
        """The first contact of a state of all three (17 numbers); the state of a pair as it is."""
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
        """The rate dF/dt of the normal force of the first contact, during its slip.

        F = k d - c v_e and d' = -v_e give dF/dt = -k v_e - c v_e'. With e' = (v_t/|r|) t,
        v_e' = (a_0 - a_1) . e + v_t^2/|r|; the accelerations are those of all forces on each body.
        """
        pair = self.pair(0, s)
        ex, ey, distance, along, across, _ = self.geometry(pair)
        if float(self.slip(pair)) > 0:
            phase = "slip+"
        else:
            phase = "slip-"
        rates = self.field(self.law(phase))(None, s)
        # The accelerations of body 0 are rates 2 and 3, those of body 1 are rates 7 and 8.
        ax = rates[2] - rates[7]
        ay = rates[3] - rates[8]
        # v_e' = (a_0 - a_1) . e + v_t^2/|r|
        along_rate = ax * ex + ay * ey + across * across / distance
        return -self.k * along - self.c * along_rate

    def law(self, phase: str) -> Value:
        plain = self.two.law(phase)
        return lambda s: plain(self.of_two(s))

    def field(self, friction: Value) -> Callable[[Any, Sequence[Any]], list[Any]]:
        def rates(t: Any, s: Sequence[Any]) -> list[Any]:
            forces = [[0, 0] for _ in range(3)]
            torques = [0, 0, 0]
            slips = []
            for i in (0, 2):
                pair = self.pair(i, s)
                ex, ey, distance, _, _, force = self.geometry(pair)
                f = friction(pair)
                # F e + f t with t = (-e_y, e_x) acts on the outer body, its reaction on the middle
                # one; the torque is -l_i f on both.
                force_x = force * ex - f * ey
                force_y = force * ey + f * ex
                outer_lever, middle_lever = self.two.levers(distance)
                for body, sign, lever in ((i, 1, outer_lever), (1, -1, middle_lever)):
                    forces[body][0] = forces[body][0] + sign * force_x
                    forces[body][1] = forces[body][1] + sign * force_y
                    torques[body] = torques[body] - lever * f
                slips.append(self.slip(pair))
            state_rates = []
            for n in range(3):
                # r' = v,  m_n v' = sum of forces,  J_n omega' = sum of torques
                accelerations = [x / self.masses[n] for x in forces[n]]
                spin_rate = torques[n] / self.inertias[n]
                state_rates += [s[5 * n + 2], s[5 * n + 3], *accelerations, spin_rate]
            return [*state_rates, *slips]

        return rates

    def after(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        if then != "caught":
            return then, list(s)
        # The springs begin at their limit: k_t stretch = +-mu F, with the sign of the slip.
        limits = [
            SIDES[phase[-1]] * self.mu * self.force(self.pair(i, s)) / self.kt for i in (0, 2)
        ]
        return "stick", [*s[:15], *limits]


def squeezed(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Three spheres in a row, the middle one squeezed by the outer ones.

    The outer spheres close with (v_n, v_t) and (-v_n, -v_t) and have equal spins. Values are given
    only for a contact law with a tangential spring.
    """
    if not p["tangential_stiffness"]:
        return
    trio = Trio(p)
    zero = arb(0)
    along, across, spin = (arb_of(p[name]) for name in ("normal", "across", "partner_spin"))
    left = [-trio.reach, zero, along, across, spin]
    middle = [zero, zero, zero, zero, arb_of(p["spin"])]
    right = [trio.reach, zero, -along, -across, spin]
    stretches = [zero, zero]
    start = [*left, *middle, *right, *stretches]
    contact = list(phases(trio, start, float(claimed["duration"])))
    last_phase, end = contact[-1]
    last = last_phase.at(end)
    yield None, {"duration": end}
    for t in times:
        state = during(contact, arb_of(t))
        if state is None:
            state = []
            for n in range(3):
                state += flown(last[5 * n : 5 * n + 5], arb_of(t) - end)
        quantities: dict[str, arb] = {}
        for n in range(3):
            quantities |= nine(str(n + 1), *state[5 * n : 5 * n + 5])
        yield t, quantities


class Mindlin:
    """Hertz's contact of a sphere and a wall with Mindlin's tangential spring, as a curve in s.

        m d'' = -k d^(3/2),    f = k_t sqrt(d) stretch,    |f| <= mu k d^(3/2)

    The substitution d = w^2, dt = w ds makes all equations analytic at d = 0. The state is (w, v =
    d', t, v_y, R omega_z, y, stretch), whose indices are named below; k and k_t are per mass. The
    slip at first touch is taken as positive: if it is negative, the mirror image of the motion is
    integrated (`side` is -1).
    """

    ROOT, CLOSING, TIME, ACROSS, SPIN, WAY, STRETCH = range(7)

    def __init__(self, p: Mapping[str, Any]) -> None:
        mass = arb_of(p["mass"])
        self.k = arb_of(p["hertz"]) / mass
        self.kt = arb_of(p["mindlin"]) / mass
        self.mu = arb_of(p["friction"])
        self.radius = arb_of(p["radius"])
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
        # The contact lasts over a range of s of the size w_max/v0, as dw/ds = v/2, and
        # m v0^2/2 = (2/5) k d_max^(5/2) gives w_max = (5 v0^2/(4 k))^(1/5) with k per mass.
        # A step is a sixteenth of w_max/v0.
        self.step = float(normal) ** -0.6 * (1.25 / float(self.k)) ** 0.2 / 16

    def rates(self, side: int, s: Any, y: Sequence[Any]) -> list[Any]:
        """The derivatives of the state by s, while it sticks (side 0) or slides to a side.

        Each derivative is d/ds = w d/dt.
        """
        w, v, _, vy, spin, _, stretch = y
        # The friction f per mass: k_t w stretch while it sticks, side mu k w^3 while it slides.
        if side == 0:
            friction = w * self.kt * stretch
        else:
            friction = side * self.mu * self.k * w * w * w
        # dw/dt = v/(2 w) from d = w^2, and dv/dt = -k d^(3/2) = -k w^3.
        w_rate = v / 2
        v_rate = -self.k * w * w * w * w
        # dv_y/dt = -f, and d(R w_z)/dt = -5/2 f of a solid sphere.
        vy_rate = -friction * w
        spin_rate = vy_rate * 5 / 2
        # dy/dt = v_y, and d stretch/dt is the slip v_y + R w_z.
        return [w_rate, v_rate, w, vy_rate, spin_rate, vy * w, (vy + spin) * w]

    def margin(self, side: int, y: Sequence[Any]) -> Any:
        """How far the sticking friction is from its limit on a side, divided by w.

        The limit is mu k w^3 and the force of the spring k_t w stretch: the margin is mu k w^2 -
        side k_t stretch.
        """
        w = y[self.ROOT]
        return self.mu * self.k * w * w - side * self.kt * y[self.STRETCH]

    def excess(self, side: int, y: Sequence[Any]) -> Any:
        """The rate at which the slip would stretch the spring beyond its limit, times k_t.

        The limit of the stretch is side mu k d/k_t, from k_t w stretch = side mu k w^3. So the
        excess is side k_t (v_y + R omega_z) - mu k d'.
        """
        slip = y[self.ACROSS] + y[self.SPIN]
        return side * self.kt * slip - self.mu * self.k * y[self.CLOSING]

    def phases(self) -> Iterator[tuple[Solution, arb]]:
        """Each phase as its solution and the s of its end, until the sphere leaves the wall.

        The sphere slides from the start if the slip exceeds the growth of the limit there.
        """
        if self.excess(1, self.start) > 0:
            side = 1
        else:
            side = 0
        s = arb(0)
        state = list(self.start)
        while True:
            solution = Solution(partial(self.rates, side), state, begin=s)
            then, end = self.first(solution, self.ends(side), float(s))
            yield solution, end
            if then == "apart":
                return
            state = solution.at(end)
            if then == "caught":
                # The stick begins with the stretch at its limit: k_t stretch = side mu k w^2.
                w = state[self.ROOT]
                state[self.STRETCH] = side * self.mu * self.k / self.kt * w * w
                side = 0
            else:
                side = int(then)
            s = end

    def ends(self, side: int) -> dict[int | str, Value]:
        """The functions that are positive within a phase, by the name of what follows their zero.

        The names are "apart", "caught" (the slide ends in a stick), or the side of a slide.
        """
        ends: dict[int | str, Value] = {"apart": lambda y: y[self.ROOT]}
        if side:
            ends["caught"] = partial(self.excess, side)
        else:
            ends[1] = partial(self.margin, 1)
            ends[-1] = partial(self.margin, -1)
        return ends

    def first(
        self, solution: Solution, ends: Mapping[int | str, Value], low: float
    ) -> tuple[int | str, arb]:
        """The name of the first function that falls below 0 after s = `low`, and the s of its zero.

        The functions are sampled in steps of `step`, and a change of sign is bisected.
        """
        while True:
            high = low + self.step
            fallen = [name for name, value in ends.items() if value(solution.at(arb(high))) < 0]
            if fallen:
                zeros = [
                    (solution.bisected(ends[name], low + self.step / 1024, high), name)
                    for name in fallen
                ]
                end, name = min(zeros, key=lambda pair: float(pair[0]))
                return name, end
            low = high


def mindlin_wall(p: Mapping[str, Any], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """A sphere and a wall under Hertz's normal force with Mindlin's tangential spring."""
    law = Mindlin(p)
    contact = list(law.phases())
    last_phase, last_s = contact[-1]
    last = last_phase.at(last_s)
    yield (
        None,
        {
            "duration": last[law.TIME],
            "rebound_across": law.side * last[law.ACROSS],
            "rebound_spin": law.side * last[law.SPIN] / law.radius,
        },
    )
    for t in times:
        time = arb_of(t)
        state = last
        if time < last[law.TIME]:
            # The phase in which that time lies, and the s of the time in it.
            solution, end = next(
                phase for phase in contact if time < phase[0].at(phase[1])[law.TIME]
            )
            begin = float(solution.begins[0])
            state = solution.at(solution.bisected(partial(late, time), begin, float(end)))
        w, v, state_time, vy, r_omega, y, _ = state
        # The time since the end of the contact; it is 0 during the contact.
        flight = time - state_time
        # The wall is x = 0 and the sphere lies at x < 0: d = R + x, so that x = w^2 - R.
        position_x = w * w + v * flight - law.radius
        position_y = law.side * (y + vy * flight)
        spin = law.side * r_omega / law.radius
        yield t, nine("", position_x, position_y, v, law.side * vy, spin)


def late(time: arb, y: Sequence[arb]) -> arb:
    """The time t of a state of `Mindlin` minus a given one [s]."""
    return y[2] - time


class Passing(Colliding):
    """Two spheres on a prescribed path: body 1 rests at the origin, body 2 is at (x, b).

    Body 2 has a constant velocity along x and a constant spin. The state is (x, p_x, p_y, h_z,
    stretch) with the impulse p and the angular impulse h of the contact on body 1. In contrast to
    `Spheres` the normal e points from body 1 to body 2, and slip and friction f are those of
    body 2 relative to body 1.
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
        """Not used: the motion is prescribed, so that friction cannot hold the slip at 0."""
        raise AssertionError("a prescribed path has no hold")

    def geometry(self, s: Sequence[Any]) -> tuple[Any, Any, Any, Any, Any, Any]:
        """(e_x, e_y, |r|, v_e, v_t, F) of body 2 relative to body 1.

        r = (x, b), e = r/|r|, t = (-e_y, e_x), v = (speed, 0), F = k (R1 + R2 - |r|).
        """
        distance = (s[0] * s[0] + self.b * self.b).sqrt()
        ex = s[0] / distance
        ey = self.b / distance
        return ex, ey, distance, self.speed * ex, -self.speed * ey, self.k * (self.reach - distance)

    def slip(self, s: Sequence[Any]) -> Any:
        """The velocity v_t - l2 omega2 of surface 2 relative to surface 1, which rests."""
        _, _, distance, _, across, _ = self.geometry(s)
        return across - self.levers(distance)[1] * self.spin

    def growth(self, s: Sequence[Any]) -> Any:
        """The rate dF/dt = k d' = -k v_e of the normal force."""
        return -self.k * self.geometry(s)[3]

    def law(self, phase: str) -> Value:
        """Friction f on body 2 along t, as a function of the state, in a phase.

        Stick: f = -k_t stretch. Slip: f = -mu F or mu F, against the slip.
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
            # p' = -F e - f t with t = (-e_y, e_x), the reaction on body 1, and h' = -l1 f, the
            # moment of that friction at the arm l1 e.
            force_x = -force * ex + f * ey
            force_y = -force * ey - f * ex
            torque = -self.levers(distance)[0] * f
            # x' = speed, written with s[0] * 0 so that it is a series where the state is one.
            return [s[0] * 0 + self.speed, force_x, force_y, torque, self.slip(s)]

        return rates

    def after(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        if then != "caught":
            return then, list(s)
        if not self.kt > 0:
            # Without a spring a prescribed slip passes through 0 and changes its sign.
            return OTHER_SLIP[phase], list(s)
        # The spring begins at its limit: k_t stretch = +-mu F, with the sign of the slip.
        return "stick", [*s[:4], SIDES[phase[-1]] * self.mu * self.force(s) / self.kt]


def frame(part: int, *rows: Sequence[int]) -> list[list[Fraction]]:
    """The rotation matrix whose rows are `rows` divided by `part`; its entries are rational."""
    return [[Fraction(x, part) for x in row] for row in rows]


def passing(
    axes: Sequence[Sequence[Fraction]],
    p: Mapping[str, Any],
    times: Sequence[Fraction],
    claimed: Claimed,
) -> Results:
    """The impulse and angular impulse of the contact on body 1, and the prescribed path of body 2.

    The columns of `axes` are the two axes of the plane and its normal, in axes of space. The
    spheres touch at x = -sqrt((R1 + R2)^2 - b^2), where the time of the contact starts at 0.
    """
    law = Passing(p)
    zero = arb(0)
    # Contact while |x| < sqrt((R1 + R2)^2 - b^2); body 2 is at x = speed t - begin.
    touch_x = (law.reach * law.reach - law.b * law.b).sqrt()
    touch_time = (law.begins - touch_x) / law.speed
    duration = 2 * touch_x / law.speed
    contact = []
    last = [-touch_x, zero, zero, zero, zero]
    for solution, end in phases(law, last, float(duration)):
        contact.append((solution, end))
        last = solution.at(end)
    for t in times:
        time = arb_of(t) - touch_time
        if time < 0:
            state = [zero] * 5
        else:
            state = during(contact, time) or last
        x = arb_of(p["speed"] * t - p["begin"])
        vectors = {
            "impulse": (state[1], state[2], zero),
            "turning": (zero, zero, state[3]),
            "r": (x, law.b, zero),
            "v": (law.speed, zero, zero),
        }
        quantities = {}
        for name, vector in vectors.items():
            for axis, row in zip("xyz", axes, strict=True):
                quantities[f"{name}.{axis}"] = total(row, vector)
        yield t, quantities


def total(row: Sequence[Fraction], vector: Sequence[arb]) -> arb:
    """The component of a vector along one axis of space."""
    return sum((arb_of(Fraction(a)) * b for a, b in zip(row, vector, strict=True)), arb(0))
