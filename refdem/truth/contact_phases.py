"""Two spheres in contact, in the plane: the phases press, stick, hold, slip and pull of the linear
law, and the switches between them.

Polar coordinates of r = r1 - r2 = -rho (cos phi, sin phi), in units of a time T, a speed V and the
length X = V T, all dyadic, with m the effective mass and D = R1 + R2: overlap d = D - rho = X a, a'
= u, h = rho^2 phi' = D V w, omega_i = V o_i/R_i, tangential spring 2 X s,

    F = m X/T^2 (K a + C u),  u' = -(K a + C u) - eps w^2/r^3,  phi' = eps w/r^2,  w' = r g,  o_i' =
    -(1 - b_i a) mu_i g,

r = 1 - eps a, eps = X/D, mu_i = m R_i^2/J_i, levers l_i = R_i - beta d = R_i (1 - b_i a) with beta
= 0, 1/2, 1, and g the friction on body 1 along the normal r/rho turned by +90 degrees about z. The
slip is V (w/r - (1 - b_1 a) o_1 - (1 - b_2 a) o_2), and g is

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
from refdem.truth.reals import Number, near
from refdem.truth.sphere_pair import TouchingPair
from refdem.truth.traced_field import Program, traced

State = Sequence[Any]
"""(a, u, phi, w, o1, o2, s, clock); apart: x - vx clock, y - vy clock, vx, vy in units of X and V
in the first four places.
"""
SLIDES = {1: "slip", -1: "slip back"}


class Touching(Protocol):
    """What of a pair decides which modes there are."""

    @property
    def damping(self) -> Number: ...

    @property
    def ends_with_overlap(self) -> bool: ...

    @property
    def surface_spin(self) -> Sequence[Number]: ...

    @property
    def angle(self) -> Fraction: ...


class LinearContact(ABC):
    """The phases of a contact under the linear law, in the units of the module: what does not
    depend on the coordinates in which the motion is told.
    """

    pair: Touching
    friction: Fraction
    time: Fraction
    speed: Fraction
    length: Fraction
    eps: Fraction
    ease: Sequence[Number]
    bend: Sequence[Number]
    k: Number
    c: Number
    kt: Number

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
        """The rate u' of the closing speed."""

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
        """Places, velocities, spins, spring and clock in any mode: as many as the state has."""

    def in_units_of(self, pair: TouchingPair, *, rubs: bool) -> None:
        """Sets the units and the numbers of a pair; without `rubs` friction is left out."""
        m = pair.effective_mass
        masses = [m / mass for mass in pair.masses]
        self.pair = pair
        self.ease = [Fraction(5, 2) * share for share in masses]
        self.friction = pair.friction * rubs
        spring = pair.tangential_stiffness * (self.friction > 0)
        fastest = max(pair.stiffness, near(spring * (1 + sum(self.ease)))) / near(m)
        self.time = dyadic_root(1 / max(fastest, near(pair.damping / m) ** 2))
        self.speed = dyadic_root(pair.closing_speed**2)
        self.length = self.time * self.speed
        self.eps = self.length / pair.reach
        self.bend = [pair.lever * self.length / radius for radius in pair.radii]
        self.k = pair.stiffness * self.time**2 / m
        self.c = pair.damping * self.time / m
        self.kt = spring * self.time**2 / m

    def force(self, y: State) -> Any:
        """The normal force K a + C u."""
        return self.overlap(y) * self.k + self.closing(y) * self.c

    def steepening(self, y: State) -> Any:
        """The rate of the normal force, in any mode: friction does not act along the normal."""
        return self.closing(y) * self.k + self.falling(y) * self.c

    def levers(self, y: State) -> list[Any]:
        """The levers l_i/R_i of both spheres."""
        overlap = self.overlap(y)
        return [1 - overlap * bend for bend in self.bend]

    def released(self) -> Guard:
        """The end of what presses: apart, or, damped, pulling until the overlap ends."""
        if self.pair.damping and self.pair.ends_with_overlap:
            return Guard("pull", self.force, lambda y: Entry("pull", touching={"press": 1}))
        return Guard("release", self.force, lambda y: self.parting())


