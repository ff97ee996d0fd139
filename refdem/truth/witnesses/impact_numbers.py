"""Derived parameters of the impact benchmarks for their witness: masses, damping and stiffnesses,
without the code of refdem/truth/contact_law.py.
"""

from collections.abc import Mapping
from typing import Any

from flint import arb

from refdem.truth.balls import arb_of, precision
from refdem.truth.witnesses.cross_check import BITS

MORE_BITS = 4 * BITS
"""Bits of the bisection in `damping`. Near e = exp(-2) its equation has nearly a double root, which
costs half of the bits.
"""
MISSING = {
    "spin": 0,
    "friction": 0,
    "angle": 0,
    "psi": 0,
    "restitution": 1,
    "branch": "R",
    "cutoff": "zero_overlap",
}
"""The values of parameters that some members do not have."""


def impact_numbers(written: Mapping[str, Any]) -> dict[str, Any]:
    """The given parameters of a member, and those derived from them as Arb balls.

    Derived are the masses, the damping, the stiffnesses of Hertz and Mindlin, and the components of
    the approach velocity: `normal` = v cos(angle) and `across` = v sin(angle), or `across` = psi mu
    v_n where the normal speed v_n and psi are given.
    """
    p: dict[str, Any] = {**MISSING, **written}
    if "density" in p:
        p["mass"] = ball_mass(p["density"], p["radius"])
    if p["member"] == "three-spheres":
        p["large"] = ball_mass(p["density"], p["partner_radius"])
    if p["member"] == "dem-03":
        p["upper"] = ball_mass(p["partner_density"], p["radius"])
    if "partner_density" in p and "partner_radius" in p:
        p["masses"] = (p["mass"], ball_mass(p["partner_density"], p["partner_radius"]))
        p["radii"] = (p["radius"], p["partner_radius"])
        p["spins"] = (p["spin"], p["partner_spin"])
    if "stiffness" in p and "mass" in p:
        p["damping"] = damping(p, effective_mass(p))
    if "modulus" in p:
        p |= stiffnesses(p)
    if "normal_speed" in p:
        p["normal"] = arb_of(p["normal_speed"])
        p["across"] = arb_of(p["psi"] * p["friction"] * p["normal_speed"])
    elif "speed" in p:
        angle = arb_of(p["angle"])
        p["normal"] = arb_of(p["speed"]) * angle.cos()
        p["across"] = arb_of(p["speed"]) * angle.sin()
    return p


def ball_mass(density: Any, radius: Any) -> arb:
    """The mass [kg] of a sphere: density times pi D^3/6."""
    diameter = 2 * arb_of(radius)
    return arb_of(density) * arb.pi() * diameter * diameter * diameter / 6


def effective_mass(p: Mapping[str, Any]) -> arb:
    """The mass [kg] with which the given restitution determines the damping."""
    # Large spheres around a small one: the damping is that of one large sphere alone.
    if "large" in p:
        return arb_of(p["large"])
    mass = arb_of(p["mass"])
    # Two spheres: m1 m2/(m1 + m2) = 1/(1/m1 + 1/m2).
    if "upper" in p:
        return 1 / (1 / mass + 1 / arb_of(p["upper"]))
    if "masses" in p:
        return 1 / (1 / mass + 1 / arb_of(p["masses"][1]))
    # A sphere and a wall.
    return mass


def damping(p: Mapping[str, Any], mass: arb) -> arb:
    """The damping c [kg/s] for the given restitution e, by bisection in q = w/b.

    m d'' + c d' + k d = 0 has the decay rate b = c/(2 m) and the frequency w with w^2 + b^2 = k/m:
    c = 2 sqrt(m k/(1 + q^2)). A contact of duration t_c has e = exp(-b t_c), where b t_c = pi/q if
    it ends with d = 0 and 2 atan(q)/q if it ends with F = 0.
    """
    if p["restitution"] == 1:
        return arb(0)
    if p["cutoff"] == "zero_overlap":
        loss = half_swing
    else:
        loss = pressing_swing
    with precision(MORE_BITS):
        # ln(1/e) = b t_c, whose right-hand side decreases with q.
        target = -arb_of(p["restitution"]).log()
        low = arb(0)
        high = arb(1)
        while loss(high) > target:
            high = 2 * high
        for _ in range(MORE_BITS):
            middle = ((low + high) / 2).mid()
            if loss(middle) > target:
                low = middle
            else:
                high = middle
        q = (low + high) / 2
        dashpot: arb = 2 * (mass * arb_of(p["stiffness"]) / (1 + q * q)).sqrt()
    return dashpot


def half_swing(q: arb) -> arb:
    """b t_c = pi/q for a contact that ends with d = 0: w t_c = pi."""
    return arb.pi() / q


def pressing_swing(q: arb) -> arb:
    """b t_c = 2 atan(q)/q for a contact that ends with F = 0: w t_c = 2 atan(w/b)."""
    return 2 * q.atan() / q


def stiffnesses(p: Mapping[str, Any]) -> dict[str, arb]:
    """Hertz's stiffness of the contact, and Mindlin's of a sphere on a wall [N/m^(3/2)].

    With E' = E/(1 - nu^2) and G = E/(2 (1 + nu)): F = 4/3 E' sqrt(R) d^(3/2), and the tangential
    stiffness is k_t sqrt(d) with k_t = 8 G/(2 - nu) sqrt(R).
    """
    modulus = arb_of(p["modulus"])
    poisson = arb_of(p["poisson"])
    radius = arb_of(p["radius"])
    plane_modulus = modulus / (1 - poisson * poisson)
    shear_modulus = modulus / (2 * (1 + poisson))
    if p["member"] == "co-1":
        # Two equal spheres: F = 4/3 (E'/2) sqrt(R/2) d^(3/2) = E' sqrt(2 R)/3 d^(3/2).
        return {"hertz": plane_modulus * (2 * radius).sqrt() / 3}
    return {
        "hertz": 4 * plane_modulus * radius.sqrt() / 3,
        "mindlin": 8 * shear_modulus / (2 - poisson) * radius.sqrt(),
    }
