"""Two equal spheres that squeeze a smaller one between them, under the linear law, turned into
themselves by half a turn about z.

The middle one stays where it is and only turns, so that each of the others meets a sphere that
cannot be moved and has, for its torque alone, half of the middle one's moment of inertia: J w' = 2
torque. What follows is a pair (contact_phases) whose effective mass is that of the outer sphere.
The outer two never touch each other as long as the middle one is not crushed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_mat

from refdem.core.truth import Ball
from refdem.truth.closed_forms.two_spheres import TwoSpheres
from refdem.truth.contact_motion import ContactMotion
from refdem.truth.events.truth import HybridFlow
from refdem.truth.reals import Number
from refdem.truth.sphere_pair import SpherePair
from refdem.truth.validated_ivp.moved import identity

NAMES = tuple(
    f"{kind}{body}.{axis}" for body in (1, 2, 3) for kind in ("r", "v", "omega") for axis in "xyz"
)
"""Body 1 is the outer one at negative x, body 2 the middle one, body 3 the other."""
MOVED = ("r1.x", "r1.y", "v1.x", "v1.y", "omega1.z", "omega2.z")


@dataclass(frozen=True, kw_only=True)
class Squeezed(SpherePair):
    """An outer sphere of `masses[0]` against the middle one; masses[1] is half of the middle one's,
    which its torque feels.
    """

    @property
    def effective_mass(self) -> Number:
        """The effective mass [kg]: that of the outer sphere."""
        return self.masses[0]

    @property
    def is_head_on(self) -> bool:
        """Never taken for it: nothing is lost by integrating."""
        return False


class ThreeSpheres(TwoSpheres):
    """Positions [m], velocities [m/s] and angular velocities [rad/s] of the three, NAMES, at t >=
    0, from touch.
    """

    def __init__(self, scale: Mapping[str, float], pair: Squeezed, *, digits: int = 40) -> None:
        super().__init__(scale, pair, digits=digits)
        self.method = HybridFlow.method
        self.witness = "Taylor series of the three bodies, each with its own equation; momenta"

    def at(self, t: Fraction) -> dict[str, Ball]:
        def found(motion: ContactMotion) -> dict[str, arb]:
            return self.quantities(self.in_si(motion.place(self.clock(t))))

        return self.climbed(found, f"at t = {float(t):.17g} s")

    def quantities(self, relative: Sequence[arb]) -> dict[str, arb]:
        """The 27 quantities from x, y, vx, vy of body 1 and the spins about z of it and the middle
        one.
        """
        x, y, vx, vy, outer, middle = relative[:6]
        o = arb(0)
        values = (
            x,
            y,
            o,
            vx,
            vy,
            o,
            o,
            o,
            outer,
            *(o,) * 8,
            middle,
            -x,
            -y,
            o,
            -vx,
            -vy,
            o,
            o,
            o,
            outer,
        )
        return dict(zip(NAMES, values, strict=True))

    def scalars(self) -> dict[str, Ball]:
        return self.climbed(self.extremes, "scalars")

    def drifting(self) -> Sequence[int]:
        """None: the middle sphere stays, and mirror images stay mirror images."""
        return ()

    def bodies(self) -> arb_mat:
        """The coordinates of an outer sphere and the two spins are those of the mode."""
        return identity(self.phases.size - 1)

    def counted(self) -> Sequence[str]:
        return MOVED
