"""Two spheres in contact, in the plane: the phases press, stick, hold, slip and pull of the linear
law, and the switches between them.

Polar coordinates of r = r1 - r2 = -rho (cos phi, sin phi), in units of a time T, a speed V and the
length X = V T, all dyadic, with m the effective mass and D = R1 + R2: overlap d = D - rho = X a, a'
= u, h = rho^2 phi' = D V w, omega_i = V o_i/R_i, tangential spring 2 X s,

    F = m X/T^2 (K a + C u),  u' = -(K a + C u) - eps w^2/r^3,  phi' = eps w/r^2,  w' = r g,  o_i' =
    -(L_i/R_i) mu_i g,

r = 1 - eps a, eps = X/D, mu_i = m R_i^2/J_i, levers l_i = R_i - beta d = R_i (1 - b_i a) of the
slip with beta = 0, 1/2, 1, alike L_i of the torque, and g the friction on body 1 along the normal
r/rho turned by +90 degrees about z. The slip is V (w/r - (1 - b_1 a) o_1 - (1 - b_2 a) o_2), and g
is

    stick -2 Kt s with 2 s' = slip;  slip -sigma mu F, from |2 Kt s| = mu F on, until sigma Kt slip
    = mu F';  press and pull (F < 0) 0; hold (no spring) what keeps the slip at zero, while that is
    at most mu F.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from math import isqrt
from typing import Any, Protocol

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.events.crossing import sign
from refdem.truth.events.system import Entry, Guard, Mode
from refdem.truth.exact import sign_of
from refdem.truth.reals import Number, near
from refdem.truth.sphere_pair import TouchingPair
from refdem.truth.traced_field import Program, traced

State = Sequence[Any]
"""(a, u, phi, w, o1, o2, s, clock); apart: x - vx clock, y - vy clock, vx, vy in units of X and V
in the first four places.
"""
# Places of a state in contact.
OVERLAP = 0  # a
CLOSING = 1  # u
NORMAL_ANGLE = 2  # phi
ACROSS = 3  # w
SPIN_1 = 4  # o1
SPIN_2 = 5  # o2
SPRING = 6  # s
CLOCK = 7  # the time in units of T

SLIDES = {1: "slip", -1: "slip back"}


class Touching(Protocol):
    """The properties of a pair that decide which modes there are and which comes first."""

    @property
    def damping(self) -> Number: ...

    @property
    def ends_with_overlap(self) -> bool: ...

    @property
    def surface_spin(self) -> Sequence[Number]: ...

    @property
    def angle(self) -> Fraction: ...


class LinearContact(ABC):
    """The phases of a contact under the linear law, in the units of the module: the part that does
    not depend on the coordinates of the motion.

    In the symbols of the module: `time` is T, `speed` V, `length` X; `k`, `c`, `kt` are K, C, Kt;
    `ease` has mu_i, `bend` has b_i of the slip and `torque_bend` of the torque, `friction` is mu (0
    where friction is left out).
    """

    pair: Touching
    friction: Fraction
    time: Fraction
    speed: Fraction
    length: Fraction
    eps: Fraction
    ease: Sequence[Number]
    bend: Sequence[Number]
    torque_bend: Sequence[Number]
    k: Number
    c: Number
    kt: Number
    directions: int
    """The directions in which the spheres move: 2 in the plane, 3 in space."""
    rests = False
    """True where nothing slips, ever, though friction acts on what errors make slip."""

    @property
    @abstractmethod
    def size(self) -> int:
        """The number of coordinates of the state."""

    @abstractmethod
    def start(self) -> list[Callable[[], arb]]:
        """The state of the contact at touch."""

    @abstractmethod
    def overlap(self, y: State) -> Any:
        """The overlap a in units of length."""

    @abstractmethod
    def closing(self, y: State) -> Any:
        """The closing speed u in units of speed."""

    @abstractmethod
    def falling(self, y: State) -> Any:
        """The rate u' of the closing speed in units of V/T."""

    @abstractmethod
    def modes(self) -> dict[str, Mode]:
        """Every mode that this pair can be in."""

    @abstractmethod
    def first(self, y: State) -> Entry:
        """The entry at touch; what the parameters decide exactly is not left to balls."""

    @abstractmethod
    def parting(self) -> Entry:
        """The entry into free flight."""

    @abstractmethod
    def place(self, mode: str, y: State) -> list[Any]:
        """Positions, velocities, spins, spring and clock of a state in the given mode: as many
        numbers as the state has.
        """

    def in_units_of(self, pair: TouchingPair, *, rubs: bool) -> None:
        """Sets the units and the numbers of a pair; without `rubs` friction is left out."""
        m = pair.effective_mass
        mass_ratios = [m / mass for mass in pair.masses]
        self.pair = pair
        # mu_i = m R_i^2/J_i, with J_i = 2/5 m_i R_i^2 of a solid sphere.
        self.ease = [Fraction(5, 2) * ratio for ratio in mass_ratios]
        self.friction = pair.friction * rubs
        spring = pair.tangential_stiffness * (self.friction > 0)
        # T is at most the inverse of the largest rate of the law: sqrt(k/m), that of the tangential
        # spring, which turns the spheres too, and c/m.
        tangential = near(spring * (1 + sum(self.ease)))
        fastest = max(pair.stiffness, tangential) / near(m)
        self.time = dyadic_root(1 / max(fastest, near(pair.damping / m) ** 2))
        self.speed = dyadic_root(pair.closing_speed**2)
        self.length = self.time * self.speed
        self.eps = self.length / pair.reach
        self.bend = [pair.lever * self.length / radius for radius in pair.radii]
        self.torque_bend = [pair.lever_of_torque * self.length / radius for radius in pair.radii]
        # K = k T^2/m, C = c T/m, Kt = k_t T^2/m
        self.k = pair.stiffness * self.time**2 / m
        self.c = pair.damping * self.time / m
        self.kt = spring * self.time**2 / m

    def force(self, y: State) -> Any:
        """The normal force K a + C u."""
        return self.overlap(y) * self.k + self.closing(y) * self.c

    def steepening(self, y: State) -> Any:
        """The rate K u + C u' of the normal force, in any mode: friction does not act along the
        normal.
        """
        return self.closing(y) * self.k + self.falling(y) * self.c

    def levers(self, y: State) -> list[Any]:
        """The levers l_i/R_i = 1 - b_i a of the slip, of both spheres."""
        overlap = self.overlap(y)
        return [1 - overlap * bend for bend in self.bend]

    def torque_levers(self, y: State) -> list[Any]:
        """The levers L_i/R_i of the torque of friction, of both spheres."""
        overlap = self.overlap(y)
        return [1 - overlap * bend for bend in self.torque_bend]

    def released(self) -> Guard:
        """The guard that ends a pressing phase: the force falls to zero.

        The spheres part there, or, if a dashpot may pull, are followed until the overlap ends.
        """
        if self.pair.damping and self.pair.ends_with_overlap:
            return Guard("pull", self.force, lambda y: Entry("pull", touching={"press": 1}))
        return Guard("release", self.force, lambda y: self.parting())


