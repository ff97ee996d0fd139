"""Forces that follow the clock: MuJoCo's callback for passive forces, called in every stage of an
integrator at that stage's time.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import cos
from typing import Any

from refdem.scene import Scene
from refdem.scene.elements.force import Force

Push = tuple[Force, list[tuple[int, float]]]
"""A force, and the velocities of the model on which it acts, each with its part of the axis."""


@contextmanager
def driving(mujoco: Any, scene: Scene, places: Sequence[list[int]]) -> Iterator[None]:
    """While a run lasts the scene's forces act on the velocities `places` of its bodies; the
    callback is the process's, not a model's.
    """
    kept = mujoco.get_mjcb_passive()
    pushes: list[Push] = [
        (f, [(v, f.axis[k]) for k, v in enumerate(places[f.a][:3]) if f.axis[k]])
        for f in scene.all(Force)
    ]
    if pushes:
        mujoco.set_mjcb_passive(_passive(pushes))
    try:
        yield
    finally:
        if pushes:
            mujoco.set_mjcb_passive(kept)


def _passive(pushes: Sequence[Push]) -> Any:
    """The callback that applies the periodic forces."""

    def passive(model: Any, data: Any) -> None:
        time = data.time
        felt = data.qfrc_passive
        for force, parts in pushes:
            size = force.amplitude * cos(force.frequency * time + force.phase)
            for place, part in parts:
                felt[place] += size * part

    return passive


def of_forces(scene: Scene) -> str | None:
    """None if every force acts on one body that moves along the axes of space; else why not."""
    for force in scene.all(Force):
        if force.b >= 0 or any(force.anchor_a):
            return (
                "the adapter supports periodic forces on the centre of one body only, not"
                " between bodies"
            )
        if scene.bodies.fixed[force.a]:
            return "a force on a fixed body"
    if scene.all(Force) and any(
        element.kind in ("rod", "ball_joint") for element in scene.elements
    ):
        return (
            "the adapter supports periodic forces on free bodies only: coordinates of"
            " rotating joints are not positions"
        )
    return None
