"""What a scene may not have if REBOUND is to say it, and in which words it is refused."""

import numpy as np

from refdem.core.problem import Motion
from refdem.core.refusal import adapter_lacks, engine_cannot
from refdem.engines.rebound.methods import (
    AS_SHIPPED,
    IAS15,
    LEAPFROG,
    LEAPFROG_LINE,
    LEAPFROG_UNCUT,
)
from refdem.scene import Polyhedron, Scene
from refdem.scene.element import Link
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

KNOWN = (
    CentralField,
    Contact,
    Dashpot,
    Force,
    PiecewiseField,
    Rod,
    Spring,
    UniformGravity,
)
FIT = 1e-9
"""A rod fits if its ends are this close to its length, relatively: the multiplier keeps what it
finds.
"""
MOST_TOUCHING = 64
"""Spheres up to which every pair is looked at in every evaluation of the forces."""
NO_FRICTION = engine_cannot("friction between particles (they have no spin)")
COLLIDING = frozenset(
    method.name for method in (LEAPFROG, LEAPFROG_LINE, LEAPFROG_UNCUT, AS_SHIPPED)
)
"""Methods that make the collisions of hard spheres."""
UNKNOWN = {
    "slider": engine_cannot("dry friction (no force that jumps with the velocity)"),
    "plane": adapter_lacks("walls (a force by the callback)"),
    "ball_joint": engine_cannot("a ball joint (particles have no attitude)"),
    "moving_anchor": adapter_lacks(
        "a pivot that follows a function of time (a rod's force needs its acceleration)"
    ),
    "string_over_wheel": engine_cannot("a string over a wheel (no constraint solver)"),
    "catch": engine_cannot("a hook (no event starts a constraint)"),
    "wedge": adapter_lacks("wedge (a force that depends on an attitude, which jumps)"),
    "periodic_box": adapter_lacks("a periodic box (boundary = periodic, with ghost boxes)"),
}


def reason(problem: Motion, method: str) -> str | None:
    """None if the method can say the problem, else the missing feature."""
    scene = problem.scene
    if {"contact:friction", "shape:sphere"} <= scene.features:
        # Walls would not help: what friction turns has no spin.
        return NO_FRICTION
    unknown = [element.kind for element in scene.elements if not isinstance(element, KNOWN)]
    for kind in sorted(unknown):
        return UNKNOWN.get(kind, adapter_lacks(f"the element {kind}"))
    return (
        _link_reason(scene)
        or _contact_reason(scene)
        or _method_reason(scene, method)
        or _edge_reason(scene, method)
    )


def turning(scene: Scene) -> list[int]:
    """Numbers of the bodies that spin."""
    columns = scene.bodies
    return np.flatnonzero(
        columns.inertia.any(axis=1) & columns.omega.any(axis=1) & ~columns.fixed
    ).tolist()


def _contact_reason(scene: Scene) -> str | None:
    """A soft contact is a force between two particles along the line of their centres."""
    laws = scene.all(Contact)
    if not laws or not scene.has_shapes():
        return None
    law = laws[0]
    if law.friction > 0:
        return NO_FRICTION
    if any(isinstance(shape, Polyhedron) for shape in scene.bodies.shape):
        return engine_cannot("contact of polyhedra (particles are spheres)")
    if law.law == "rigid":
        return _hard_sphere_reason(scene)
    if len(scene.bodies) > MOST_TOUCHING:
        return adapter_lacks(
            f"a soft contact of more than {MOST_TOUCHING} spheres (every pair in the callback)"
        )
    return None


def _hard_sphere_reason(scene: Scene) -> str | None:
    """REBOUND's hard spheres change velocities and nothing else; every pair may collide."""
    if len(scene.elements) > 1:
        return adapter_lacks("hard spheres on which forces act")
    if scene.bodies.fixed.any():
        return engine_cannot("a sphere that no collision moves (only mass resists a collision)")
    if not scene.bodies.radius.all():
        return adapter_lacks("points beside hard spheres")
    return None


def _link_reason(scene: Scene) -> str | None:
    """Forces act at centres; a rod stands alone and fits."""
    links = [element for element in scene.elements if isinstance(element, Link)]
    if any(any(link.anchor_a) or (link.b >= 0 and any(link.anchor_b)) for link in links):
        return engine_cannot("a force off the centre of a body (particles have no attitude)")
    ends = [end for rod in scene.all(Rod) for end in (rod.a, rod.b) if end >= 0]
    if len(set(ends)) < len(ends):
        return engine_cannot("rods that share a body (no constraint solver)")
    for rod in scene.all(Rod):
        columns = scene.bodies
        gap = float(rod.distance(columns.position[None], columns.attitude[None])[0])
        if abs(gap - rod.length) > FIT * rod.length:
            return engine_cannot(
                "a rod whose length differs from the initial distance (the length is"
                " conserved, not set)"
            )
        if all(end < 0 or columns.fixed[end] for end in (rod.a, rod.b)):
            return engine_cannot("a rod between bodies that do not move")
    return None


def _method_reason(scene: Scene, method: str) -> str | None:
    """Only bs carries rotation; leapfrog takes no velocities; whfast knows a centre and nothing
    else.
    """
    rotors = turning(scene)
    if rotors and method != "bs":
        return engine_cannot(
            "rotation (particles have no spin; only bs carries Euler's equations beside them)"
        )
    if rotors and not scene.bodies.inertia[rotors].all():
        return engine_cannot("a spinning body with a moment of inertia that is zero")
    if method.startswith("leapfrog"):
        for kind in {"rod", "dashpot", "contact:damping"} & scene.features:
            return engine_cannot(
                f"{kind} (its force depends on velocities, which leapfrog has only half a step"
                " apart)"
            )
    if method in ("leapfrog-8", IAS15.name, AS_SHIPPED.name) and any(
        spring.exponent % 2 != 1 for spring in scene.all(Spring)
    ):
        return engine_cannot(
            "a spring whose force is not smooth where it changes sign (order 8 needs its"
            " derivatives, ias15's steps shrink to nothing)"
        )
    if method == AS_SHIPPED.name and {"spring", "rod"} & scene.features:
        return engine_cannot(
            "springs and rods with the step control that ias15 is shipped with (prs23: steps shrink"
            " to nothing where the acceleration goes through zero)"
        )
    if method == "whfast" and not (
        scene.elements and all(isinstance(e, CentralField) for e in scene.elements)
    ):
        return engine_cannot("a field other than one attracting centre")
    return None


def _edge_reason(scene: Scene, method: str) -> str | None:
    """Leapfrog alone takes forces that set in at an edge; collisions are found by its searches, and
    by what REBOUND is shipped with.
    """
    if "contact:rigid" in scene.features:
        if method in COLLIDING:
            return None
        return adapter_lacks("hard spheres by an integrator other than leapfrog of order 2")
    if method in (LEAPFROG_LINE.name, LEAPFROG_UNCUT.name):
        return adapter_lacks("a scene without hard spheres (it would be leapfrog once more)")
    if method != "leapfrog" and {"contact", "piecewise_field"} & scene.features:
        return engine_cannot(
            "a force that sets in at an edge (order 8 and ias15 need its derivatives; a step of bs"
            " passes an edge unseen and is off by a thousand times its tolerance)"
        )
    return None