class PlanarPhases(LinearContact):
    """The modes of a contact in the plane, and the entry into the first.

    A pair and a wall differ only in how the direction of the normal turns (`turning`) and in the
    position that a state stands for (`cartesian`).
    """

    directions = 2

    @abstractmethod
    def turning(self, y: State, r: Any) -> Any:
        """The rate of the third coordinate, which is the angle phi of a pair's normal; r = 1 - eps
        a.
        """

    @abstractmethod
    def cartesian(self, y: State) -> list[Any]:
        """x, y in units of X and vx, vy in units of V, in contact."""

    @property
    def size(self) -> int:
        """The number of components of the state."""
        return 8

    def overlap(self, y: State) -> Any:
        """The scaled overlap a of a state."""
        return y[0]

    def closing(self, y: State) -> Any:
        """The scaled closing speed u of a state."""
        return y[1]

    def falling(self, y: State) -> Any:
        """The rate of change u' = -F - eps w^2/r^3 of the closing speed."""
        # u' = -F - eps w^2/r^3, r = 1 - eps a
        inverse_r = 1 / (1 - y[0] * self.eps)
        return -self.force(y) - y[3] * y[3] * inverse_r * inverse_r * inverse_r * self.eps

    def slip(self, y: State) -> Any:
        """The velocity w/r - l_1 o_1 - l_2 o_2 of surface 1 against surface 2, in units of V."""
        first, second = self.levers(y)
        return y[3] / (1 - y[0] * self.eps) - first * y[4] - second * y[5]

    def holding(self, y: State) -> Any:
        """The friction g that keeps the slip at zero.

        With levers l_i = 1 - b_i a and those of the torque L_i, slip' = g (1 + l_1 L_1 mu_1 + l_2
        L_2 mu_2) + u (eps w/r^2 + b_1 o_1 + b_2 o_2), as r' = -eps u and l_i' = -b_i u; g makes it
        zero.
        """
        r = 1 - y[0] * self.eps
        first, second = self.levers(y)
        first_torque, second_torque = self.torque_levers(y)
        by_closing = y[3] / (r * r) * self.eps + y[4] * self.bend[0] + y[5] * self.bend[1]
        # g = -u (eps w/r^2 + b_1 o_1 + b_2 o_2)/(1 + l_1 L_1 mu_1 + l_2 L_2 mu_2)
        turned = first * first_torque * self.ease[0] + second * second_torque * self.ease[1]
        inertia = 1 + turned
        return -y[1] * by_closing / inertia

    def lag(self, y: State, side: int) -> Any:
        """The rate sigma Kt slip - mu F' at which the force of a spring that slips would exceed its
        limit; sigma is `side`.
        """
        return self.slip(y) * (self.kt * side) - self.steepening(y) * self.friction

    def excess(self, y: Sequence[arb]) -> arb:
        """The margin mu F - |g| of friction over what keeps the slip at zero."""
        return ball(self.force, y) * arb_of(self.friction) - abs(ball(self.holding, y))

    def field(
        self, friction: Callable[[State], Any] | None, *, stretches: bool = False
    ) -> Callable[[State], list[Any]]:
        """The rates (8) of the state under a friction g(y), or without any.

        With `stretches` the tangential spring follows the slip, 2 s' = slip; else it stays.
        """

        def rates(y: State) -> list[Any]:
            """a' = u, u' (`falling`), phi' (`turning`), w' = r g, o_i', s', clock' = 1."""
            r = 1 - y[0] * self.eps
            if friction:
                g = friction(y)
            else:
                g = 0
            # o_i' = -L_i mu_i g.
            spin_rates = [
                lever * g * -ease
                for lever, ease in zip(self.torque_levers(y), self.ease, strict=True)
            ]
            if stretches:
                spring_rate = self.slip(y) / 2
            else:
                spring_rate = 0
            clock_rate = 1
            return [
                y[1],
                self.falling(y),
                self.turning(y, r),
                r * g,
                *spin_rates,
                spring_rate,
                clock_rate,
            ]

        return rates

    def modes(self) -> dict[str, Mode]:
        """Every mode that this pair can be in, by name."""
        free = self.field(None)
        modes = {
            "press": Mode(self.pressed_field(), (self.released(),)),
            "apart": Mode(lambda y: [0] * 7 + [1], leaves=lambda y: None),
        }
        if self.pair.damping and self.pair.ends_with_overlap:
            # The dashpot pulls until the overlap ends, unless the force comes back before.
            released = Guard("release", lambda y: y[0], lambda y: self.parting())
            pressed = Guard(
                "press", lambda y: -self.force(y), lambda y: self.pressing(y, rising=True)
            )
            modes["pull"] = Mode(free, (released, pressed))
        if self.friction and not self.rests:
            for side in (1, -1):
                modes[SLIDES[side]] = self.sliding(side)
            if self.kt:
                modes["stick"] = self.sticking()
            else:
                modes["hold"] = self.held()
        return modes

    def pressed_field(self) -> Callable[[State], list[Any]]:
        """The rates while the force presses and nothing slips.

        Where friction acts it sticks, on errors too: they are small beside its limit, until just
        before the force ends, when what is left of it changes them to the second order only.
        """
        if not self.rests:
            return self.field(None)
        if self.kt:
            return self.field(lambda y: -self.pull(y), stretches=True)
        return self.field(self.holding)

    def by_friction(self, y: State) -> list[Any]:
        """The rates (8) of the state by a friction g = 1 alone."""
        acts = self.field(lambda y: 1)(y)
        free = self.field(None)(y)
        return [one - other for one, other in zip(acts, free, strict=True)]

    def sliding(self, side: int) -> Mode:
        """The mode of friction at its limit, -sigma mu F, against a slip of sign `side` = sigma.

        A tangential spring is at its limit then. It sticks again where its force would fall below
        the limit; without a spring where the slip ends.
        """
        coefficient = self.friction * -side
        if self.kt:
            ends = Guard("stick", lambda y: self.lag(y, side), lambda y: self.caught(side))
        else:
            ends = Guard("stick", lambda y: self.slip(y) * side, lambda y: self.stopped(y, side))
        return Mode(self.field(lambda y: self.force(y) * coefficient), (ends, self.released()))

    def caught(self, side: int) -> Entry:
        """The entry into sticking of a spring that was at its limit: 2 Kt s = sigma mu F.

        From the zero of `lag` on the spring's force stays below its limit. There both are equal,
        and so are their rates: the guard of the slip vanishes to the second order.
        """
        # s = sigma mu F/(2 Kt)
        stretch = self.friction * side / (2 * self.kt)
        return Entry(
            "stick",
            lambda y: [*y[:6], self.force(y) * stretch, y[CLOCK]],
            {SLIDES[side]: 2},
        )

    def stopped(self, y: State, side: int) -> Entry:
        """The entry at zero slip without a spring: friction holds, or the slip changes its sign."""
        if sign(self.excess(y), "the excess of friction where the slip ends") > 0:
            return Entry("hold")
        return Entry(SLIDES[-side], touching={"stick": 1})

    def sticking(self) -> Mode:
        """The mode in which the tangential spring sticks, until its force reaches the limit."""
        guards = (self.slide(1, self.pull, {}), self.slide(-1, lambda y: -self.pull(y), {}))
        return Mode(self.field(lambda y: -self.pull(y), stretches=True), guards)

    def pull(self, y: State) -> Any:
        """The force 2 Kt s of the tangential spring."""
        return y[6] * (2 * self.kt)

    def held(self) -> Mode:
        """The mode without slip and without a spring, by whatever friction that needs.

        Where none is needed no direction is one to slide in, and the mode lasts as long as the
        force does.
        """
        if self.holds_by_itself():
            return Mode(self.field(None), (self.released(),))
        guards = (
            self.slide(1, lambda y: -self.holding(y), {"stick": 2}),
            self.slide(-1, self.holding, {"stick": 2}),
        )
        return Mode(self.field(self.holding), guards)

    def holds_by_itself(self) -> bool:
        """Whether the slip stays at zero without friction: `holding` is zero in every state, since
        neither the normal turns (eps = 0) nor do levers change (b_i = 0).
        """
        return not self.eps and not any(self.bend)

    def slide(self, side: int, pull: Callable[[State], Any], touching: dict[str, int]) -> Guard:
        """The guard mu F - pull(y) at whose zero friction reaches its limit, against a slip of sign
        `side`.
        """
        entry = Entry(SLIDES[side], touching=touching)
        return Guard(
            SLIDES[side], lambda y: self.force(y) * self.friction - pull(y), lambda y: entry
        )

    def first(self, y: State) -> Entry:
        """The entry at touch; what the parameters decide exactly is not left to balls."""
        return self.pressing(y, rising=not self.c, side=self.side_at_touch(y))

    def side_at_touch(self, y: State) -> int:
        """The sign of the slip at touch: 1, 0 or -1."""
        if self.pair.angle:
            return sign(ball(self.slip, y), "the slip at touch")
        # A head-on pair slips by its spins alone, which are exact numbers.
        return sign_of(-self.pair.surface_spin[2])

    def pressing(self, y: State, *, rising: bool, side: int | None = None) -> Entry:
        """The entry where the force begins: from zero (`rising`), or at once as a dashpot's does.

        `side` is the sign of the slip, found from the state where it is not given.
        """
        # The guard of the force vanishes at an entry where the force rises from zero.
        if rising:
            touching = {self.released().name: 1}
        else:
            touching = {}
        if not self.friction or self.rests:
            return Entry("press", touching=touching)
        if side is None:
            side = sign(ball(self.slip, y), "the slip where the contact presses again")
        if self.kt:
            return self.stretched(y, side, rising)
        if side:
            return Entry(SLIDES[side], touching=touching)
        if not rising and sign(self.excess(y), "the excess of friction at touch") > 0:
            return Entry("hold")
        # Friction does not suffice to hold: the slip begins against what would have held it.
        side = -sign(ball(self.holding, y), "the friction needed at touch")
        return Entry(SLIDES[side], touching={"stick": 1} | touching)

    def stretched(self, y: State, side: int, rising: bool) -> Entry:
        """The entry with an unstretched spring.

        It slides only where the limit mu F rises from zero (`rising`) more slowly than the spring's
        force; else it sticks.
        """
        if not rising:
            return Entry("stick")
        if side:
            lag = ball(lambda y: self.lag(y, side), y)
            if sign(lag, "k_t |slip| - friction dF/dt at touch") > 0:
                return Entry(SLIDES[side], touching={self.released().name: 1})
        # Limit and spring's force are both zero: the guards of both directions vanish.
        return Entry("stick", touching=dict.fromkeys(SLIDES.values(), 1))

    def parting(self) -> Entry:
        """The entry into free flight, whose state is the place at clock 0 of the straight line on
        which the spheres fly, and its velocity.
        """
        return Entry("apart", lambda y: [*line(self.cartesian(y), y[CLOCK]), *y[4:]])

    def place(self, mode: str, y: State) -> list[Any]:
        """x, y, vx, vy, o1, o2, s, clock of a state in the given mode."""
        if mode == "apart":
            return [y[0] + y[2] * y[CLOCK], y[1] + y[3] * y[CLOCK], *y[2:]]
        return [*self.cartesian(y), *y[4:]]


