"""Witnesses of colliding spheres: Newton's law in Cartesian vectors, phase by phase; switches by
sign changes on a grid and the secant.

Geometry of a contact in the plane: r = r1 - r2, e = r/|r| the normal, t the tangent, e turned by
+90 degrees; d = R1 + R2 - |r| the overlap, v_e and v_t the components of v = r'. The normal force
on body 1 is F = k d - c v_e along e; friction f on body 1 acts along t. Slip has the levers l_i =
R_i - beta d, beta = 0, 1/2 or 1, and the torque of friction L_i alike.

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
    """A contact under the linear law, phase by phase: its forces, what ends a phase, and what
    follows.

    The state is x, y, vx, vy of r1 - r2, the two spins about z and the stretch of the tangential
    spring, if a class says nothing else. The torque of friction f on each body is -l_i f. `reach`
    is R1 + R2; `pulls` is true if the normal force may pull, so that the contact ends with the
    overlap and not with the force.
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
        """The velocity of surface 1 against surface 2 along t."""

    @abstractmethod
    def holding(self, s: Sequence[Any]) -> Any:
        """The friction f with which slip' = 0."""

    @abstractmethod
    def growth(self, s: Sequence[Any]) -> Any:
        """The rate dF/dt of the normal force."""

    @abstractmethod
    def law(self, phase: str) -> Value:
        """Friction f as a function of the state, in a phase."""

    @abstractmethod
    def field(self, friction: Value) -> Callable[[Any, Sequence[Any]], list[Any]]:
        """The field (t, state) -> rates under a law of friction."""

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

    def margin(self, phase: str, side: int, s: Sequence[Any]) -> Any:
        """The margin mu F + side f of friction to its limit, beyond which it slips to that side."""
        return self.mu * self.force(s) + side * self.law(phase)(s)

    def ends(self, phase: str) -> dict[str, Value]:
        """The functions that are positive within a phase, by the name of what follows their zero.

        "caught" is the end of a slip: of its velocity (k_t = 0), or, with a spring, where mu F
        grows as fast as the slip would stretch the spring beyond it.
        """
        if phase in ("stick", "hold"):
            return {
                f"slip{sign}": partial(self.margin, phase, side) for sign, side in SIDES.items()
            }
        # Friction needs a force that presses; one that may pull lasts to the end of the overlap.
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
        """The name of the phase that begins in state s, at touch."""
        slip = self.slip(s)
        force = self.force(s)
        if not self.mu > 0:
            return "free"
        has_spring = self.kt > 0
        has_slip = slip > 0 or slip < 0
        if has_spring and (not has_slip or force > 0):
            # The spring is not stretched yet, so that it is inside its limit.
            return "stick"
        if not has_slip:
            return self._held_or_slipping(s)
        # With F = 0 the rates decide: the spring's k_t slip against that of the limit.
        slides = not has_spring or self.kt * abs(slip) > self.mu * self.growth(s)
        if not slides:
            return "stick"
        if slip > 0:
            return "slip+"
        return "slip-"

    def _held_or_slipping(self, s: Sequence[arb]) -> str:
        """The phase of a contact without slip or spring: held if friction suffices.

        Else the force that would be needed says to which side it slips.
        """
        needed = self.holding(s)
        if abs(needed) < self.mu * self.force(s):
            return "hold"
        if needed > 0:
            return "slip-"
        return "slip+"

    def caught_or_slipped(self, phase: str, then: str, s: Sequence[arb]) -> tuple[str, list[arb]]:
        """`after` for a state whose seventh number is the stretch.

        A spring that is caught begins at its limit; without a spring a slip that comes to 0 holds,
        or goes on to the other side.
        """
        if then != "caught":
            return then, list(s)
        if self.kt > 0:
            return "stick", [*s[:6], SIDES[phase[-1]] * self.mu * self.force(s) / self.kt]
        if abs(self.holding(s)) < self.mu * self.force(s):
            return "hold", list(s)
        return OTHER_SLIP[phase], list(s)


