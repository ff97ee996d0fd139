"""Witness of Haff's time: collisions counted and energy lost as integrals over the speeds at which
two Maxwellian spheres meet.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from flint import acb, arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import numbers
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness

METHOD = (
    "quadrature over the relative velocities of two Maxwellian spheres"
    " (refdem/truth/witnesses/gas.py)"
)
FAR = 20
"""Widths of the distribution beyond which exp(-FAR^2/2) < 10^-86 is left out."""


def moment(power: int) -> arb:
    """The integral of u^power exp(-u^2/2) over u > 0."""
    integral: arb = acb.integral(lambda u, _: u**power * (-u * u / 2).exp(), 0, FAR).real
    return integral


def cooling(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The collision frequency of a sphere and Haff's time, from how two spheres meet.

    A component u of the relative velocity along a given line is Gaussian with the variance 2 T/m (m
    = 1). Per time, a sphere meets n sigma^2 chi times the integral over all directions, 4 pi, of
    the mean of the positive part of u, chi being the contact value of the pair distribution.
    Spheres that meet have u weighed by u, so that a collision loses (1 - e^2)/4 of the mean of m
    u^2 under that weight, shared by two spheres of energy 3 T/2. Haff: tau = 2 E/(dE/dt).
    """
    e = {
        name: arb_of(x)
        for name, x in numbers(p, "diameter", "density", "restitution", "t0").items()
    }
    packing = arb.pi() * e["density"] * e["diameter"] ** 3 / 6
    chi = (1 - packing / 2) / ((1 - packing) * (1 - packing) * (1 - packing))
    # The standard deviation of u, and the integral of its unnormalised distribution.
    deviation = (2 * e["t0"]).sqrt()
    norm = 2 * moment(0)
    mean_approach = deviation * moment(1) / norm
    rate = e["density"] * e["diameter"] * e["diameter"] * chi * 4 * arb.pi() * mean_approach
    inelasticity = 1 - e["restitution"] * e["restitution"]
    loss = inelasticity / 4 * deviation * deviation * moment(3) / moment(1)
    scalars = {"collision_frequency": rate}
    if loss > 0:
        scalars["haff_time"] = 2 * (arb(3) / 2 * e["t0"]) / (rate * loss / 2)
    yield None, scalars


WITNESSES = {"granular-gas": Witness(METHOD, cooling)}
