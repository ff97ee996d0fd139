"""What a scene may not have if REBOUND is to say it, and in which words it is refused."""

import numpy as np

from refdem.core.problem import Motion
from refdem.scene import Scene
from refdem.scene.element import Link
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

KNOWN = (CentralField, Dashpot, Force, Rod, Spring, UniformGravity)
FIT = 1e-9
"""A rod fits if its ends are this close to its length, relatively: the multiplier keeps what it
finds.
"""
UNKNOWN = {
    "slider": "dry friction (no force that jumps with the velocity)",
    "contact": "contact with a force law (only instantaneous collisions of hard spheres)",
    "plane": "walls",
    "ball_joint": "a ball joint (particles have no attitude)",
    "moving_anchor": (
        "a pivot that follows a function of time (a rod's force needs a point at"
        " rest or a particle)"
    ),
    "string_over_wheel": "a string over a wheel (no constraint solver)",
    "catch": "a hook (no event starts a constraint)",
}


def reason(problem: Motion, method: str) -> str | None:
    """None if the method can say the problem, else the missing feature."""
    scene = problem.scene
    unknown = [element.kind for element in scene.elements if not isinstance(element, KNOWN)]
    for kind in sorted(unknown):
        return UNKNOWN.get(kind, f"{kind} (no such element)")
    return _link_reason(scene) or _method_reason(scene, method)


def turning(scene: Scene) -> list[int]:
    """Numbers of the bodies that spin."""
    columns = scene.bodies
    return np.flatnonzero(
        columns.inertia.any(axis=1) & columns.omega.any(axis=1) & ~columns.fixed
    ).tolist()


def _link_reason(scene: Scene) -> str | None:
    """Forces act at centres; a rod stands alone and fits."""
    links = [element for element in scene.elements if isinstance(element, Link)]
    if any(any(link.anchor_a) or (link.b >= 0 and any(link.anchor_b)) for link in links):
        return "a force off the centre of a body (particles have no attitude)"
    ends = [end for rod in scene.all(Rod) for end in (rod.a, rod.b) if end >= 0]
    if len(set(ends)) < len(ends):
        return "rods that share a body (no constraint solver)"
    for rod in scene.all(Rod):
        columns = scene.bodies
        gap = float(rod.distance(columns.position[None], columns.attitude[None])[0])
        if abs(gap - rod.length) > FIT * rod.length:
            return (
                "a rod whose length differs from the initial distance (the length is"
                " conserved, not set)"
            )
        if all(end < 0 or columns.fixed[end] for end in (rod.a, rod.b)):
            return "a rod between bodies that do not move"
    return None


def _method_reason(scene: Scene, method: str) -> str | None:
    """Only bs carries rotation; leapfrog takes no velocities; whfast knows a centre and nothing
    else.
    """
    rotors = turning(scene)
    if rotors and method != "bs":
        return "rotation (particles have no spin; only bs carries Euler's equations beside them)"
    if rotors and not scene.bodies.inertia[rotors].all():
        return "a spinning body with a moment of inertia that is zero"
    if method.startswith("leapfrog"):
        for kind in {"rod", "dashpot"} & scene.features:
            return (
                f"a {kind} (its force depends on velocities, which leapfrog has only half a step"
                " apart)"
            )
    if method in ("leapfrog-8", "ias15") and any(
        spring.exponent % 2 != 1 for spring in scene.all(Spring)
    ):
        return (
            "a spring whose force is not smooth where it changes sign (order 8 needs its"
            " derivatives, ias15's steps shrink to nothing)"
        )
    if method == "whfast" and not (
        scene.elements and all(isinstance(e, CentralField) for e in scene.elements)
    ):
        return "a field other than one attracting centre"
    return None
