"""The time tau of Haff's law (Haff 1983, J. Fluid Mech. 134) from the collision frequency of hard
spheres and the energy lost in a collision.
"""

from collections.abc import Mapping
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import Guarded, arb_of, refined
from refdem.truth.dual import Derivatives
from refdem.truth.exact import numbers

MASS = Fraction(1)
DIMENSIONS = 3
"""Dimensions of space, d in Haff's law."""
CHAOTIC = (
    "the motion is chaotic; Haff's law is a mean over starts, which the check `cooling` judges by"
    " its scatter"
)


class HaffTime(Guarded, Truth):
    """The truth of a granular gas: the time tau of Haff's law T = T0/(1 + t/tau)^2, a scalar.

    An elastic gas, where it is infinite, and a rough one have none.
    """

    method = "closed form"
    witness = "mean energy loss and rate of collisions as integrals over two Maxwellian velocities"

    def __init__(self, given: Mapping[str, Fraction], *, digits: int = 40) -> None:
        self.given = dict(given)
        self.digits = digits

    def at(self, t: Fraction) -> Mapping[str, Ball]:
        """Raises NotCertifiedError: the law predicts a mean over many initial states."""
        raise NotCertifiedError(CHAOTIC)

    def derivatives(self, t: Fraction, count: int) -> Derivatives:
        """Raises NotCertifiedError: no value is certified whose derivative it would be."""
        raise NotCertifiedError(CHAOTIC)

    def sensitivity(self, t: Fraction) -> float:
        """1: nothing is certified at any time."""
        return 1.0

    def refined(self, digits: int) -> "HaffTime":
        """The same with radii of at most 10^-digits."""
        return HaffTime(self.given, digits=digits)

    def scalars(self) -> Mapping[str, Ball]:
        """collision_frequency [1/s] of one sphere at the start; haff_time [s] where restitution is
        below 1 and spheres are smooth.
        """
        balls = refined(self._scalars, Fraction(1, 10**self.digits))
        if balls is None:
            raise NotCertifiedError("haff_time: no precision sufficed")
        return balls

    def _scalars(self) -> dict[str, arb]:
        """The scalars at the current precision."""
        g = self.given
        scalars = {"collision_frequency": collision_frequency(g["diameter"], g["density"], g["t0"])}
        if g["restitution"] == 1 or g.get("friction"):
            return scalars
        smooth = {name: value for name, value in g.items() if name != "friction"}
        scalars["haff_time"] = haff_time(**smooth)
        return scalars


def collision_frequency(diameter: Fraction, density: Fraction, t0: Fraction) -> arb:
    """The collision frequency w_c = 4 sqrt(pi) n sigma^2 sqrt(T/m) chi [1/s] of one sphere.

    chi = (1 - phi/2)/(1 - phi)^3 is the contact value of the pair distribution (Carnahan and
    Starling), phi = pi n sigma^3/6 the packing fraction.
    """
    # phi = pi n sigma^3/6,  chi = (1 - phi/2)/(1 - phi)^3
    packing = arb.pi() * arb_of(density * diameter**3 / 6)
    chi = (1 - packing / 2) / (1 - packing) ** 3
    # w_c = 4 sqrt(pi) n sigma^2 sqrt(T/m) chi.
    return 4 * arb.pi().sqrt() * arb_of(density * diameter**2) * arb_of(t0 / MASS).sqrt() * chi


def haff_time(*, diameter: Fraction, density: Fraction, restitution: Fraction, t0: Fraction) -> arb:
    """Haff's time tau = 2 D/((1 - e^2) w_c) [s] in D dimensions."""
    # tau = 2 D/((1 - e^2) w_c)
    frequency = collision_frequency(diameter, density, t0)
    return arb_of(2 * DIMENSIONS / (1 - restitution**2)) / frequency


def truth(p: Parameters) -> Truth:
    """The truth at parameters diameter, density, restitution, t0, friction."""
    return HaffTime(numbers(p, "diameter", "density", "restitution", "t0", "friction"))
