"""What MuJoCo cannot express of springs, dashpots, dry friction and rods: None, or the missing
feature in a few words.
"""

import numpy as np

from refdem.core.refusal import adapter_lacks, engine_cannot
from refdem.scene import Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring

START_TOLERANCE = 1e-9
"""Largest relative error of a rod's length, and of the speed along it, at the start. It allows for
rounding; a hinge would not preserve a larger one.
"""


def of_springs(scene: Scene) -> str | None:
    """None if MuJoCo can express all springs, else what is missing."""
    rods = {body for rod in scene.all(Rod) for body in (rod.a, rod.b)} - {-1}
    for spring in scene.all(Spring):
        if rods & {spring.a, spring.b}:
            return adapter_lacks("a spring on a body that hangs on a rod")
    return None


def of_dashpots(scene: Scene) -> str | None:
    """None if joints or the callback can express all dashpots, else what is missing."""
    for dashpot in scene.all(Dashpot):
        if any(dashpot.anchor_a):
            return adapter_lacks("a dashpot off the centre of a body")
        if any(rod.a == dashpot.a for rod in scene.all(Rod)):
            return adapter_lacks("a dashpot on a body that hangs on a rod")
    return None


def of_sliders(scene: Scene) -> str | None:
    """None if MuJoCo can express all sliders, else what is missing."""
    for slider in scene.all(Slider):
        if slider.b >= 0:
            return adapter_lacks("dry friction between bodies")
        if slider.law != "coulomb":
            return engine_cannot(
                "dry friction that depends on speed: frictionloss and contacts"
                " (surfacevel) have one coefficient"
            )
        if sorted(np.abs(slider.axis)) != [0, 0, 1]:
            return adapter_lacks("dry friction along other axes than x, y or z")
        if "rotation" in scene.features and scene.bodies.inertia[slider.a].any():
            return engine_cannot("dry friction along an axis on a free joint")
        if any(rod.a == slider.a for rod in scene.all(Rod)):
            return adapter_lacks("dry friction on a body that hangs on a rod")
        if slider.belt_velocity and (
            abs(slider.axis[0]) < 1 or "dimension:1" not in scene.features
        ):
            return adapter_lacks("a belt for motion other than along x")
    return None


def of_rods(scene: Scene) -> str | None:
    """None if hinges can express all rods, else what is missing."""
    rods = scene.all(Rod)
    if rods and "dimension:3" in scene.features:
        return adapter_lacks("a rod out of a plane (in one it is a hinge)")
    above = {rod.a: rod.b for rod in rods}
    if len(above) < len(rods) or not all(_reaches_the_world(above, rod.a) for rod in rods):
        return engine_cannot(
            "rods that do not hang from the world or one below the other: they would be soft"
            " constraints"
        )
    place = scene.bodies.position
    velocity = scene.bodies.velocity
    for rod in rods:
        if any(rod.anchor_a) or (rod.b >= 0 and any(rod.anchor_b)) or scene.bodies.fixed[rod.a]:
            return adapter_lacks("a rod to a point other than the centre of a body")
        if rod.b >= 0:
            arm = place[rod.a] - place[rod.b]
            relative = velocity[rod.a] - velocity[rod.b]
        else:
            arm = place[rod.a] - np.array(rod.anchor_b)
            relative = velocity[rod.a]
        # A hinge holds |arm| = length and arm . v = 0 exactly; a start may miss both by rounding.
        slip = abs(arm @ relative)
        stretch = abs(np.linalg.norm(arm) - rod.length)
        is_long = stretch > START_TOLERANCE * rod.length
        slides = slip > START_TOLERANCE * rod.length * (1 + slip)
        if is_long or slides:
            return engine_cannot("a start off the rod, which a hinge cannot represent")
    return None


def _reaches_the_world(above: dict[int, int], body: int) -> bool:
    """True if the rods, followed upwards from body to body, end at the world."""
    for _ in above:
        if body not in above:
            return False
        body = above[body]
        if body < 0:
            return True
    return False
