"""Witness of Haff's time: collision frequency and energy loss as integrals over the relative speed
of two spheres with Maxwellian velocities.
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
"""Upper end of the integrals in standard deviations; exp(-FAR^2/2) < 10^-86 is neglected."""


def moment(power: int) -> arb:
    """The integral of u^power exp(-u^2/2) over u > 0."""
    integral: arb = acb.integral(lambda u, _: u**power * (-u * u / 2).exp(), 0, FAR).real
    return integral


def cooling(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The collision frequency of a sphere and Haff's time.

    A component u of the relative velocity along a given line is Gaussian with the variance 2 T/m (m
    = 1). With the contact value chi of the pair distribution (Carnahan and Starling) and the mean
    <u+> of the positive part of u:

        w_c = 4 pi n sigma^2 chi <u+>              collisions of one sphere per time
        loss = (1 - e^2)/4 m <u^3>/<u>             mean energy lost in a collision, over u > 0
        -dE/dt = w_c loss/2,  E = 3 T/2            each loss is shared by two spheres
        tau = 2 E/(-dE/dt)                         from E = E0/(1 + t/tau)^2
    """
    e = {
        name: arb_of(x)
        for name, x in numbers(p, "diameter", "density", "restitution", "t0").items()
    }
    # chi = (1 - phi/2)/(1 - phi)^3, with the packing fraction phi = pi n sigma^3/6.
    packing = arb.pi() * e["density"] * e["diameter"] ** 3 / 6
    chi = (1 - packing / 2) / ((1 - packing) * (1 - packing) * (1 - packing))
    # The standard deviation sqrt(2 T/m) of u, and the integral of exp(-u^2/2) over all u, with u in
    # units of the deviation.
    deviation = (2 * e["t0"]).sqrt()
    norm = 2 * moment(0)
    # <u+> = deviation (integral of u exp(-u^2/2) over u > 0)/norm.
    mean_approach = deviation * moment(1) / norm
    # w_c = 4 pi n sigma^2 chi <u+>
    rate = e["density"] * e["diameter"] * e["diameter"] * chi * 4 * arb.pi() * mean_approach
    inelasticity = 1 - e["restitution"] * e["restitution"]
    # (1 - e^2)/4 <u^3>/<u>, each mean over u > 0.
    loss = inelasticity / 4 * deviation * deviation * moment(3) / moment(1)
    scalars = {"collision_frequency": rate}
    if loss > 0:
        # tau = 2 E/(w_c loss/2), E = 3 T/2
        scalars["haff_time"] = 2 * (arb(3) / 2 * e["t0"]) / (rate * loss / 2)
    yield None, scalars


WITNESSES = {"granular-gas": Witness(METHOD, cooling)}