class PlanarPhases(LinearContact):
    """The modes of a contact in the plane, and the entry into the first.

    What differs between a pair and a wall is how the direction of the normal turns, and where the
    sphere then is.
    """

    @abstractmethod
    def turning(self, y: State, r: Any) -> Any:
        """The rate of the third coordinate."""

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
        """The rate of change u' of the closing speed."""
        curve = 1 / (1 - y[0] * self.eps)
        return -self.force(y) - y[3] * y[3] * curve * curve * curve * self.eps

    def slip(self, y: State) -> Any:
        """Velocity of surface 1 against surface 2."""
        first, second = self.levers(y)
        return y[3] / (1 - y[0] * self.eps) - first * y[4] - second * y[5]

    def holding(self, y: State) -> Any:
        """The friction g that keeps the slip at zero."""
        r = 1 - y[0] * self.eps
        (first, second) = self.levers(y)
        carried = y[3] / (r * r) * self.eps + y[4] * self.bend[0] + y[5] * self.bend[1]
        return -y[1] * carried / (1 + first * first * self.ease[0] + second * second * self.ease[1])

    def lag(self, y: State, side: int) -> Any:
        """The rate at which the force of a spring that slips would exceed its limit."""
        return self.slip(y) * (self.kt * side) - self.steepening(y) * self.friction

    def excess(self, y: Sequence[arb]) -> arb:
        """The margin of friction over what keeps the slip at zero."""
        return ball(self.force, y) * arb_of(self.friction) - abs(ball(self.holding, y))

    def field(
        self, friction: Callable[[State], Any] | None, *, stretches: bool = False
    ) -> Callable[[State], list[Any]]:
        """The rates under a friction."""

        def rates(y: State) -> list[Any]:
            r = 1 - y[0] * self.eps
            if friction:
                g = friction(y)
            else:
                g = 0
            spun = [
                lever * g * -ease for lever, ease in zip(self.levers(y), self.ease, strict=True)
            ]
            return [
                y[1],
                self.falling(y),
                self.turning(y, r),
                r * g,
                *spun,
                self.slip(y) / 2 if stretches else 0,
                1,
            ]

        return rates

    def modes(self) -> dict[str, Mode]:
        """Every mode that this pair can be in."""
        free = self.field(None)
        found = {
            "press": Mode(free, (self.released(),)),
            "apart": Mode(lambda y: [0] * 7 + [1], leaves=lambda y: None),
        }
        if self.pair.damping and self.pair.ends_with_overlap:
            again = Guard(
                "press", lambda y: -self.force(y), lambda y: self.pressing(y, rising=True)
            )
            found["pull"] = Mode(
                free, (Guard("release", lambda y: y[0], lambda y: self.parting()), again)
            )
        if self.friction:
            found |= {SLIDES[side]: self.sliding(side) for side in (1, -1)}
            found |= {"stick": self.sticking()} if self.kt else {"hold": self.held()}
        return found

    def sliding(self, side: int) -> Mode:
        """Friction at its limit, against a slip of that sign; with a spring it is clipped."""
        push = self.friction * -side
        if self.kt:
            back = Guard("stick", lambda y: self.lag(y, side), lambda y: self.caught(side))
        else:
            back = Guard("stick", lambda y: self.slip(y) * side, lambda y: self.stopped(y, side))
        return Mode(self.field(lambda y: self.force(y) * push), (back, self.released()))

    def caught(self, side: int) -> Entry:
        """The clipped spring shortens less than its limit falls: from now on it holds."""
        stretch = self.friction * side / (2 * self.kt)
        return Entry(
            "stick",
            lambda y: [*y[:6], self.force(y) * stretch, y[7]],
            {"slip" if side > 0 else "slip back": 2},
        )

    def stopped(self, y: State, side: int) -> Entry:
        """The entry at zero slip without a spring: it holds, or the slip changes its sign."""
        if sign(self.excess(y), "the excess of friction where the slip ends") > 0:
            return Entry("hold")
        return Entry(SLIDES[-side], touching={"stick": 1})

    def sticking(self) -> Mode:
        """The mode in which the tangential spring sticks."""
        guards = (self.slide(1, self.pull, {}), self.slide(-1, lambda y: -self.pull(y), {}))
        return Mode(self.field(lambda y: -self.pull(y), stretches=True), guards)

    def pull(self, y: State) -> Any:
        """Force of the tangential spring."""
        return y[6] * (2 * self.kt)

    def held(self) -> Mode:
        """No slip, by whatever friction that needs."""
        guards = (
            self.slide(1, lambda y: -self.holding(y), {"stick": 2}),
            self.slide(-1, self.holding, {"stick": 2}),
        )
        return Mode(self.field(self.holding), guards)

    def slide(self, side: int, pull: Callable[[State], Any], touching: dict[str, int]) -> Guard:
        """The limit, reached by a friction against a slip of that sign."""
        entry = Entry(SLIDES[side], touching=touching)
        return Guard(
            SLIDES[side], lambda y: self.force(y) * self.friction - pull(y), lambda y: entry
        )

    def first(self, y: State) -> Entry:
        """The entry at touch; what the parameters decide exactly is not left to balls."""
        return self.pressing(y, rising=not self.c, side=self.side_at_touch(y))

    def side_at_touch(self, y: State) -> int:
        """The sign of the slip at touch: 1, 0 or -1."""
        exact = -self.pair.surface_spin[2]
        if self.pair.angle:
            return sign(ball(self.slip, y), "the slip at touch")
        return (exact > 0) - (exact < 0)

    def pressing(self, y: State, *, rising: bool, side: int | None = None) -> Entry:
        """The entry where the force begins: from zero (`rising`), or at once as a dashpot's
        does.
        """
        ends = self.released().name
        if not self.friction:
            return Entry("press", touching={ends: 1} if rising else {})
        if side is None:
            side = sign(ball(self.slip, y), "the slip where the contact presses again")
        else:
            side = side
        if self.kt:
            return self.stretched(y, side, rising)
        if side:
            return Entry(SLIDES[side], touching={ends: 1} if rising else {})
        if not rising and sign(self.excess(y), "the excess of friction at touch") > 0:
            return Entry("hold")
        side = -sign(ball(self.holding, y), "the friction needed at touch")
        return Entry(SLIDES[side], touching={"stick": 1, ends: 1} if rising else {"stick": 1})

    def stretched(self, y: State, side: int, rising: bool) -> Entry:
        """The entry with an unstretched spring: it slides only if the limit rises from zero more
        slowly than the spring's force.
        """
        if (
            rising
            and side
            and sign(ball(lambda y: self.lag(y, side), y), "k_t |slip| - friction dF/dt at touch")
            > 0
        ):
            return Entry(SLIDES[side], touching={self.released().name: 1})
        return Entry("stick", touching=dict.fromkeys(SLIDES.values(), 1) if rising else {})

    def parting(self) -> Entry:
        """Free flight: the straight line on which the spheres are, and its velocity."""
        return Entry("apart", lambda y: [*line(self.cartesian(y), y[7]), *y[4:]])

    def place(self, mode: str, y: State) -> list[Any]:
        """x, y, vx, vy, o1, o2, s, clock in any mode: as many coordinates as the state has."""
        if mode == "apart":
            return [y[0] + y[2] * y[7], y[1] + y[3] * y[7], *y[2:]]
        return [*self.cartesian(y), *y[4:]]


