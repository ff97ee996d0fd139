"""Two spheres in contact whose friction turns out of a plane: the phases of the linear law in
Cartesian vectors, and where they end.

In the units of contact_phases.py: r = r1 - r2 (of length 1/eps at touch), v, o_i = R_i omega_i; n =
-r/|r| points from 1 to 2, a = 1/eps - |r|,
u = v.n, v' = -F n + f, o_i' = (1 - b_i a) mu_i n x f, slip = v - u n + ((1 - b_1 a) o_1 + (1 - b_2
a) o_2) x n, and the friction f on 1 is

    slip (no spring) -mu F slip/|slip|;  stick -Kt s with s' = slip - (s.n') n;  slip (spring) -mu F
    e, e the spring's direction, e' = Kt/(mu F) (slip - (slip.e) e) - (e.n') n, from |Kt s| = mu F
    on, until Kt slip.e = mu F';  pull (F < 0) 0.

Two ends are no analytic points of the motion: a slip without spring goes to zero on a spiral whose
steps grow as 1/|slip|, and a clipped spring turns ever faster where the normal force fades, or
begins. The code is `singular` if the motion is proved to begin at such a point. A motion that comes
near to one is followed until FAINT and ends with the code `grazing`: whether it meets that point is
not proved.
"""

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.contact_phases import LinearContact, State, ball
from refdem.truth.events.crossing import SwitchError, sign
from refdem.truth.events.system import Entry, Guard, Mode
from refdem.truth.sphere_pair import TouchingPair
from refdem.truth.vectors import Vector, cross, dot

FAINT = Fraction(1, 2**8)
"""Of the speed, or of the force of a unit of overlap: how near a singular end the motion is
followed.
"""