class ContactPhases(PlanarPhases):
    """The modes of a pair in the plane. A head-on pair `rests`: it never slips."""

    def __init__(self, pair: TouchingPair) -> None:
        self.spheres = pair
        self.in_units_of(pair, rubs=True)
        self.rests = pair.is_head_on and self.friction > 0

    def start(self) -> list[Callable[[], arb]]:
        """The state at touch: a = 0, u = v cos(angle)/V, phi = 0, w = -v sin(angle)/V, the spins, s
        = 0, clock 0.
        """
        pair = self.spheres

        def speed() -> arb:
            return arb_of(pair.closing_speed / self.speed)

        def closing() -> arb:
            return speed() * arb_of(pair.angle).cos()

        def tangential() -> arb:
            return -speed() * arb_of(pair.angle).sin()

        zero = partial(arb_of, 0)
        # o_i = R_i omega_i/V, of the spins about z.
        surface_speeds = [pair.radii[i] * pair.spins[3 * i + 2] / self.speed for i in (0, 1)]
        spins = [partial(arb_of, speed) for speed in surface_speeds]
        return [zero, closing, zero, tangential, *spins, zero, zero]

    def turning(self, y: State, r: Any) -> Any:
        """The rate phi' = eps w/r^2 of the normal."""
        return y[ACROSS] / (r * r) * self.eps

    def cartesian(self, y: State) -> list[Any]:
        """x, y in units of X and vx, vy in units of V, in contact: r = -rho (cos phi, sin phi)."""
        r = 1 - y[OVERLAP] * self.eps
        sine = y[NORMAL_ANGLE].sin()
        cosine = y[NORMAL_ANGLE].cos()
        # rho' = -u along the normal, rho phi' = w/r across it.
        closing = y[CLOSING]
        across = y[ACROSS] / r
        distance = r * (1 / self.eps)
        return [
            -distance * cosine,
            -distance * sine,
            closing * cosine + across * sine,
            closing * sine - across * cosine,
        ]


def ball(function: Callable[[State], Any], y: Sequence[arb]) -> arb:
    """The ball of a function of the state on balls `y` of it."""
    outputs, _ = traced(lambda y: [function(y)], len(y))
    value: arb = Program(outputs).run(y)[0]
    return value


def line(place: Sequence[Any], clock: Any) -> list[Any]:
    """The position at clock 0 of a straight flight, and its velocity, from both at a `clock`."""
    x, y, vx, vy = place
    return [x - vx * clock, y - vy * clock, vx, vy]


def dyadic_root(square: Fraction) -> Fraction:
    """A number of four bits, at most the root of `square` > 0 and at least 7/8 of it."""
    bits = (square.numerator.bit_length() - square.denominator.bit_length()) // 2
    unit = Fraction(2) ** (bits - 4)
    root = isqrt((square / unit**2).__floor__())
    # Only the four leading bits are kept.
    surplus = max(0, root.bit_length() - 4)
    return (root >> surplus << surplus) * unit
