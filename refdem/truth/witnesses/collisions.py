"""Witnesses of colliding spheres: Newton's law in Cartesian vectors, phase by phase; the ends of
phases by sign changes on a grid and the secant method.

Geometry of a contact in the plane: r = r1 - r2; the normal e = r/|r|; the tangent t = (-e_y, e_x),
which is e turned by +90 degrees; the overlap d = R1 + R2 - |r|; v_e and v_t the components of v =
r' along e and t. The normal force on body 1 is F = k d - c v_e along e, and friction f on body 1
acts along t. The slip is v_t - l1 omega1 - l2 omega2 with the levers l_i = R_i - beta d, beta = 0,
1/2 or 1. The torque of friction on body i is -L_i f, with levers L_i of the same form.

Phases: "free" (no friction), "slip+" and "slip-" (the sign of the slip; |f| = mu F), "stick" (the
spring is stretched, k_t > 0) and "hold" (the slip is kept at 0, k_t = 0). "apart" ends the contact.
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
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.spinning_pair import spinning
from refdem.truth.witnesses.taylor import Solution

METHOD = (
    "Taylor integration in Cartesian coordinates, phase by phase, at 58 digits, unproven"
    " (refdem/truth/witnesses/collisions.py)"
)
GRID = 256
"""Steps in which the claimed duration is searched for a switch. The first one after a switch is
2^-12 of such a step, and each next one twice as long, until it is one.
"""
Value = Callable[[Sequence[Any]], Any]
"""A function of the state."""


class Colliding(ABC):
    """A contact under the linear law: forces in each phase, the end of a phase, and the next one.

    Unless a class states another one, the state is x, y, vx, vy of r1 - r2, the spins omega1 and
    omega2 about z, and the stretch of the tangential spring. `reach` is R1 + R2. `pulls` is true
    if the normal force may be negative, so that the contact ends where d = 0 and not where F = 0.
    """

    k: arb
    kt: arb
    mu: arb
    reach: arb
    beta: arb
    pulls: bool

    @abstractmethod
    def geometry(self, s: Sequence[Any]) -> tuple[Any, Any, Any, Any, Any, Any]:
        """(e_x, e_y, |r|, v_e, v_t, F) of a state."""

    @abstractmethod
    def slip(self, s: Sequence[Any]) -> Any:
        """The velocity [m/s] of surface 1 relative to surface 2 along t."""

    @abstractmethod
    def holding(self, s: Sequence[Any]) -> Any:
        """The friction f [N] for which slip' = 0."""

    @abstractmethod
    def growth(self, s: Sequence[Any]) -> Any:
        """The rate dF/dt of the normal force."""

    @abstractmethod
    def law(self, phase: str) -> Value:
        """Friction f as a function of the state, in a phase."""

    @abstractmethod
    def field(self, friction: Value) -> Callable[[Any, Sequence[Any]], list[Any]]:
        """The right-hand side (t, state) -> state' under a law of friction."""

    @abstractmethod
    def after(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        """The next phase and its first state, when `then` (a key of `ends`) has ended `phase`."""

    def force(self, s: Sequence[Any]) -> Any:
        """The force along the normal."""
        return self.geometry(s)[5]

    def overlap(self, s: Sequence[Any]) -> Any:
        """The overlap of the two surfaces."""
        return self.reach - self.geometry(s)[2]

    def plain_law(self, phase: str) -> Value:
        """Friction in a phase, for a state whose component 6 is the stretch of the spring.

        stick: f = -k_t stretch; hold: the f with slip' = 0; free: f = 0; slip+-: f = -+mu F.
        """
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

    def margin(self, phase: str, side: int, s: Sequence[Any]) -> Any:
        """How far friction is from its limit on a side, mu F + side f; where it is 0, it slips.

        Friction acts against the slip: at the start of a slip to the side +1, f = -mu F.
        """
        return self.mu * self.force(s) + side * self.law(phase)(s)

    def ends(self, phase: str) -> dict[str, Value]:
        """The functions that are positive within a phase, by the name of what follows their zero.

        "caught" is the end of a slip. Without a spring it is where the slip is 0. With a spring
        the stretch follows its limit side mu F/k_t as long as the slip is faster than the limit
        grows, side k_t slip > mu dF/dt.
        """
        if phase in ("stick", "hold"):
            return {
                f"slip{sign}": partial(self.margin, phase, side) for sign, side in SIDES.items()
            }
        # Without friction the contact lasts while F > 0, or, if F may pull, while d > 0.
        if phase == "free":
            if self.pulls:
                return {"apart": self.overlap}
            return {"apart": self.force}
        side = SIDES[phase[-1]]

        def excess(s: Any) -> Any:
            if self.kt > 0:
                return side * self.kt * self.slip(s) - self.mu * self.growth(s)
            return side * self.slip(s)

        if self.pulls:
            return {"caught": excess, "free": self.force}
        return {"caught": excess, "apart": self.force}

    def begin(self, s: Sequence[arb]) -> str:
        """The name of the phase that begins in state s, at first touch."""
        slip = self.slip(s)
        force = self.force(s)
        if not self.mu > 0:
            return "free"
        has_spring = self.kt > 0
        has_slip = slip > 0 or slip < 0
        if has_spring and (not has_slip or force > 0):
            # The stretch is 0 at first touch, below the limit mu F/k_t.
            return "stick"
        if not has_slip:
            return self._held_or_slipping(s)
        # With F = 0 force and limit are both 0, and their rates decide: k_t |slip| > mu dF/dt.
        slides = not has_spring or self.kt * abs(slip) > self.mu * self.growth(s)
        if not slides:
            return "stick"
        if slip > 0:
            return "slip+"
        return "slip-"

    def _held_or_slipping(self, s: Sequence[arb]) -> str:
        """The phase of a contact without slip and without a spring.

        It holds if the friction f with slip' = 0 has |f| < mu F. Otherwise it slips to the side
        opposite to that force.
        """
        needed = self.holding(s)
        if abs(needed) < self.mu * self.force(s):
            return "hold"
        if needed > 0:
            return "slip-"
        return "slip+"

    def caught_or_slipped(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        """`after` for a state whose component 6 is the stretch of the spring.

        With a spring the stick begins at the limit, k_t stretch = +-mu F. Without one a slip that
        reaches 0 holds if friction suffices, and otherwise continues to the other side.
        """
        if then != "caught":
            return then, list(s)
        if self.kt > 0:
            return "stick", [*s[:6], SIDES[phase[-1]] * self.mu * self.force(s) / self.kt]
        if abs(self.holding(s)) < self.mu * self.force(s):
            return "hold", list(s)
        return OTHER_SLIP[phase], list(s)


class Spheres(Colliding):
    """Two free spheres in contact, from the parameters of the case two-spheres."""

    def __init__(self, p: Mapping[str, Any]) -> None:
        masses = [arb_of(mass) for mass in p["masses"]]
        self.radii = [arb_of(radius) for radius in p["radii"]]
        self.reach = self.radii[0] + self.radii[1]
        # J_i = 2/5 m_i R_i^2, and the effective mass m = m1 m2/(m1 + m2).
        self.moments = [m * r * r * 2 / 5 for m, r in zip(masses, self.radii, strict=True)]
        self.mass = masses[0] * masses[1] / (masses[0] + masses[1])
        # beta of the levers of the slip and of the torque; "slip-R" has 0 and 1/2.
        branch = str(p["branch"])
        self.beta = {"R": arb(0), "R-d/2": arb(1) / 2, "R-d": arb(1), "slip-R": arb(0)}[branch]
        self.torque_beta = self.beta
        if branch == "slip-R":
            self.torque_beta = arb(1) / 2
        names = ("stiffness", "damping", "tangential_stiffness", "friction")
        self.k, self.c, self.kt, self.mu = (arb_of(p[name]) for name in names)
        self.pulls = p["cutoff"] == "zero_overlap" and p["damping"] > 0

    def geometry(self, s: Sequence[Any]) -> tuple[Any, Any, Any, Any, Any, Any]:
        # e = r/|r|,  v_e = v . e,  v_t = v . (-e_y, e_x),  F = k (R1 + R2 - |r|) - c v_e
        x, y, vx, vy = s[:4]
        distance = (x * x + y * y).sqrt()
        ex = x / distance
        ey = y / distance
        along = vx * ex + vy * ey
        across = vy * ex - vx * ey
        force = self.k * (self.reach - distance) - self.c * along
        return ex, ey, distance, along, across, force

    def levers(self, distance: Any) -> list[Any]:
        """The levers l_i = R_i - beta d of the slip."""
        return [radius - self.beta * (self.reach - distance) for radius in self.radii]

    def torque_levers(self, distance: Any) -> list[Any]:
        """The levers L_i = R_i - beta d of the torque of friction."""
        return [radius - self.torque_beta * (self.reach - distance) for radius in self.radii]

    def slip(self, s: Sequence[Any]) -> Any:
        """The slip v_t - l1 omega1 - l2 omega2 of the surfaces [m/s]."""
        _, _, distance, _, across, _ = self.geometry(s)
        first, second = self.levers(distance)
        return across - first * s[4] - second * s[5]

    def holding(self, s: Sequence[Any]) -> Any:
        """The friction f with slip' = 0 [N].

        slip' = f/m - v_e v_t/|r| - beta v_e (omega1 + omega2) + f (l1 L1/J1 + l2 L2/J2), because
        v_t' = a . t - v_e v_t/|r|, l_i' = beta v_e and omega_i' = -L_i f/J_i.
        """
        _, _, distance, along, across, _ = self.geometry(s)
        # 1/m + l1 L1/J1 + l2 L2/J2
        inverse_mass = 1 / self.mass + sum(
            lever * torque_lever / moment
            for lever, torque_lever, moment in zip(
                self.levers(distance), self.torque_levers(distance), self.moments, strict=True
            )
        )
        # f = (v_e v_t/|r| + beta v_e (omega1 + omega2))/(1/m + l1 L1/J1 + l2 L2/J2)
        return (along * across / distance + self.beta * along * (s[4] + s[5])) / inverse_mass

    def growth(self, s: Sequence[Any]) -> Any:
        """dF/dt = k d' + c d'' [N/s] with d' = -v_e and d'' = -v_e' = -F/m - v_t^2/|r|."""
        _, _, distance, along, across, force = self.geometry(s)
        # k d' + c d'', with d' = -v_e and d'' = -(F/m + v_t^2/|r|).
        return -self.k * along - self.c * (force / self.mass + across * across / distance)

    def field(self, friction: Value) -> Callable[[Any, Sequence[Any]], list[Any]]:
        """r' = v, m v' = F e + f t, J_i omega_i' = -L_i f, stretch' = slip; m effective."""

        def rates(t: Any, s: Sequence[Any]) -> list[Any]:
            ex, ey, distance, _, _, force = self.geometry(s)
            f = friction(s)
            # m v' = F e + f t, t = (-e_y, e_x); J_i omega_i' = -L_i f.
            ax = (force * ex - f * ey) / self.mass
            ay = (force * ey + f * ex) / self.mass
            spin_rates = [
                -lever * f / moment
                for lever, moment in zip(self.torque_levers(distance), self.moments, strict=True)
            ]
            return [s[2], s[3], ax, ay, *spin_rates, self.slip(s)]

        return rates

    def law(self, phase: str) -> Value:
        return self.plain_law(phase)

    def after(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        return self.caught_or_slipped(phase, then, s)


SIDES = {"+": 1, "-": -1}
OTHER_SLIP = {"slip+": "slip-", "slip-": "slip+"}


def phases(pair: Colliding, start: Sequence[arb], longest: float) -> Iterator[tuple[Solution, arb]]:
    """Each phase of a contact as its solution, and the time [s] at which it ends.

    The last phase ends where the bodies separate. A phase without an end before 1.1 `longest` [s]
    is not yielded.
    """
    phase = pair.begin(start)
    s = list(start)
    t = arb(0)
    while phase != "apart":
        solution = Solution(pair.field(pair.law(phase)), s, begin=t)
        switch = first_switch(solution, pair.ends(phase), float(t), longest)
        if switch is None:
            return
        then, end = switch
        yield solution, end
        phase, s = pair.after(phase, then, solution.at(end))
        t = end


def first_switch(
    solution: Solution, values: Mapping[str, Value], begin: float, longest: float
) -> tuple[str, arb] | None:
    """The name and the time of the first function that falls below 0; None if none does.

    The functions are sampled in steps that grow (GRID), and a zero is refined by the secant method.
    """
    # A function may be 0 at `begin` itself: the search starts 2^-12 of a grid step later.
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


def two_spheres(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Two spheres in the plane of their relative motion.

    The centre of mass is at rest: r1 = m2/(m1 + m2) r and r2 = -m1/(m1 + m2) r. Spheres whose
    friction does not act in this plane are left to spinning_pair.py. A contact in the plane that
    never ends has no `duration`, and no values are given for it.
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
    position = [-pair.reach, arb(0)]
    velocity = [speed * cosine, speed * sine]
    # x, y, vx, vy of r1 - r2 at first touch, omega1_z, omega2_z, stretch.
    start = [*position, *velocity, arb_of(spins[2]), arb_of(spins[5]), arb(0)]
    contact = list(phases(pair, start, float(claimed["duration"])))
    if not contact:
        return
    last_phase, end = contact[-1]
    last = last_phase.at(end)
    yield None, {"duration": end}
    for t in times:
        state = during(contact, arb_of(t))
        if state is None:
            state = flown(last, arb_of(t) - end)
        quantities = {"omega1.z": state[4], "omega2.z": state[5]}
        for body in (0, 1):
            # Friction lies in the plane, so that its torque has no x and y components.
            for i, axis in enumerate("xy"):
                quantities[f"omega{body + 1}.{axis}"] = arb_of(spins[3 * body + i])
        for body, sign in ((1, 1), (2, -1)):
            share = arb_of(sign * masses[2 - body] / sum(masses))
            for i, axis in enumerate("xy"):
                quantities[f"r{body}.{axis}"] = share * state[i]
                quantities[f"v{body}.{axis}"] = share * state[2 + i]
        yield t, quantities


def during(contact: Sequence[tuple[Solution, arb]], time: arb) -> list[arb] | None:
    """The state at a time in the contact, given by its phases with their ends; None after it."""
    for solution, end in contact:
        if time < end:
            return solution.at(time)
    return None


def flown(s: Sequence[arb], t: arb) -> list[arb]:
    """The state after a free flight of time t [s]: (x + vx t, y + vy t), the rest unchanged."""
    return [s[0] + s[2] * t, s[1] + s[3] * t, *s[2:]]


def pressed(mass: arb, stiffness: arb, exponent: Fraction, speed: arb) -> tuple[Solution, arb]:
    """The motion m d'' = -k d^n from touch as a curve (w, v, t) in s, and the s at which v = 0.

    The substitution d = w^2, dt = 2 w ds makes the equations analytic at d = 0 where 2 n is an
    integer: dw/ds = v, dv/ds = -(2 k/m) w^(2 n + 1), dt/ds = 2 w.
    """
    power = int(2 * exponent + 1)

    def field(s: Any, y: Sequence[Any]) -> list[Any]:
        # w^(2 n + 1) by repeated multiplication.
        w_power = y[0]
        for _ in range(power - 1):
            w_power = w_power * y[0]
        return [y[1], -2 * stiffness / mass * w_power, 2 * y[0]]

    curve = Solution(field, [arb(0), speed, arb(0)])
    # The step needs no precise size: it brackets the zero of v, which is refined afterwards.
    step = float((mass / stiffness / speed).mid()) ** (1 / (power + 1)) / 8
    high = step
    while curve.at(arb(high))[1] > 0:
        high += step
    return curve, curve.crossing(lambda y: y[1], high - step / 2, step / 2)


def at_time(curve: Solution, turn: arb, t: arb) -> tuple[arb, arb]:
    """The overlap and its rate at time t [s] since touch, from the curve (w, v, t) of `pressed`.

    The s at which the time is t is found by bisection, then by the secant method. t may lie a
    little after the time of the largest overlap.
    """
    low = 0.0
    high = float(turn) * 1.01
    for _ in range(40):
        middle = (low + high) / 2
        if curve.at(arb(middle))[2] < t:
            low = middle
        else:
            high = middle
    reach = (high - low) / 2 + float(turn) * 1e-9
    s = curve.crossing(lambda y: y[2] - t, (low + high) / 2, reach)
    w, v, _ = curve.at(s)
    return w * w, v


def hertz(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """Hertz's spheres: the motion up to the largest overlap, and its time reversal afterwards."""
    mass, stiffness, speed = (
        arb_of(number(p, name)) for name in ("effective_mass", "stiffness", "closing_speed")
    )
    curve, turn = pressed(mass, stiffness, Fraction(3, 2), speed)
    # With v = 0 at w: d_max = w^2, F_max = k w^3, and the duration is twice the time of the turn.
    w, _, half = curve.at(turn)
    yield None, {"duration": 2 * half, "max_overlap": w * w, "max_force": stiffness * w * w * w}
    for t in times:
        time = arb_of(t)
        # d(t) = d(t_c - t) and v(t) = -v(t_c - t), t_c being the duration.
        until_end = 2 * half - time
        if until_end < 0:
            yield t, {"overlap": speed * until_end, "v": -speed}
        elif time < half:
            overlap, rate = at_time(curve, turn, time)
            yield t, {"overlap": overlap, "v": rate}
        else:
            overlap, rate = at_time(curve, turn, until_end)
            yield t, {"overlap": overlap, "v": -rate}


def wedge(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The collision with a wedge: m d'' = -k2 d^2 in approach, m d'' = -k1 d in separation."""
    mass, k1, k2, speed = (
        arb_of(number(p, name)) for name in ("mass", "k1", "k2", "closing_speed")
    )
    curve, turn = pressed(mass, k2, Fraction(2), speed)
    w, _, half = curve.at(turn)
    # Separation is a quarter period pi/2 sqrt(m/k1); its time starts at the largest overlap.
    out = Solution(lambda t, y: [y[1], -k1 / mass * y[0]], [w * w, arb(0)])
    quarter_period = 1.5708 * float((mass / k1).sqrt())
    end = out.crossing(lambda y: y[0], quarter_period, quarter_period / 16)
    rebound = out.at(end)[1]
    # Delta E = m/2 (v_out^2 - v_in^2)
    energy_change = mass / 2 * (rebound * rebound - speed * speed)
    yield (
        None,
        {"duration": half + end, "max_overlap": w * w, "energy_change": energy_change},
    )
    for t in times:
        since_turn = arb_of(t) - half
        if since_turn < 0:
            overlap, rate = at_time(curve, turn, arb_of(t))
        elif since_turn < end:
            overlap, rate = out.at(since_turn)
        else:
            overlap, rate = rebound * (since_turn - end), rebound
        yield t, {"overlap": overlap, "v": rate}


def tent(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The asymmetric field: a force that is linear in x between the edges x1, 0 and x2.

    The regions 0 to 3 lie left of x1, between x1 and 0, between 0 and x2, and right of x2. The
    force rises from 0 at x1 with the slope k1 and falls to 0 at x2 with k1 x1/x2 (x1 < 0).
    """
    mass, k1, x1, x2, x0, v0 = (number(p, name) for name in ("mass", "k1", "x1", "x2", "x0", "v0"))
    edges = (x1, Fraction(0), x2)
    waiting = list(times)
    begin = arb(0)
    state = [arb_of(x0), arb_of(v0)]
    region = sum(x0 > edge or (x0 == edge and v0 > 0) for edge in edges)
    slopes = (Fraction(0), k1, k1 * x1 / x2, Fraction(0))
    # The work from x1 to x2 is the area of a triangle of height -k1 x1 on the base x2 - x1.
    yield None, {"work": arb_of(-k1 * x1 / 2) * arb_of(x2 - x1)}
    step = float((mass / max(k1, -slopes[2])) ** Fraction(1)) ** 0.5 / 16
    while waiting:
        slope = slopes[region] / mass
        # The force is slope (x - zero): zero is x1 on the left of 0 and x2 on the right.
        if region == 1:
            zero = edges[0]
        else:
            zero = edges[2]
        phase = Solution(partial(flank, arb_of(slope), arb_of(zero)), state, begin=begin)
        edges_of_region = [edges[i] for i in (region - 1, region) if 0 <= i < 3]
        end, edge = next_edge(phase, edges_of_region, begin, step, float(waiting[-1]))
        while waiting and (end is None or arb_of(waiting[0]) < end):
            t = waiting.pop(0)
            yield t, dict(zip(("x", "v"), phase.at(t), strict=True))
        if end is not None:
            begin = end
            state = [arb_of(edge), phase.at(end)[1]]
            if state[1] > 0:
                region += 1
            else:
                region -= 1


def flank(slope: arb, zero: arb, t: Any, y: Sequence[Any]) -> list[Any]:
    """The rates of (x, v) for x'' = slope (x - zero)."""
    return [y[1], slope * (y[0] - zero)]


def beyond(edge: arb, y: Sequence[arb]) -> arb:
    """The signed distance of the first coordinate from an edge."""
    return y[0] - edge


def next_edge(
    phase: Solution, edges: Sequence[Fraction], begin: arb, step: float, until: float
) -> tuple[arb | None, Fraction]:
    """The time at which an edge is first passed after `begin`, and that edge.

    (None, 0) if none is before `until` [s]; `step` [s] is that of the search.
    """
    low = float(begin) + step / 1024
    while low < until:
        high = low + step
        for edge in edges:
            before = phase.at(arb(low))[0] - arb_of(edge)
            after = phase.at(arb(high))[0] - arb_of(edge)
            if (before < 0) != (after < 0):
                time = phase.crossing(partial(beyond, arb_of(edge)), (low + high) / 2, step / 2)
                return time, edge
        low = high
    return None, Fraction(0)


WITNESSES = {
    "two-spheres": Witness(METHOD, two_spheres),
    "hertz-spheres": Witness(METHOD, hertz),
    "asymmetric-field": Witness(METHOD, tent),
    "wedge-collision": Witness(METHOD, wedge),
}