class Spheres(Colliding):
    """Two free spheres that touch, of the parameters of the case two-spheres."""

    def __init__(self, p: Mapping[str, Any]) -> None:
        masses = [arb_of(mass) for mass in p["masses"]]
        self.radii = [arb_of(radius) for radius in p["radii"]]
        self.reach = self.radii[0] + self.radii[1]
        self.moments = [m * r * r * 2 / 5 for m, r in zip(masses, self.radii, strict=True)]
        self.mass = masses[0] * masses[1] / (masses[0] + masses[1])
        # beta of the slip, and that of the torque.
        branch = str(p["branch"])
        self.beta = {"R": arb(0), "R-d/2": arb(1) / 2, "R-d": arb(1), "slip-R": arb(0)}[branch]
        self.torque_beta = self.beta
        if branch == "slip-R":
            self.torque_beta = arb(1) / 2
        names = ("stiffness", "damping", "tangential_stiffness", "friction")
        self.k, self.c, self.kt, self.mu = (arb_of(p[name]) for name in names)
        self.pulls = p["cutoff"] == "zero_overlap" and p["damping"] > 0

    def geometry(self, s: Sequence[Any]) -> tuple[Any, Any, Any, Any, Any, Any]:
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
        """The slip v_t - l1 w1 - l2 w2 of the surfaces."""
        _, _, distance, _, across, _ = self.geometry(s)
        first, second = self.levers(distance)
        return across - first * s[4] - second * s[5]

    def holding(self, s: Sequence[Any]) -> Any:
        """The f with slip' = 0, which is linear in f.

        slip' = f/m - v_e v_t/|r| - beta v_e (w1 + w2) + f (l1 L1/J1 + l2 L2/J2).
        """
        _, _, distance, along, across, _ = self.geometry(s)
        inverse_mass = 1 / self.mass + sum(
            lever * torque_lever / moment
            for lever, torque_lever, moment in zip(
                self.levers(distance), self.torque_levers(distance), self.moments, strict=True
            )
        )
        return (along * across / distance + self.beta * along * (s[4] + s[5])) / inverse_mass

    def growth(self, s: Sequence[Any]) -> Any:
        """dF/dt = k d' + c d'' with d' = -v_e and d'' = -F/m - v_t^2/|r|."""
        _, _, distance, along, across, force = self.geometry(s)
        return -self.k * along - self.c * (force / self.mass + across * across / distance)

    def field(self, friction: Value) -> Callable[[Any, Sequence[Any]], list[Any]]:
        """r' = v, m v' = F e + f t, J_i w_i' = -L_i f, stretch' = slip; m is the effective mass."""

        def rates(t: Any, s: Sequence[Any]) -> list[Any]:
            ex, ey, distance, _, _, force = self.geometry(s)
            f = friction(s)
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

    Phases are followed until the bodies part, or no switch is found in the time `longest` [s].
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
    """The name and the time of the first function that falls through zero; None if none does.

    The times are searched in steps that grow (GRID); a zero is refined by the secant.
    """
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
    """Two spheres, in the plane of their relative motion; those that turn out of it are left to
    spinning_pair.py.

    The centre of mass rests, so that r1 = m2/(m1 + m2) r and r2 = -m1/(m1 + m2) r. Nothing is said
    of a contact in the plane that never ends.
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
            # Friction is in the plane: these spins do not change.
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
    """The state after a free flight of time t."""
    return [s[0] + s[2] * t, s[1] + s[3] * t, *s[2:]]


def pressed(mass: arb, stiffness: arb, exponent: Fraction, speed: arb) -> tuple[Solution, arb]:
    """The motion m d'' = -k d^n from touch as a curve (w, v, t) in s, and the s at which v = 0.

    With w = sqrt(d) and dt = 2 w ds everything is analytic at touch: dw/ds = v, dv/ds = -(2 k/m)
    w^(2 n + 1), dt/ds = 2 w.
    """
    power = int(2 * exponent + 1)

    def field(s: Any, y: Sequence[Any]) -> list[Any]:
        w_power = y[0]
        for _ in range(power - 1):
            w_power = w_power * y[0]
        return [y[1], -2 * stiffness / mass * w_power, 2 * y[0]]

    curve = Solution(field, [arb(0), speed, arb(0)])
    # Any small step finds where v changes its sign; the crossing is refined from there.
    step = float((mass / stiffness / speed).mid()) ** (1 / (power + 1)) / 8
    high = step
    while curve.at(arb(high))[1] > 0:
        high += step
    return curve, curve.crossing(lambda y: y[1], high - step / 2, step / 2)


def at_time(curve: Solution, turn: arb, t: arb) -> tuple[arb, arb]:
    """The overlap and its rate at time t [s] since touch, from the curve (w, v, t) of `pressed`.

    The s of the time is found by bisection, then the secant; t may lie a little beyond the turn.
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
    """Hertz's spheres: the motion in to the turn, and the same run back on the way out."""
    mass, stiffness, speed = (
        arb_of(number(p, name)) for name in ("effective_mass", "stiffness", "closing_speed")
    )
    curve, turn = pressed(mass, stiffness, Fraction(3, 2), speed)
    w, _, half = curve.at(turn)
    yield None, {"duration": 2 * half, "max_overlap": w * w, "max_force": stiffness * w * w * w}
    for t in times:
        time = arb_of(t)
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
    """The collision with a wedge: in with the force k2 d^2, out with k1 d."""
    mass, k1, k2, speed = (
        arb_of(number(p, name)) for name in ("mass", "k1", "k2", "closing_speed")
    )
    curve, turn = pressed(mass, k2, Fraction(2), speed)
    w, _, half = curve.at(turn)
    # Times of the way out count from the turn; it lasts a quarter period, about pi/2 sqrt(m/k1).
    out = Solution(lambda t, y: [y[1], -k1 / mass * y[0]], [w * w, arb(0)])
    quarter_period = 1.5708 * float((mass / k1).sqrt())
    end = out.crossing(lambda y: y[0], quarter_period, quarter_period / 16)
    rebound = out.at(end)[1]
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
    """The asymmetric field: a force that is linear between the edges x1, 0 and x2, from edge to
    edge.

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
    yield None, {"work": arb_of(-k1 * x1 / 2) * arb_of(x2 - x1)}
    step = float((mass / max(k1, -slopes[2])) ** Fraction(1)) ** 0.5 / 16
    while waiting:
        slope = slopes[region] / mass
        # Where the line of the force is 0.
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
