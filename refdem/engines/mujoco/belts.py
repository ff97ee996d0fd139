"""A slider on a belt along x, as a sphere on a plane whose surface moves (`surfacevel`), pressed
down by a steady force.
"""

from typing import Any

from refdem.engines.mujoco import solver
from refdem.scene import Scene
from refdem.scene.elements.slider import Slider

RADIUS = 1.0
"""Radius of the sphere [m]; the sphere does not rotate, so that any value will do."""


def belts(scene: Scene) -> list[Slider]:
    """The sliders on moving surfaces; friction in a joint acts only against the world at rest."""
    return [slider for slider in scene.all(Slider) if slider.belt_velocity]


def add(mujoco: Any, spec: Any, scene: Scene, mj_bodies: list[Any], step: float) -> None:
    """A sphere on the body of each such slider, the plane under it, and their contact; no other
    geoms touch these.
    """
    alone = {"contype": 0, "conaffinity": 0}
    for number, slider in enumerate(belts(scene)):
        names = (f"on belt {number}", f"belt {number}")
        mj_bodies[slider.a].add_geom(
            name=names[0], type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(RADIUS, 0, 0), **alone
        )
        plane = {"type": mujoco.mjtGeom.mjGEOM_PLANE, "size": (0, 0, 1), "pos": (0, 0, -RADIUS)}
        moving = (slider.belt_velocity * slider.axis[0], 0, 0, 0, 0, 0)
        spec.worldbody.add_geom(name=names[1], surfacevel=moving, **plane, **alone)
        spec.add_pair(
            geomname1=names[0],
            geomname2=names[1],
            **solver.rubbing(slider.friction, step, RADIUS, solver.BELT),
        )


def press(scene: Scene, data: Any) -> None:
    """The normal force of each such slider, as a force applied to its body for the whole run."""
    for slider in belts(scene):
        data.body(f"body {slider.a}").xfrc_applied[2] -= slider.normal_force
