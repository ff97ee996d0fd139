"""What REBOUND cannot express of a scene, and the reasons in words."""

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
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

KNOWN = (
    CentralField,
    Contact,
    Dashpot,
    Force,
    PiecewiseField,
    Rod,
    RotatingDashpot,
    Spring,
    UniformGravity,
)
FIT = 1e-9
"""Largest relative difference of a rod's length and the initial distance of its ends: the
multiplier preserves the initial distance.
"""
MOST_TOUCHING = 64
"""Largest number of spheres, as every pair is visited in every evaluation of the forces."""
NO_FRICTION = engine_cannot("friction between particles (they have no spin)")
COLLIDING = frozenset(
    method.name for method in (LEAPFROG, LEAPFROG_LINE, LEAPFROG_UNCUT, AS_SHIPPED)
)
"""Methods that make the collisions of hard spheres."""
NEEDS_DERIVATIVES = frozenset({"leapfrog-8", IAS15.name, AS_SHIPPED.name})
"""Methods of high order, which need forces with several derivatives."""
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
    """None if the method can run the problem, else the missing feature."""
    scene = problem.scene
    if {"contact:friction", "shape:sphere"} <= scene.features:
        # Refused before walls are: friction needs spins, which walls do not bring.
        return NO_FRICTION
    unknown = [element.kind for element in scene.elements if not isinstance(element, KNOWN)]
    if unknown:
        kind = min(unknown)
        return UNKNOWN.get(kind, adapter_lacks(f"the element {kind}"))
    return (
        _link_reason(scene)
        or _contact_reason(scene)
        or _method_reason(scene, method)
        or _edge_reason(scene, method)
        or _time_reason(problem)
    )


def turning(scene: Scene) -> list[int]:
    """Indices of the bodies that rotate."""
    bodies = scene.bodies
    has_inertia = bodies.inertia.any(axis=1)
    has_spin = bodies.omega.any(axis=1)
    return np.flatnonzero(has_inertia & has_spin & ~bodies.fixed).tolist()


def _contact_reason(scene: Scene) -> str | None:
    """None if the contacts of the scene are those of spheres without friction, else the missing
    feature.
    """
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
    """None if the scene is nothing but hard spheres that are free to move, else the missing
    feature.
    """
    if len(scene.elements) > 1:
        return adapter_lacks("hard spheres on which forces act")
    if scene.bodies.fixed.any():
        return engine_cannot("a sphere that no collision moves (only mass resists a collision)")
    if not scene.bodies.radius.all():
        return adapter_lacks("points beside hard spheres")
    return None


def _link_reason(scene: Scene) -> str | None:
    """None if all forces act at centres and all rods can be held, else the missing feature."""
    for link in scene.elements:
        if isinstance(link, Link) and _acts_off_centre(link):
            return engine_cannot("a force off the centre of a body (particles have no attitude)")
    rods = scene.all(Rod)
    ends = [end for rod in rods for end in (rod.a, rod.b) if end >= 0]
    if len(set(ends)) < len(ends):
        return engine_cannot("rods that share a body (no constraint solver)")
    bodies = scene.bodies
    for rod in rods:
        distance = float(rod.distance(bodies.position[None], bodies.attitude[None])[0])
        if abs(distance - rod.length) > FIT * rod.length:
            return engine_cannot(
                "a rod whose length differs from the initial distance (the length is"
                " conserved, not set)"
            )
        if all(end < 0 or bodies.fixed[end] for end in (rod.a, rod.b)):
            return engine_cannot("a rod between bodies that do not move")
    return None


def _acts_off_centre(link: Link) -> bool:
    """True if a link is anchored to a body elsewhere than at its centre."""
    has_body_at_b = link.b >= 0
    return any(link.anchor_a) or (has_body_at_b and any(link.anchor_b))


def _method_reason(scene: Scene, method: str) -> str | None:
    """None if the integrator can take the bodies and forces of the scene, else the missing feature.

    Only bs integrates rotation. leapfrog accepts no forces that depend on velocities, and whfast
    accepts no forces other than those of an attracting centre.
    """
    rotors = turning(scene)
    if rotors and method != "bs":
        return engine_cannot(
            "rotation (particles have no spin; only bs carries Euler's equations beside them)"
        )
    if rotors and not scene.bodies.inertia[rotors].all():
        return engine_cannot("a spinning body with a moment of inertia that is zero")
    needs_velocity = {"rod", "dashpot", "contact:damping"} & scene.features
    if method.startswith("leapfrog") and needs_velocity:
        return engine_cannot(
            f"{min(needs_velocity)} (its force depends on velocities, which leapfrog has only half"
            " a step apart)"
        )
    has_rough_spring = any(spring.exponent % 2 != 1 for spring in scene.all(Spring))
    if method in NEEDS_DERIVATIVES and has_rough_spring:
        return engine_cannot(
            "a spring whose force is not smooth where it changes sign (order 8 needs its"
            " derivatives, ias15's steps shrink to nothing)"
        )
    if method == AS_SHIPPED.name and {"spring", "rod"} & scene.features:
        return engine_cannot(
            "springs and rods with the step control that ias15 is shipped with (prs23: steps shrink"
            " to nothing where the acceleration goes through zero)"
        )
    has_only_centres = all(isinstance(element, CentralField) for element in scene.elements)
    if method == "whfast" and not (scene.elements and has_only_centres):
        return engine_cannot("a field other than one attracting centre")
    return None


def _time_reason(problem: Motion) -> str | None:
    """None, or that hard spheres do not collide while time runs backwards.

    The search skips separating pairs by their velocities. With negative steps these are the pairs
    that approach each other, so that spheres pass through each other.
    """
    if problem.interval >= 0 or "contact:rigid" not in problem.scene.features:
        return None
    return engine_cannot(
        "collisions with negative steps (its search skips the pairs that then come nearer)"
    )


def _edge_reason(scene: Scene, method: str) -> str | None:
    """None if the integrator can take the contacts and edges of the scene, else the missing
    feature.

    Only leapfrog accepts contacts and piecewise fields, whose forces are not smooth at an edge.
    Hard spheres need one of the methods that search for collisions.
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