class SpatialPhases(LinearContact):
    """The phases of a pair whose friction turns out of a plane, in Cartesian vectors of three.

    State: r, v, o1, o2, the spring's stretch s (its direction e while it slips; left out without a
    spring), clock. Apart, r is replaced by r - v clock.
    """

    directions = 3

    def __init__(self, pair: TouchingPair) -> None:
        self.spheres = pair
        self.in_units_of(pair, rubs=True)

    @property
    def size(self) -> int:
        """The number of components of the state: five vectors and the clock, or four without a
        spring.
        """
        if self.kt:
            return 16
        return 13

    def start(self) -> list[Callable[[], arb]]:
        """The state at touch: r = (-1/eps, 0, 0), v = v0 (cos(angle), sin(angle), 0), o_i = R_i
        omega_i/V, an unstretched spring, clock 0.
        """
        pair = self.spheres
        zero = partial(arb_of, 0)

        def speed() -> arb:
            return arb_of(pair.closing_speed / self.speed)

        def normal_part() -> arb:
            return speed() * arb_of(pair.angle).cos()

        def tangential_part() -> arb:
            return speed() * arb_of(pair.angle).sin()

        spins = [
            partial(arb_of, pair.radii[k // 3] * spin / self.speed)
            for k, spin in enumerate(pair.spins)
        ]
        position: list[Callable[[], arb]] = [partial(arb_of, -1 / self.eps), zero, zero]
        velocity: list[Callable[[], arb]] = [normal_part, tangential_part, zero]
        spring_and_clock: list[Callable[[], arb]] = [zero] * (self.size - 12)
        return [*position, *velocity, *spins, *spring_and_clock]

    def distance(self, y: State) -> Any:
        """The distance |r| of the centres."""
        return dot(y[:3], y[:3]).sqrt()

    def normal(self, y: State) -> Vector:
        """The unit normal n (3) of the contact."""
        distance = self.distance(y)
        return [-x / distance for x in y[:3]]

    def overlap(self, y: State) -> Any:
        """The scaled overlap a of a state."""
        return -self.distance(y) + 1 / self.eps

    def closing(self, y: State) -> Any:
        """The scaled closing speed u of a state."""
        return dot(y[3:6], self.normal(y))

    def falling(self, y: State) -> Any:
        """The rate u' = -F - (v^2 - u^2)/|r| of the closing speed."""
        closing = self.closing(y)
        return -self.force(y) - (dot(y[3:6], y[3:6]) - closing * closing) / self.distance(y)

    def turning(self, y: State) -> Vector:
        """The rate n' = (u n - v)/|r| (3) at which the normal turns."""
        distance = self.distance(y)
        closing = self.closing(y)
        return [(n * closing - v) / distance for n, v in zip(self.normal(y), y[3:6], strict=True)]

    def slip(self, y: State) -> Vector:
        """The velocity (3) of surface 1 against surface 2: v - u n + (l_1 o_1 + l_2 o_2) x n."""
        normal = self.normal(y)
        closing = self.closing(y)
        first, second = self.levers(y)
        surface_spin = [first * a + second * b for a, b in zip(y[6:9], y[9:12], strict=True)]
        by_spin = cross(surface_spin, normal)
        return [v - n * closing + w for v, n, w in zip(y[3:6], normal, by_spin, strict=True)]

    def lag(self, y: State, side: int = 1) -> Any:
        """The rate Kt slip.e - mu F' at which the force of a spring that slips would exceed its
        limit.
        """
        return dot(self.slip(y), y[12:15]) * (self.kt * side) - self.steepening(y) * self.friction

    def field(
        self, friction: Callable[[State], Any] | None, *, stretches: bool = False
    ) -> Callable[[State], list[Any]]:
        """The rates of the state under a friction f(y) (3), or without any.

        With `stretches` y[12:15] is the spring's stretch, which follows the slip; else its
        direction, at the limit.
        """

        def rates(y: State) -> list[Any]:
            """r' = v, v' = -F n + f, o_i' = L_i mu_i n x f, the spring's rate, clock' = 1."""
            normal = self.normal(y)
            force = self.force(y)
            if friction:
                tangential: Vector = friction(y)
            else:
                tangential = [0, 0, 0]
            # v' = -F n + f, o_i' = L_i mu_i n x f; `ease` has mu_i.
            acceleration = [f - n * force for f, n in zip(tangential, normal, strict=True)]
            torque = cross(normal, tangential)
            spin_rates = [
                lever * ease * x
                for lever, ease in zip(self.torque_levers(y), self.ease, strict=True)
                for x in torque
            ]
            spring_rates = [0] * (self.size - 13)
            if friction and self.kt:
                if stretches:
                    spring_rates = self.stretching(y)
                else:
                    spring_rates = self.direction_rate(y)
            clock_rate = 1
            return [*y[3:6], *acceleration, *spin_rates, *spring_rates, clock_rate]

        return rates

    def stretching(self, y: State) -> list[Any]:
        """The rate s' = slip - (s.n') n (3) at which the tangential spring stretches."""
        # s' = slip - (s . n') n, so that s stays at right angles to n.
        along_normal = dot(y[12:15], self.turning(y))
        return [w - n * along_normal for w, n in zip(self.slip(y), self.normal(y), strict=True)]

    def direction_rate(self, y: State) -> list[Any]:
        """The rate e' = Kt/(mu F) (slip - (slip.e) e) - (e.n') n (3) of the direction of the spring
        at its limit.
        """
        slip = self.slip(y)
        e = y[12:15]
        slip_along_e = dot(slip, e)
        along_normal = dot(e, self.turning(y))
        # e' = Kt/(mu F) (slip - (slip . e) e) - (e . n') n
        rate = self.kt / self.friction / self.force(y)
        return [
            (w - x * slip_along_e) * rate - n * along_normal
            for w, x, n in zip(slip, e, self.normal(y), strict=True)
        ]

    def modes(self) -> dict[str, Mode]:
        """Every mode that this pair can be in, by name."""
        at_rest = [0] * (self.size - 1)
        modes = {
            "press": Mode(self.field(None), (self.released(),)),
            "apart": Mode(lambda y: [*at_rest, 1], leaves=lambda y: None),
        }
        if self.pair.damping and self.pair.ends_with_overlap:
            # The dashpot pulls until the overlap ends, unless the force comes back before.
            released = Guard("release", self.overlap, lambda y: self.parting())
            pressed = Guard(
                "press", lambda y: -self.force(y), lambda y: self.pressing(y, rising=True)
            )
            modes["pull"] = Mode(self.field(None), (released, pressed))
        if self.kt:
            return modes | self.modes_with_spring()
        fades = Guard(
            "fade", self.margin_of_slip, lambda y: self.fading("the slip falls out of any plane")
        )
        modes["slip"] = Mode(self.field(self.sliding_friction), (self.released(), fades))
        return modes

    def modes_with_spring(self) -> dict[str, Mode]:
        """The modes of a tangential spring: slipping with it at its limit, and sticking."""
        fades = Guard(
            "fade",
            lambda y: self.force(y) - FAINT,
            lambda y: self.fading("a clipped spring turns as the force fades"),
        )
        sticks = Guard("stick", self.lag, lambda y: Entry("stick", self.clipped, {"slip": 2}))
        slips = Guard("slip", self.spared, lambda y: Entry("slip", pointed))
        # Friction is -mu F e at the limit, -Kt s below it.
        slipping = self.field(lambda y: self.limit(y, y[12:15]))
        sticking = self.field(lambda y: [s * -self.kt for s in y[12:15]], stretches=True)
        return {"slip": Mode(slipping, (sticks, fades)), "stick": Mode(sticking, (slips,))}

    def margin_of_slip(self, y: State) -> Any:
        """slip^2 - FAINT^2: what there is of the slip before it is faint."""
        slip = self.slip(y)
        return dot(slip, slip) - FAINT * FAINT

    def limit(self, y: State, direction: Vector) -> list[Any]:
        """Friction -mu F e (3) at its limit, against a unit vector e."""
        most = self.force(y) * -self.friction
        return [x * most for x in direction]

    def sliding_friction(self, y: State) -> list[Any]:
        """The friction force -mu F slip/|slip| (3)."""
        slip = self.slip(y)
        speed = dot(slip, slip).sqrt()
        return self.limit(y, [x / speed for x in slip])

    def spared(self, y: State) -> Any:
        """The margin (mu F)^2 - (Kt |s|)^2 of the spring's force to Coulomb's limit."""
        most = self.force(y) * self.friction
        return most * most - dot(y[12:15], y[12:15]) * (self.kt * self.kt)

    def clipped(self, y: State) -> list[Any]:
        """The state with the stretch s = mu F/Kt e in place of the direction e of the spring."""
        most = self.force(y) * (self.friction / self.kt)
        return [*y[:12], *(x * most for x in y[12:15]), y[15]]

    def fading(self, why: str) -> Entry:
        """Raises SwitchError near a point at which the motion may not be analytic; more bits come
        no nearer.
        """
        error = SwitchError(
            "grazing", f"{why} to 1/{1 / FAINT} of its scale, below which it is not followed", 0.0
        )
        error.final = True
        raise error

    def begins_singular(self, why: str) -> Entry:
        """Raises SwitchError at a start that is proved to be no analytic point."""
        raise SwitchError("singular", f"{why}, which is no analytic point of the motion", 0.0)

    def first(self, y: State) -> Entry:
        return self.pressing(y, rising=not self.c)

    def pressing(self, y: State, *, rising: bool, side: int | None = None) -> Entry:
        """The entry where the force begins: from zero (`rising`), or at once as a dashpot's does.

        Raises SwitchError where the motion begins at a point that is not analytic, or near one.
        `side` is that of a motion in a plane; here the slip has a direction.
        """
        slip_squared = ball(lambda y: dot(self.slip(y), self.slip(y)), y)
        if self.kt:
            return self.pressing_on_spring(y, slip_squared, rising=rising)
        if slip_squared == 0:
            self.begins_singular("the slip begins from zero out of any plane")
        if not slip_squared > arb_of(FAINT * FAINT):
            self.fading("the slip begins out of any plane, and is small")
        # The guard of the force vanishes at an entry where the force rises from zero.
        if rising:
            touching = {self.released().name: 1}
        else:
            touching = {}
        return Entry("slip", None, touching)

    def pressing_on_spring(self, y: State, slip_squared: arb, *, rising: bool) -> Entry:
        """The entry of `pressing` with a tangential spring, which sticks at first.

        It would slip at once, at a singular point, where the limit mu F rises from zero more slowly
        than the spring's force: Kt |slip| > mu F'.
        """
        if not rising:
            return Entry("stick", self.unstretched)
        limit_rate = ball(lambda y: self.steepening(y) * self.friction, y)
        margin = slip_squared * arb_of(self.kt) ** 2 - limit_rate * limit_rate
        if sign(margin, "k_t |slip| - friction dF/dt at touch") > 0:
            self.begins_singular("a clipped spring turns as the force begins")
        return Entry("stick", self.unstretched, {"slip": 2})

    @staticmethod
    def unstretched(y: State) -> list[Any]:
        """The state with an unstretched spring, s = 0, where the contact begins."""
        return [*y[:12], 0, 0, 0, y[15]]

    def parting(self) -> Entry:
        """The entry into free flight, whose state has r - v clock in place of r."""

        def at_clock_zero(y: State) -> list[Any]:
            clock = y[-1]
            position = [x - v * clock for x, v in zip(y[:3], y[3:6], strict=True)]
            return [*position, *y[3:]]

        return Entry("apart", at_clock_zero)

    def place(self, mode: str, y: State) -> list[Any]:
        """r, v, o1, o2, the spring and the clock of a state in the given mode."""
        if mode == "apart":
            clock = y[-1]
            position = [x + v * clock for x, v in zip(y[:3], y[3:6], strict=True)]
            return [*position, *y[3:]]
        return list(y)


def pointed(y: State) -> list[Any]:
    """The state with the direction e = s/|s| in place of the stretch s of the spring."""
    length = dot(y[12:15], y[12:15]).sqrt()
    return [*y[:12], *(x / length for x in y[12:15]), y[15]]
