"""Constraints: rods in position, in velocity, and their force."""

from functools import partial
from typing import Any

from refdem.faults import vectors as vec
from refdem.faults.change import late, of_arguments, of_elements, of_parts, of_results, scaled
from refdem.faults.fault import Fault
from refdem.scene.elements.rod import Rod

constraint = partial(Fault, kind="constraint", on=("swing",))
FORCE = ("error", "rod_force")


def _loose(tolerance: float) -> Any:
    """A multiplier that is content once the rod is right to a tolerance."""

    def wrapped(sound: Any) -> Any:
        def part(rod: Any, apart: Any, direction: Any, ease: Any) -> Any:
            gap = abs(vec.dot(apart, apart) / rod.length**2 - 1)
            if gap > tolerance:
                return sound(rod, apart, direction, ease)
            return 0.0

        return part

    return wrapped


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
        sentence="The multiplier is solved to 1e-6 only.",
        sees=("constraint", "length"),
        inside=lambda p: {"rod_position": _loose(1e-6)(p.rod_position)},
    ),
    constraint(
        name="multiplier-tight-but-loose",
        sentence="The multiplier is solved to 1e-10 only.",
        sees=("constraint", "length"),
        inside=lambda p: {"rod_position": _loose(1e-10)(p.rod_position)},
    ),
    constraint(
        name="velocity-not-held",
        sentence="Positions are put back on the rod, velocities are not.",
        sees=("constraint", "velocity"),
        inside=of_parts(rod_velocity=lambda *a: 0.0),
    ),
    constraint(
        name="velocity-half-held",
        sentence="Only half of the velocity along the rod is taken away.",
        sees=("constraint", "velocity"),
        inside=of_results(rod_velocity=scaled(0.5)),
    ),
    constraint(
        name="rod-not-held",
        sentence="The rod holds velocities only, so that it grows longer.",
        sees=("constraint", "length"),
        inside=of_parts(rod_position=lambda *a: 0.0),
    ),
    constraint(
        name="rod-force-sign",
        sentence="Tension is written as negative.",
        sees=FORCE,
        inside=of_results(rod_tension=lambda found: -found),
    ),
    constraint(
        name="rod-force-without-speed",
        sentence="The rod's force leaves the centripetal part out.",
        on=("circler",),
        sees=FORCE,
        inside=of_arguments(
            rod_tension=lambda rod, apart, relative, pull, ease: (rod, apart, vec.ZERO, pull, ease)
        ),
    ),
    constraint(
        name="rod-force-without-weight",
        sentence="The rod's force leaves the weight out.",
        on=("circler",),
        sees=FORCE,
        inside=of_arguments(
            rod_tension=lambda rod, apart, relative, pull, ease: (
                rod,
                apart,
                relative,
                vec.ZERO,
                ease,
            )
        ),
    ),
    constraint(
        name="rod-force-late",
        sentence="The rod's force is that of the sample before.",
        sees=FORCE,
        inside=late("rod_tension"),
    ),
    constraint(
        name="rod-force-per-mass",
        sentence="The rod's force is an acceleration.",
        sees=FORCE,
        inside=lambda p: {
            "rod_tension": (
                lambda rod, apart, relative, pull, ease: (
                    ease * p.rod_tension(rod, apart, relative, pull, ease) / 1.5
                )
            )
        },
    ),
    constraint(
        name="rod-pulls-world",
        sentence="The rod hangs from a point that is off by a thousandth.",
        sees=("constraint", "length"),
        before=of_elements(Rod, anchor_b=lambda a: (a[0] + 1e-3, *a[1:])),
    ),
)