class ContactPhases(PlanarPhases):
    """The modes of a pair in the plane. Without `rubs` friction is left out."""

    def __init__(self, pair: TouchingPair, *, rubs: bool = True) -> None:
        self.spheres = pair
        self.in_units_of(pair, rubs=rubs)

    def start(self) -> list[Callable[[], arb]]:
        """The state of the contact at touch."""
        pair = self.spheres

        def part(wave: Callable[[arb], arb], sense: int) -> Callable[[], arb]:
            return lambda: (
                sense * arb_of(pair.closing_speed / self.speed) * wave(arb_of(pair.angle))
            )

        spins = [pair.radii[i] * pair.spins[3 * i + 2] / self.speed for i in (0, 1)]
        nothing = partial(arb_of, 0)
        turning = [partial(arb_of, spin) for spin in spins]
        return [nothing, part(arb.cos, 1), nothing, part(arb.sin, -1), *turning, nothing, nothing]

    def turning(self, y: State, r: Any) -> Any:
        """The rate phi' = eps w/r^2 of the normal."""
        return y[3] / (r * r) * self.eps

    def cartesian(self, y: State) -> list[Any]:
        """x, y in units of X and vx, vy in units of V, in contact."""
        r = 1 - y[0] * self.eps
        sine = y[2].sin()
        cosine = y[2].cos()
        across = y[3] / r
        far = r * (1 / self.eps)
        return [
            -far * cosine,
            -far * sine,
            y[1] * cosine + across * sine,
            y[1] * sine - across * cosine,
        ]


def ball(function: Callable[[State], Any], y: Sequence[arb]) -> arb:
    """The ball of a function of the state."""
    found: arb = Program(traced(lambda y: [function(y)], len(y))[0]).run(y)[0]
    return found


def line(place: Sequence[Any], clock: Any) -> list[Any]:
    """Where a straight flight was at clock 0, and its velocity."""
    x, y, vx, vy = place
    return [x - vx * clock, y - vy * clock, vx, vy]


def dyadic_root(square: Fraction) -> Fraction:
    """A number of four bits, at most the root of `square` > 0 and at least 7/8 of it."""
    bits = (square.numerator.bit_length() - square.denominator.bit_length()) // 2
    unit = Fraction(2) ** (bits - 4)
    found = isqrt((square / unit**2).__floor__())
    surplus = max(0, found.bit_length() - 4)
    return (found >> surplus << surplus) * unit
