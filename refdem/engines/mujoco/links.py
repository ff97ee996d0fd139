"""What MuJoCo cannot say of springs, dashpots, dry friction and rods: None, or the missing feature
in a few words.
"""

import numpy as np

from refdem.scene import Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring


def of_springs(scene: Scene) -> str | None:
    """None if every one of the springs can be said."""
    rods = {body for rod in scene.all(Rod) for body in (rod.a, rod.b)} - {-1}
    for spring in scene.all(Spring):
        if spring.exponent not in (1, 3):
            return (
                f"a spring of exponent {spring.exponent:g}: MuJoCo's spring force is a"
                " polynomial, linear or odd and cubic"
            )
        if spring.quadratic:
            return (
                "a spring with a quadratic term: even powers of MuJoCo's polynomial"
                " change sign with the stretch"
            )
        if rods & {spring.a, spring.b}:
            return "the adapter does not support a spring on a body that hangs on a rod"
    return None


def of_dashpots(scene: Scene) -> str | None:
    """None if every one of the dashpots can be said."""
    ends = [dashpot.a for dashpot in scene.all(Dashpot)]
    for dashpot in scene.all(Dashpot):
        if dashpot.van_der_pol or dashpot.damping < 0:
            return "damping that depends on position or is negative"
        if dashpot.b >= 0 or ends.count(dashpot.a) > 1:
            return "the adapter supports one dashpot per body, against the world only"
        turns = "rotation" in scene.features and scene.bodies.inertia[dashpot.a].any()
        if turns or any(rod.a == dashpot.a for rod in scene.all(Rod)):
            return "the adapter does not support a dashpot on a body that rotates or hangs on a rod"
    return None


def of_sliders(scene: Scene) -> str | None:
    """None if every one of the sliders can be said."""
    for slider in scene.all(Slider):
        if slider.b >= 0:
            return "the adapter supports dry friction against the world only"
        if slider.law != "coulomb":
            return (
                "dry friction that depends on speed: frictionloss and contacts"
                " (surfacevel) have one coefficient"
            )
        if sorted(np.abs(slider.axis)) != [0, 0, 1]:
            return "the adapter supports dry friction along x, y or z only"
        if "rotation" in scene.features and scene.bodies.inertia[slider.a].any():
            return "dry friction along an axis on a free joint"
        if any(rod.a == slider.a for rod in scene.all(Rod)):
            return "the adapter does not support dry friction on a body that hangs on a rod"
        if slider.belt_velocity and (
            abs(slider.axis[0]) < 1 or "dimension:1" not in scene.features
        ):
            return "the adapter supports a belt for motion along x only"
    return None


def of_rods(scene: Scene) -> str | None:
    """None if every one of the rods can be said."""
    rods = scene.all(Rod)
    if rods and "dimension:3" in scene.features:
        return (
            "the adapter supports a rod in a plane only (as a hinge); otherwise it"
            " would be a soft constraint"
        )
    above = {rod.a: rod.b for rod in rods}
    if len(above) < len(rods) or not all(_reaches_the_world(above, rod.a) for rod in rods):
        return (
            "the adapter supports only rods that hang from the world or one below the"
            " other; others would be soft constraints"
        )
    place = scene.bodies.position
    velocity = scene.bodies.velocity
    for rod in rods:
        if any(rod.anchor_a) or (rod.b >= 0 and any(rod.anchor_b)) or scene.bodies.fixed[rod.a]:
            return "the adapter supports a rod to the centre of a body only"
        if rod.b >= 0:
            arm = place[rod.a] - place[rod.b]
            relative = velocity[rod.a] - velocity[rod.b]
        else:
            arm = place[rod.a] - np.array(rod.anchor_b)
            relative = velocity[rod.a]
        slip = abs(arm @ relative)
        if abs(np.linalg.norm(arm) - rod.length) > 1e-9 * rod.length or slip > 1e-9 * rod.length * (
            1 + slip
        ):
            return "a start off the rod, which a hinge cannot represent"
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
