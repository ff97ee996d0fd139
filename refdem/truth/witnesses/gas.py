"""Witness of Haff's time: collisions counted and energy lost as integrals over the speeds at which
two Maxwellian spheres meet.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from flint import acb, arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import numbers
from refdem.truth.witnesses.testimony import Claimed, Said, Witness

METHOD = (
    "quadrature over the relative velocities of two Maxwellian spheres"
    " (refdem/truth/witnesses/gas.py)"
)
FAR = 20
"""Widths of the distribution beyond which exp(-FAR^2/2) < 10^-86 is left out."""


def moment(power: int) -> arb:
    """Integral of u^power exp(-u^2/2) over u > 0."""
    found: arb = acb.integral(lambda u, _: u**power * (-u * u / 2).exp(), 0, FAR).real
    return found


def cooling(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """One component of the relative velocity has the variance 2 T/m (m = 1); along the line of
    centres those that meet are weighed by it.

    Meetings with one sphere: n sigma^2 chi times half the sphere, 2 pi, times the mean of the
    positive part of that component, twice over for both senses of the line; each loses (1 - e^2)/4
    of m u^2, shared by two spheres of energy 3 T/2.
    """
    e = {
        name: arb_of(x)
        for name, x in numbers(p, "diameter", "density", "restitution", "t0").items()
    }
    packing = arb.pi() * e["density"] * e["diameter"] ** 3 / 6
    near = (1 - packing / 2) / ((1 - packing) * (1 - packing) * (1 - packing))
    width = (2 * e["t0"]).sqrt()
    norm = 2 * moment(0)
    towards = width * moment(1) / norm
    rate = e["density"] * e["diameter"] * e["diameter"] * near * 4 * arb.pi() * towards
    lost = (1 - e["restitution"] * e["restitution"]) / 4 * width * width * moment(3) / moment(1)
    found = {"collision_frequency": rate}
    if lost > 0:
        found["haff_time"] = 2 * (arb(3) / 2 * e["t0"]) / (rate * lost / 2)
    yield None, found


WITNESSES = {"granular-gas": Witness(METHOD, cooling)}
