"""Faults of drag that grows as the square of the velocity."""

from functools import partial
from math import sqrt
from typing import Any

from refdem.faults.change import late_force, of_elements, of_force, scaled
from refdem.faults.fault import Fault
from refdem.mechanics import vectors as vec
from refdem.scene.elements.drag import Drag

drag = partial(Fault, kind="drag", sees=("error", "v"))


def _linear(fluid: Any, t: Any, d: Any, relative: Any) -> Any:
    """Drag F = -c w in place of -c |w| w: the same at a speed of 1 m/s."""
    return vec.times(-fluid.coefficient, relative)


def _three_halves(fluid: Any, t: Any, d: Any, relative: Any) -> Any:
    """Drag F = -c |w|^(1/2) w in place of -c |w| w: the same at a speed of 1 m/s."""
    speed = vec.size(relative)
    return vec.times(-fluid.coefficient * sqrt(speed), relative)


FAULTS = (
    drag(
        name="drag-without-half",
        sentence="The factor 1/2 of rho C_d A / 2 is applied twice.",
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
        sentence="The drag is proportional to the velocity instead of its square.",
        on=("falling", "thrown"),
        inside=of_force(Drag, lambda _: _linear),
    ),
    drag(
        name="drag-three-halves",
        sentence="The drag grows as the power 3/2 of the velocity.",
        on=("falling", "thrown"),
        inside=of_force(Drag, lambda _: _three_halves),
    ),
    drag(
        name="drag-late",
        sentence="The drag uses the velocity of the previous evaluation.",
        on=("falling",),
        method="rk4",
        sees=("order", "state"),
        inside=late_force(Drag),
    ),
    drag(
        name="drag-energy",
        sentence="The drag dissipates 10 % more energy than that of the scene.",
        on=("falling",),
        sees=("energy", "finest"),
        before=of_elements(Drag, coefficient=scaled(1.1)),
    ),
)
