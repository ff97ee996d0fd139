"""Two spheres about to touch: exact parameters and what follows from them for the relative motion.

Everything is exact but the components of the velocity at touch, v (cos angle, sin angle), which are
balls (`SpherePair.start`). The decisions that need no ball are made here: `is_head_on`,
`leaves_plane`.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.dual import stays_zero
from refdem.truth.exact import number, vector
from refdem.truth.reals import Number, near


@dataclass(frozen=True, kw_only=True)
class TouchingPair(ABC):
    """The parameters, in SI units, of a sphere that touches another one.

    `masses` [kg] and `radii` [m] are those of both, `spins` (6,) [rad/s] their angular velocities.
    `stiffness`, `damping` and `tangential_stiffness` are those of the linear law, `friction` is
    Coulomb's. Body 1 comes at `closing_speed` [m/s] under `angle` [rad] to the normal. `lever` is
    0, 1/2, 1 where slip is measured at R, R-d/2, R-d, d being the overlap; `torque_lever` is that
    of the torque of friction, the same where it is not given. `ends_with_overlap`: the
    contact ends where the overlap does, else where the force does.
    """

    masses: tuple[Number, ...]
    radii: tuple[Fraction, ...]
    stiffness: Fraction
    damping: Number
    tangential_stiffness: Fraction
    friction: Fraction
    closing_speed: Fraction
    angle: Fraction
    spins: tuple[Fraction, ...]
    lever: Fraction
    ends_with_overlap: bool
    torque_lever: Fraction | None = None

    @property
    def lever_of_torque(self) -> Fraction:
        """0, 1/2, 1 where the torque of friction has the lever R, R-d/2, R-d."""
        if self.torque_lever is None:
            return self.lever
        return self.torque_lever

    @property
    def total_mass(self) -> Number:
        """The total mass m1 + m2 [kg] of the pair."""
        return self.masses[0] + self.masses[1]

    @property
    @abstractmethod
    def effective_mass(self) -> Number:
        """The mass [kg] of the relative motion along the normal."""

    @property
    @abstractmethod
    def is_head_on(self) -> bool:
        """True if the motion stays along the normal for ever: it has a closed form."""

    @property
    def reach(self) -> Fraction:
        """Distance of the centres at touch [m]."""
        return sum(self.radii, Fraction(0))

    @property
    def surface_spin(self) -> list[Fraction]:
        """R1 omega1 + R2 omega2 (3,) [m/s], from which the spins' part of the slip at touch
        follows.
        """
        return [
            sum((self.radii[i] * self.spins[3 * i + axis] for i in (0, 1)), Fraction(0))
            for axis in range(3)
        ]


@dataclass(frozen=True, kw_only=True)
class SpherePair(TouchingPair):
    """Two free spheres that touch."""

    @property
    def effective_mass(self) -> Number:
        """The effective mass m1 m2/(m1 + m2) [kg]."""
        return self.masses[0] * self.masses[1] / self.total_mass

    @property
    def half_decay(self) -> Number:
        """Half of the decay rate, b = c/(2 m_eff) [1/s]."""
        return self.damping / (2 * self.effective_mass)

    @property
    def moments(self) -> list[Number]:
        """Moments of inertia of the solid spheres [kg m^2]."""
        return [Fraction(2, 5) * m * r * r for m, r in zip(self.masses, self.radii, strict=True)]

    @property
    def is_head_on(self) -> bool:
        """True if the motion stays along the normal: no angle, and no friction or no slip, neither
        at touch nor with the levers of an overlap.
        """
        # The levers shorten with the overlap d by beta d: so does the slip, by beta d (omega1 +
        # omega2) across the normal.
        return self.angle == 0 and (self.friction == 0 or not any(self.slips))

    @property
    def stays_head_on(self) -> bool:
        """True if it does beside the parameters too (dual.py)."""
        never_slips = all(map(stays_zero, self.slips))
        return stays_zero(self.angle) and (stays_zero(self.friction) or never_slips)

    @property
    def slips(self) -> list[Fraction]:
        """The parts of the slip of a head-on contact, at touch and by its overlap."""
        by_overlap = [self.lever * (self.spins[axis] + self.spins[3 + axis]) for axis in (1, 2)]
        return [*self.surface_spin[1:], *by_overlap]

    @property
    def leaves_plane(self) -> bool:
        """True if friction and spins that are not about z turn the motion out of its plane."""
        spins_across_z = any(self.spins[axis] for axis in (0, 1, 3, 4))
        return self.friction > 0 and not self.is_head_on and spins_across_z

    def dyadic_step(self) -> Fraction:
        """A step [s] of proven integration: the largest power of two that is at most half of the
        law's time 1/sqrt(k/m + (c/m)^2), and 1/32 of the time to cross `reach`.

        The first lets Picard's box close, the second keeps 1/rho (the only nonlinear term) well
        inside its convergence.
        """
        rate_squared = near(self.stiffness / self.effective_mass) + 4 * near(self.half_decay) ** 2
        # step^2 limit <= 1.
        limit = max(4 * rate_squared, (32 * self.closing_speed / self.reach) ** 2)
        step = Fraction(1)
        while step**2 * limit > 1:
            step /= 2
        while 4 * step**2 * limit <= 1:
            step *= 2
        return step

    def start(self) -> list[arb]:
        """Relative state x, y, vx, vy (of body 1 against body 2) at touch."""
        speed = arb_of(self.closing_speed)
        angle = arb_of(self.angle)
        return [arb_of(-self.reach), arb(0), speed * angle.cos(), speed * angle.sin()]


def sphere_pair(p: Mapping[str, Exact]) -> SpherePair:
    """The pair of the parameters of case two-spheres."""
    half = Fraction(1, 2)
    none = Fraction(0)
    all_of_it = Fraction(1)
    # Of the slip and of the torque.
    levers = {
        "R": (none, none),
        "R-d/2": (half, half),
        "R-d": (all_of_it, all_of_it),
        "slip-R": (none, half),
    }
    slip_lever, torque_lever = levers[str(p["branch"])]
    single = ("stiffness", "damping", "tangential_stiffness", "friction", "closing_speed", "angle")
    return SpherePair(
        masses=vector(p, "masses"),
        radii=vector(p, "radii"),
        spins=vector(p, "spins"),
        lever=slip_lever,
        torque_lever=torque_lever,
        ends_with_overlap=p["cutoff"] == "zero_overlap",
        **{name: number(p, name) for name in single},
    )
