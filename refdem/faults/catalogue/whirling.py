"""Faults of a dashpot whose fluid turns."""

from functools import partial
from typing import Any

import msgspec

from refdem.core.problem import Request
from refdem.faults.change import late_force, of_bodies, of_elements, scaled
from refdem.faults.fault import Fault
from refdem.scene import Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.rotating_dashpot import RotatingDashpot

SHAFTS = ("shaft", "slow-shaft")
whirling = partial(Fault, kind="whirling", on=SHAFTS, sees=("error", "x"))


def _exchanged(request: Request) -> Request:
    """The damping of the dashpot at rest and that of the rotating one are exchanged."""
    scene = request.problem.scene
    outer = scene.all(Dashpot)[0].damping
    inner = scene.all(RotatingDashpot)[0].damping

    def changed(element: Any) -> Any:
        if isinstance(element, Dashpot):
            return msgspec.structs.replace(element, damping=inner)
        if isinstance(element, RotatingDashpot):
            return msgspec.structs.replace(element, damping=outer)
        return element

    elements = tuple(changed(element) for element in scene.elements)
    return request.with_scene(Scene(scene.bodies, elements))


FAULTS = (
    whirling(
        name="fluid-at-rest",
        sentence="The rotating fluid is at rest, so that no speed makes the motion unstable.",
        sees=("growth", "rate"),
        before=of_elements(RotatingDashpot, rate=scaled(0.0)),
    ),
    whirling(
        name="fluid-turns-back",
        sentence="The fluid rotates in the opposite direction.",
        before=of_elements(RotatingDashpot, rate=scaled(-1.0)),
    ),
    whirling(
        name="dashpots-exchanged",
        sentence="The fluid at rest has the damping of the rotating fluid.",
        before=_exchanged,
    ),
    whirling(
        name="fluid-half-as-fast",
        sentence="The fluid rotates at half its speed.",
        before=of_elements(RotatingDashpot, rate=scaled(0.5)),
    ),
    whirling(
        name="fluid-one-percent",
        sentence="The fluid rotates 1 % too fast.",
        levels=5,
        before=of_elements(RotatingDashpot, rate=scaled(1.01)),
    ),
    whirling(
        name="shaft-mass-misread",
        sentence="The mass is 1 % too large.",
        levels=5,
        before=of_bodies(mass=lambda mass: 1.01 * mass),
    ),
    whirling(
        name="fluid-energy",
        sentence="The damping of the rotating fluid is 10 % larger than in the scene.",
        sees=("energy", "finest"),
        before=of_elements(RotatingDashpot, damping=scaled(1.1)),
    ),
    whirling(
        name="fluid-late",
        sentence="The rotating fluid uses the velocity of the previous evaluation.",
        method="rk4",
        sees=("order", "state"),
        inside=late_force(RotatingDashpot),
    ),
)
