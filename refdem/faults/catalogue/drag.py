"""Faults of drag that grows as the square of the velocity."""

from functools import partial
from math import sqrt
from typing import Any

from refdem.faults import vectors as vec
from refdem.faults.change import late, of_elements, scaled
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.scene.elements.drag import Drag

drag = partial(Fault, kind="drag", sees=("error", "v"))


def _linear(sound: Parts) -> dict[str, Any]:
    """Drag in proportion to the velocity, right at 1 m/s."""

    def part(fluid: Any, relative: Any) -> Any:
        return vec.times(-fluid.coefficient, relative)

    return {"drag_force": part}


def _three_halves(sound: Parts) -> dict[str, Any]:
    """Drag as the power 3/2 of the velocity, right at 1 m/s."""

    def part(fluid: Any, relative: Any) -> Any:
        speed = vec.size(relative)
        return vec.times(-fluid.coefficient * sqrt(speed), relative)

    return {"drag_force": part}


FAULTS = (
    drag(
        name="drag-without-half",
        sentence="The factor 1/2 of rho C_d A / 2 is taken twice.",
        on=("falling", "thrown"),
        before=of_elements(Drag, coefficient=scaled(0.5)),
    ),
    drag(
        name="drag-one-percent",
        sentence="The drag is 1 % too strong.",
        on=("falling",),
        levels=5,
        before=of_elements(Drag, coefficient=scaled(1.01)),
    ),
    drag(
        name="drag-linear",
        sentence="The drag is proportional to the velocity and not to its square.",
        on=("falling", "thrown"),
        inside=_linear,
    ),
    drag(
        name="drag-three-halves",
        sentence="The drag grows as the power 3/2 of the velocity.",
        on=("falling", "thrown"),
        inside=_three_halves,
    ),
    drag(
        name="drag-late",
        sentence="The drag acts with the velocity of the evaluation before.",
        on=("falling",),
        method="rk4",
        sees=("order", "state"),
        inside=late("drag_force"),
    ),
    drag(
        name="drag-energy",
        sentence="The drag takes 10 % more energy than the fluid of the scene.",
        on=("falling",),
        sees=("energy", "finest"),
        before=of_elements(Drag, coefficient=scaled(1.1)),
    ),
)
