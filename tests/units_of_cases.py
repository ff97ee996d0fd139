"""The units of everything that a case is given and that its truth says, by name, and those of the
numbers that it has without a parameter.
"""

from refdem.cases.impact_benchmarks import member
from refdem.core import discovery
from refdem.core.case import Instance

HIDDEN = {
    "stick-slip": ("kg", "N/m"),
    "poincare-sections": ("kg", "N/m"),
    "two-body-orbit": ("kg",),
    "granular-gas": ("kg",),
    "phase-flow": ("s",),
    "block-on-slope": ("m",),
    "newtons-first-law": ("m",),
    "quaternions": ("s",),
    "rotations": ("s",),
}
"""Units of what a case has without a parameter for it, such as a mass of 1 kg: other units would
change that number. A head in the phase plane is as wide in m as in m/s; identities mix angular
velocities with numbers.
"""
OF_A_MATERIAL = ("kg/m^3", "N/m^2")
"""What a member of the impact benchmarks takes from the table of materials."""
WITHOUT_UNITS = {
    "logistic": "its numbers have no unit",
    "lorenz": "its numbers have no unit",
    "van-der-pol": "its equation compares the place with 1 m, and its spring has 1/s^2",
}
"""Cases that have nothing to be changed."""
OF_FIXED_SIZE = ("triangle.", "angle-plate.", "points.")
"""Solids of moments-of-inertia with a number that is no parameter: plates are 1 m thick, points
have masses of 1 to 4 kg.
"""
OTHERWISE = {
    ("stick-slip", "friction_law", "linear"): {"lambda1": "s/m"},
    ("poincare-sections", "friction_law", "linear"): {"lambda1": "s/m"},
    ("phase-flow", "flow", "pendulum"): {"centre": "rad, rad/s", "size": "rad"},
}
"""Units of parameters that a chosen word changes."""
SCALARS = {
    "J": ("work", "energy_change", "energy_lost", "friction_work"),
    "N": ("max_force",),
    "kg m/s": ("normal_impulse", "tangential_impulse"),
    "kg m^2": ("inertia",),
    "m": ("max_overlap", "stop_position", "steady_amplitude", "top", "apex_1", "apex_2"),
    "m/s": ("roll_speed", "terminal_velocity", "rebound_across"),
    "rad": ("nutation_min", "nutation_max"),
    "1/s": ("omega", "rebound_spin", "collision_frequency", "border", "growth_rate"),
    "s": (
        *("period", "duration", "impact_time", "last_impact_time", "first_bounce", "roll_time"),
        *("accumulation_time", "stop_time", "flip_time", "haff_time", "top_time"),
    ),
    "1": (
        *("impacts", "bounces", "half_cycles", "final_axis", "elliptic_m", "restitution"),
        *("floquet_1", "floquet_2", "impulse_ratio", "speed_ratio", "time_ratio"),
    ),
}
UNIT_OF = {name: unit for unit, names in SCALARS.items() for name in names}
AREA = {"m": "m^2/s", "rad": "1/s"}
"""Of the phase plane, by the unit of its places."""
ENDS = {"_closing": "m/s", "_body": "1", "_other": "1"}
"""Of numbered events, such as impact_2_closing; without such an end it is their time."""


def hidden(case: str, given: dict[str, str]) -> tuple[str, ...]:
    """Units of the numbers that a setting has without a parameter for them."""
    if case == "impact-benchmarks" and "material" in member(given["member"]).numbers:
        return OF_A_MATERIAL
    return HIDDEN.get(case, ())


def units_of(case: str, given: dict[str, str]) -> dict[str, str]:
    """The unit of every parameter of a case, by name."""
    units = {p.name: p.unit for p in discovery.case(case).parameters}
    for (of_case, name, word), others in OTHERWISE.items():
        if case == of_case and given.get(name) == word:
            units |= others
    return units


def unit_of(instance: Instance, name: str) -> str:
    """The unit of a quantity or a scalar."""
    if name in instance.quantities:
        return instance.quantities[name].unit
    first, _, rest = name.partition("_")
    if first == "area":
        return AREA[instance.quantities["x_0"].unit]
    if first in ("impact", "stick", "slip"):
        return ENDS.get(rest.lstrip("0123456789"), "s")
    return UNIT_OF[name]
