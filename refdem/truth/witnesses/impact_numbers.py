"""What the members of the impact benchmarks leave to be derived, derived for their witness: no code
of refdem/truth/contact_law.py.
"""

from collections.abc import Mapping
from typing import Any

from flint import arb

from refdem.truth.balls import arb_of, precision
from refdem.truth.witnesses.cross_check import BITS

MORE_BITS = 4 * BITS
"""Near exp(-2) the equation of a restitution has nearly a double root, which costs half of the
bits.
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
"""Parameters that some members do not have."""


def impact_numbers(written: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers of a member as they are written, and what follows from them, as balls."""
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
    """Density times pi D^3/6 [kg]."""
    diameter = 2 * arb_of(radius)
    return arb_of(density) * arb.pi() * diameter * diameter * diameter / 6


def effective_mass(p: Mapping[str, Any]) -> arb:
    """The effective mass [kg] of the contact whose restitution is given."""
    # The large spheres that close on a small one: their dashpot is made for a large one alone.
    if "large" in p:
        return arb_of(p["large"])
    mass = arb_of(p["mass"])
    # Two spheres, one upon the other or side by side: m1 m2/(m1 + m2).
    if "upper" in p:
        return 1 / (1 / mass + 1 / arb_of(p["upper"]))
    if "masses" in p:
        return 1 / (1 / mass + 1 / arb_of(p["masses"][1]))
    # A sphere and a wall.
    return mass


def damping(p: Mapping[str, Any], mass: arb) -> arb:
    """c [kg/s] by bisection in q = w/b, the ratio of swing to decay: c = 2 sqrt(m k/(1 + q^2)).

    Over a contact the velocity falls by ln(1/e) = b t_c, which is pi/q until the overlap ends and 2
    atan(q)/q until the force does.
    """
    if p["restitution"] == 1:
        return arb(0)
    if p["cutoff"] == "zero_overlap":
        loss = half_swing
    else:
        loss = pressing_swing
    with precision(MORE_BITS):
        # The loss falls as q rises.
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
    """b t_c = pi/q, with t_c until the overlap ends."""
    return arb.pi() / q


def pressing_swing(q: arb) -> arb:
    """b t_c = 2 atan(q)/q, with t_c until the force ends."""
    return 2 * q.atan() / q


def stiffnesses(p: Mapping[str, Any]) -> dict[str, arb]:
    """Hertz's stiffness of the contact, and Mindlin's of a sphere on a wall [N/m^(3/2)].

    With E' = E/(1 - nu^2) and G = E/(2 (1 + nu)): F = 4/3 E' sqrt(R) d^(3/2), and k_t = 8 G/(2 -
    nu) sqrt(R).
    """
    modulus = arb_of(p["modulus"])
    poisson = arb_of(p["poisson"])
    radius = arb_of(p["radius"])
    plane_modulus = modulus / (1 - poisson * poisson)
    shear_modulus = modulus / (2 * (1 + poisson))
    if p["member"] == "co-1":
        # Two equal spheres: F = 4/3 (E'/2) sqrt(R/2) d^(3/2).
        return {"hertz": plane_modulus * (2 * radius).sqrt() / 3}
    return {
        "hertz": 4 * plane_modulus * radius.sqrt() / 3,
        "mindlin": 8 * shear_modulus / (2 - poisson) * radius.sqrt(),
    }
