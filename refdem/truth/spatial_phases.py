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
begins. `singular` is said where the motion is proved to begin at such a point; where it comes near
to one it is followed until FAINT, and ends as `grazing`: whether it meets that point is not proved.
"""

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.truth.balls import arb_of
from refdem.truth.contact_phases import LinearContact, State, ball
from refdem.truth.events.crossing import SwitchError, sign
from refdem.truth.events.system import Entry, Guard, Mode
from refdem.truth.sphere_pair import TouchingPair

FAINT = Fraction(1, 2**8)
"""Of the speed, or of the force of a unit of overlap: how near a singular end the motion is
followed.
"""
Vector = Sequence[Any]


class SpatialPhases(LinearContact):
    """State: r, v, o1, o2, the spring s or its direction e (three zeros without a spring are left
    out), clock; apart r - v clock, v.
    """

    def __init__(self, pair: TouchingPair) -> None:
        self.spheres = pair
        self.in_units_of(pair, rubs=True)

    @property
    def size(self) -> int:
        """The number of components of the state."""
        if self.kt:
            return 16
        return 13

    def start(self) -> list[Callable[[], arb]]:
        """The state of the contact at touch."""
        pair = self.spheres
        nothing = partial(arb_of, 0)

        def part(wave: Callable[[arb], arb]) -> Callable[[], arb]:
            return lambda: arb_of(pair.closing_speed / self.speed) * wave(arb_of(pair.angle))

        spins = [
            partial(arb_of, pair.radii[k // 3] * spin / self.speed)
            for k, spin in enumerate(pair.spins)
        ]
        place = [partial(arb_of, -1 / self.eps), nothing, nothing]
        return [
            *place,
            part(arb.cos),
            part(arb.sin),
            nothing,
            *spins,
            *[nothing] * (self.size - 12),
        ]

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
        """The rate n' (3) at which the normal turns."""
        distance = self.distance(y)
        closing = self.closing(y)
        return [(n * closing - v) / distance for n, v in zip(self.normal(y), y[3:6], strict=True)]

    def slip(self, y: State) -> Vector:
        """Velocity of surface 1 against surface 2."""
        normal = self.normal(y)
        closing = self.closing(y)
        (first, second) = self.levers(y)
        carried = cross(
            [first * a + second * b for a, b in zip(y[6:9], y[9:12], strict=True)], normal
        )
        return [v - n * closing + w for v, n, w in zip(y[3:6], normal, carried, strict=True)]

    def lag(self, y: State, side: int = 1) -> Any:
        """The rate at which the force of a spring that slips would exceed its limit."""
        return dot(self.slip(y), y[12:15]) * (self.kt * side) - self.steepening(y) * self.friction

    def field(
        self, friction: Callable[[State], Any] | None, *, stretches: bool = False
    ) -> Callable[[State], list[Any]]:
        """The rates under a friction (a vector).

        `stretches`: the spring follows the slip, else its direction does.
        """

        def rates(y: State) -> list[Any]:
            normal = self.normal(y)
            force = self.force(y)
            if friction:
                rub: Vector = friction(y)
            else:
                rub = [0, 0, 0]
            twist = cross(normal, rub)
            spun = [
                lever * ease * x
                for lever, ease in zip(self.levers(y), self.ease, strict=True)
                for x in twist
            ]
            spring = [0] * (self.size - 13)
            if friction and self.kt:
                if stretches:
                    spring = self.stretching(y)
                else:
                    spring = self.leaning(y)
            return [
                *y[3:6],
                *(f - n * force for f, n in zip(rub, normal, strict=True)),
                *spun,
                *spring,
                1,
            ]

        return rates

    def stretching(self, y: State) -> list[Any]:
        """The rate s' (3) at which the tangential spring stretches."""
        back = dot(y[12:15], self.turning(y))
        return [w - n * back for w, n in zip(self.slip(y), self.normal(y), strict=True)]

    def leaning(self, y: State) -> list[Any]:
        """The rate e' (3) of the direction of the spring at its limit."""
        slip = self.slip(y)
        e = y[12:15]
        along = dot(slip, e)
        back = dot(e, self.turning(y))
        quick = self.kt / self.friction / self.force(y)
        return [
            (w - x * along) * quick - n * back
            for w, x, n in zip(slip, e, self.normal(y), strict=True)
        ]

    def modes(self) -> dict[str, Mode]:
        """Every mode that this pair can be in."""
        idle = [0] * (self.size - 1)
        found = {
            "press": Mode(self.field(None), (self.released(),)),
            "apart": Mode(lambda y: [*idle, 1], leaves=lambda y: None),
        }
        if self.pair.damping and self.pair.ends_with_overlap:
            again = Guard(
                "press", lambda y: -self.force(y), lambda y: self.pressing(y, rising=True)
            )
            found["pull"] = Mode(
                self.field(None), (Guard("release", self.overlap, lambda y: self.parting()), again)
            )
        if not self.kt:
            fades = Guard(
                "fade", self.left, lambda y: self.fading("the slip falls out of any plane")
            )
            return found | {
                "slip": Mode(self.field(self.sliding_friction), (self.released(), fades))
            }
        fades = Guard(
            "fade",
            lambda y: self.force(y) - FAINT,
            lambda y: self.fading("a clipped spring turns as the force fades"),
        )
        back = Guard("stick", self.lag, lambda y: Entry("stick", self.clipped, {"slip": 2}))
        loose = Guard("slip", self.spared, lambda y: Entry("slip", pointed))
        return found | {
            "slip": Mode(self.field(lambda y: self.limit(y, y[12:15])), (back, fades)),
            "stick": Mode(
                self.field(lambda y: [s * -self.kt for s in y[12:15]], stretches=True), (loose,)
            ),
        }

    def left(self, y: State) -> Any:
        """What there is of the slip before it is faint."""
        slip = self.slip(y)
        return dot(slip, slip) - FAINT * FAINT

    def limit(self, y: State, towards: Vector) -> list[Any]:
        """Friction at its limit against a unit vector."""
        most = self.force(y) * -self.friction
        return [x * most for x in towards]

    def sliding_friction(self, y: State) -> list[Any]:
        """The friction force (3), opposite to the slip."""
        slip = self.slip(y)
        speed = dot(slip, slip).sqrt()
        return self.limit(y, [x / speed for x in slip])

    def spared(self, y: State) -> Any:
        """The margin (mu F)^2 - (Kt s)^2 to Coulomb's limit."""
        most = self.force(y) * self.friction
        return most * most - dot(y[12:15], y[12:15]) * (self.kt * self.kt)

    def clipped(self, y: State) -> list[Any]:
        """The spring whose direction is known, at its limit."""
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
        """The entry where the force begins: from zero (`rising`), or at once as a dashpot's
        does.
        """
        speed = ball(lambda y: dot(self.slip(y), self.slip(y)), y)
        if self.kt:
            steep = ball(lambda y: self.steepening(y) * self.friction, y)
            if (
                rising
                and sign(
                    speed * arb_of(self.kt) ** 2 - steep * steep,
                    "k_t |slip| - friction dF/dt at touch",
                )
                > 0
            ):
                self.begins_singular("a clipped spring turns as the force begins")
            return Entry("stick", self.unstretched, {"slip": 2} if rising else {})
        if speed == 0:
            self.begins_singular("the slip begins from zero out of any plane")
        if not speed > arb_of(FAINT * FAINT):
            self.fading("the slip begins out of any plane, and is small")
        return Entry("slip", None, {self.released().name: 1} if rising else {})

    @staticmethod
    def unstretched(y: State) -> list[Any]:
        """The spring where the contact begins."""
        return [*y[:12], 0, 0, 0, y[15]]

    def parting(self) -> Entry:
        """The entry into free flight at the end of contact."""
        return Entry(
            "apart",
            lambda y: [*(x - v * y[-1] for x, v in zip(y[:3], y[3:6], strict=True)), *y[3:]],
        )

    def place(self, mode: str, y: State) -> list[Any]:
        """r, v, o1, o2, the spring, clock in any mode."""
        if mode == "apart":
            return [*(x + v * y[-1] for x, v in zip(y[:3], y[3:6], strict=True)), *y[3:]]
        return list(y)


def pointed(y: State) -> list[Any]:
    """The direction of a spring in its place."""
    size = dot(y[12:15], y[12:15]).sqrt()
    return [*y[:12], *(x / size for x in y[12:15]), y[15]]


def dot(a: Vector, b: Vector) -> Any:
    """a . b of three numbers each."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> list[Any]:
    """The cross product a x b of two vectors (3)."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
