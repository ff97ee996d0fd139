"""A sphere that touches the wall x = 0 from the left at t = 0, under the linear law: press, stick,
slip and release.

The modes are those of a pair (contact_phases) whose second body is flat and cannot be moved: no
curvature (eps = 0), one lever. The third coordinate is the way that the centre has gone against y,
in units of X. Law as in two_spheres; the force ends with the overlap.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from typing import Any

from flint import arb, arb_mat

from refdem.truth.balls import arb_of, unit_matrix
from refdem.truth.collision import Collision
from refdem.truth.contact_motion import ContactMotion
from refdem.truth.contact_phases import LinearContact, PlanarPhases, State, dyadic_root
from refdem.truth.events.truth import METHOD
from refdem.truth.reals import Number, near

NAMES = tuple(f"{kind}.{axis}" for kind in ("r", "v", "omega") for axis in "xyz")
MOVED = ("r.x", "r.y", "v.x", "v.y", "omega.z")


@dataclass(frozen=True, kw_only=True)
class WallPair:
    """Numbers in SI units: velocity (`normal`, `across`, 0), `spin` about z.

    `lever` is 0, 1/2, 1 for R, R-d/2, R-d.
    """

    mass: Number
    radius: Fraction
    stiffness: Fraction
    damping: Number
    tangential_stiffness: Fraction
    friction: Fraction
    normal: Number
    across: Number
    spin: Fraction
    lever: Fraction
    ends_with_overlap: bool = True
    angle: Fraction = Fraction(0)

    @property
    def effective_mass(self) -> Number:
        """The effective mass [kg] of the pair: that of the sphere."""
        return self.mass

    @property
    def is_head_on(self) -> bool:
        """Never taken for it: nothing is lost by integrating."""
        return False

    @property
    def slip(self) -> Number:
        """Velocity of the surface against the wall along -y at touch [m/s]."""
        return -self.across - self.radius * self.spin

    @property
    def surface_spin(self) -> list[Number]:
        """What a pair calls so: minus the slip."""
        return [Fraction(0), Fraction(0), -self.slip]

    @property
    def rubs(self) -> bool:
        """Something slips, or will once the lever has become shorter."""
        return self.friction > 0 and bool(self.slip or self.lever * self.spin)


class WallPhases(PlanarPhases):
    """Phases of a sphere against the wall."""

    def __init__(self, pair: WallPair) -> None:
        m = pair.mass
        self.pair = pair
        self.wall = pair
        # The wall is flat and does not turn: no curvature, and all of the torque is the sphere's.
        self.eps = Fraction(0)
        self.ease = [Fraction(5, 2), Fraction(0)]
        self.friction = pair.friction
        self.rests = self.friction > 0 and not pair.rubs
        spring = pair.tangential_stiffness * (self.friction > 0)
        fastest = max(pair.stiffness, spring * Fraction(7, 2)) / near(m)
        self.time = dyadic_root(1 / max(fastest, near(pair.damping / m) ** 2))
        self.speed = dyadic_root(near(pair.normal) ** 2 + near(pair.across) ** 2)
        self.length = self.time * self.speed
        self.bend = [pair.lever * self.length / pair.radius, Fraction(0)]
        self.torque_bend = self.bend
        self.k = pair.stiffness * self.time**2 / m
        self.c = pair.damping * self.time / m
        self.kt = spring * self.time**2 / m

    def start(self) -> list[Callable[[], arb]]:
        """The state of the sphere at touch."""
        pair = self.wall
        v = self.speed
        turns = pair.radius * pair.spin / v
        exact = (0, pair.normal / v, 0, -pair.across / v, turns, 0, 0, 0)
        return [partial(arb_of, value) for value in exact]

    def turning(self, y: State, r: Any) -> Any:
        """The rate of the way along the wall, which is in the place of the angle."""
        return y[3]

    def cartesian(self, y: State) -> list[Any]:
        """x, y in units of X and vx, vy in units of V, in contact."""
        return [y[0] - self.wall.radius / self.length, -y[2], y[1], -y[3]]


@dataclass(frozen=True)
class WallImpact(Collision):
    """Place [m], velocity [m/s] and angular velocity [rad/s], NAMES, at t >= 0.

    S counts what moves in the plane.
    """

    method = METHOD
    witness = (
        "Taylor series in Cartesian coordinates with the switches found anew; sliding formulas"
    )

    wall: WallPair

    @cached_property
    def phases(self) -> LinearContact:
        """The phases of the contact."""
        return WallPhases(self.wall)

    @property
    def effective_mass(self) -> Number:
        """The mass [kg] of the relative motion along the normal."""
        return self.wall.mass

    def formula_at(self, t: Fraction) -> None:
        """None: the motion is followed."""

    def formula_of_scalars(self) -> None:
        """None: the motion is followed."""

    def units(self) -> list[Fraction]:
        turns = self.phases.speed / self.wall.radius
        return [self.phases.length] * 2 + [self.phases.speed] * 2 + [turns, turns]

    def quantities(self, relative: Sequence[arb]) -> dict[str, arb]:
        """The nine quantities from x, y, vx, vy and the spin."""
        x, y, vx, vy, spin = relative[:5]
        nothing = arb(0)
        return dict(
            zip(NAMES, (x, y, nothing, vx, vy, nothing, nothing, nothing, spin), strict=True)
        )

    def extremes(self, motion: ContactMotion) -> dict[str, arb]:
        """The scalars of a pair; impulse_ratio (along y over along -x), rebound_across [m/s] and
        rebound_spin [rad/s].
        """
        scalars = self.contact_extremes(motion)
        begin = motion.phases[0].entered
        end = motion.phases[-2].crossing()[3]
        speed = arb_of(self.phases.speed)
        return scalars | {
            "impulse_ratio": (begin[3] - end[3]) / (begin[1] - end[1]),
            "rebound_across": -end[3] * speed,
            "rebound_spin": end[4] * arb_of(self.phases.speed / self.wall.radius),
        }

    def drifting(self) -> Sequence[int]:
        """Indices of drifting components: none, since the wall is fixed."""
        return ()

    def bodies(self) -> arb_mat:
        """The coordinates of the sphere are those of the mode; the spin that it has no use for
        comes after them.
        """
        return unit_matrix(self.phases.size - 1)

    def counted(self) -> Sequence[str]:
        return MOVED
