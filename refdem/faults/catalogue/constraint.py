"""Constraints: rods in position, in velocity, and their force."""

from functools import partial
from typing import Any

from refdem.faults.change import (
    Inside,
    late,
    of_arguments,
    of_elements,
    of_parts,
    of_results,
    scaled,
)
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.mechanics import vectors as vec
from refdem.scene.elements.rod import Rod

constraint = partial(Fault, kind="constraint", on=("swing",))
FORCE = ("error", "rod_force")


def _loose(tolerance: float) -> Inside:
    """A rod's multiplier that is 0 once the squared length is right to a relative tolerance."""

    def inside(sound: Parts) -> dict[str, Any]:
        def rod_position(rod: Any, branch: Any, along: Any, inverse_mass: Any) -> Any:
            # (|r_a - r_b|/l)^2 - 1 is twice the relative error of the length.
            error = abs(vec.dot(branch, branch) / rod.length**2 - 1)
            if error > tolerance:
                return sound.rod_position(rod, branch, along, inverse_mass)
            return 0.0

        return {"rod_position": rod_position}

    return inside


def _tension_per_mass(sound: Parts) -> dict[str, Any]:
    """The rod's force times its inverse mass over 1.5: an acceleration in place of a force."""

    def rod_tension(rod: Any, branch: Any, relative: Any, pull: Any, inverse_mass: Any) -> Any:
        tension = sound.rod_tension(rod, branch, relative, pull, inverse_mass)
        return inverse_mass * tension / 1.5

    return {"rod_tension": rod_tension}


def _without_speed(rod: Any, branch: Any, relative: Any, pull: Any, inverse_mass: Any) -> Any:
    """The arguments of a rod's force with no relative velocity of its ends."""
    return rod, branch, vec.ZERO, pull, inverse_mass


def _without_weight(rod: Any, branch: Any, relative: Any, pull: Any, inverse_mass: Any) -> Any:
    """The arguments of a rod's force with no acceleration by other forces."""
    return rod, branch, relative, vec.ZERO, inverse_mass


FAULTS = (
    constraint(
        name="rod-too-long",
        sentence="The rod is 0.1 % too long.",
        sees=("constraint", "length"),
        before=of_elements(Rod, length=scaled(1.001)),
    ),
    constraint(
        name="rod-too-long-by-a-hair",
        sentence="The rod is too long by one part in 1e10.",
        sees=("constraint", "length"),
        before=of_elements(Rod, length=scaled(1 + 1e-10)),
    ),
    constraint(
        name="multiplier-loose",
        sentence="The Lagrange multiplier is solved with a tolerance of 1e-6.",
        sees=("constraint", "length"),
        inside=_loose(1e-6),
    ),
    constraint(
        name="multiplier-tight-but-loose",
        sentence="The Lagrange multiplier is solved with a tolerance of 1e-10.",
        sees=("constraint", "length"),
        inside=_loose(1e-10),
    ),
    constraint(
        name="velocity-not-held",
        sentence="Positions are projected onto the constraint, velocities are not.",
        sees=("constraint", "velocity"),
        inside=of_parts(rod_velocity=lambda *a: 0.0),
    ),
    constraint(
        name="velocity-half-held",
        sentence="Only half of the velocity along the rod is removed.",
        sees=("constraint", "velocity"),
        inside=of_results(rod_velocity=scaled(0.5)),
    ),
    constraint(
        name="rod-not-held",
        sentence=(
            "The constraint is imposed on velocities only, so that the length of the rod drifts."
        ),
        sees=("constraint", "length"),
        inside=of_parts(rod_position=lambda *a: 0.0),
    ),
    constraint(
        name="rod-force-sign",
        sentence="Tension is written with a negative sign.",
        sees=FORCE,
        inside=of_results(rod_tension=lambda found: -found),
    ),
    constraint(
        name="rod-force-without-speed",
        sentence="The force of the rod lacks the centripetal part.",
        on=("circler",),
        sees=FORCE,
        inside=of_arguments(rod_tension=_without_speed),
    ),
    constraint(
        name="rod-force-without-weight",
        sentence="The force of the rod lacks the part that balances the weight.",
        on=("circler",),
        sees=FORCE,
        inside=of_arguments(rod_tension=_without_weight),
    ),
    constraint(
        name="rod-force-late",
        sentence="The force of the rod is that of the previous sample.",
        sees=FORCE,
        inside=late("rod_tension"),
    ),
    constraint(
        name="rod-force-per-mass",
        sentence="The force of the rod is written as an acceleration.",
        sees=FORCE,
        inside=_tension_per_mass,
    ),
    constraint(
        name="rod-pulls-world",
        sentence="The pivot of the rod is displaced by one part in a thousand.",
        sees=("constraint", "length"),
        before=of_elements(Rod, anchor_b=lambda a: (a[0] + 1e-3, *a[1:])),
    ),
)
