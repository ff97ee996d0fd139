"""The values of a member of the impact benchmarks, by the names of the quantities."""

from types import SimpleNamespace
from typing import Any, Literal


class Values(SimpleNamespace):
    """The numbers of a member in SI units, and what follows from them.

    Each is an exact rational, or a Real, which truth encloses at its own precision and a scene
    rounds once; `branch`, `cutoff` and `half` are not. A member has those of them that its
    parameters name and that its `values` adds.
    """

    # The first body, and the second of members that have two.
    mass: Any  # kg
    radius: Any  # m
    density: Any  # kg/m^3
    modulus: Any  # Young's, Pa
    poisson: Any  # 1
    partner_radius: Any  # m
    partner_density: Any  # kg/m^3
    large: Any  # mass of the sphere that squeezes two smaller ones, kg
    upper: Any  # mass of the upper sphere of a stack, kg
    masses: tuple[Any, Any]  # of a pair, kg
    radii: tuple[Any, Any]  # of a pair, m
    spins: tuple[Any, Any]  # of a pair, about z, rad/s

    # The contact: F = stiffness d + damping d', or F = hertz d^(3/2).
    effective: Any  # effective mass of the contact, kg
    stiffness: Any  # N/m
    damping: Any  # kg/s
    restitution: Any  # 1
    hertz: Any  # N/m^(3/2)
    mindlin: Any  # tangential stiffness of Mindlin's law, N/m^(3/2)
    stiffness_ratio: Any  # tangential over normal modulus, 1
    tangential_stiffness: Any  # N/m
    friction: Any  # coefficient, 1
    branch: Literal["R", "R-d", "R-d/2"]  # lever arm of the tangential force
    cutoff: Literal["zero_overlap", "zero_force"]  # where the contact ends

    # The start.
    gravity: Any  # m/s^2
    height: Any  # m
    speed: Any  # m/s
    angle: Any  # of the velocity from the normal
    normal: Any  # closing speed along the normal, m/s
    across: Any  # speed along the wall, m/s
    normal_speed: Any  # m/s
    psi: Any  # across/(friction normal), 1
    spin: Any  # about z, rad/s
    partner_spin: Any  # about z, rad/s

    # A straight path past a fixed sphere.
    begin: Any  # distance along the path from the start to the closest approach, m
    off: Any  # distance of the path from the fixed centre, m
    overlap: Any  # at closest approach, m
    half_squared: Any  # square of half the length of the path in touch, m^2
    half: float  # half the length of the path in touch, m

    def complete(self, **defaults: Any) -> None:
        """Adds the values of these names that the member does not have yet."""
        for name, value in defaults.items():
            if not hasattr(self, name):
                setattr(self, name, value)
