"""What a scene may not have if Chipmunk is to say it, and in which words it is refused."""

import numpy as np

from refdem.core.problem import Motion
from refdem.scene import Polyhedron, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

UNKNOWN = {
    "moving_anchor": (
        "a pivot that follows a function of time (a kinematic body keeps its velocity)"
    ),
    "string_over_wheel": "a string over a wheel (no pulley among the joints)",
    "catch": (
        "a hook that catches at closest approach (joints hold from the start, or"
        " are added between steps)"
    ),
}
KNOWN = (Contact, Dashpot, Force, Plane, Rod, Slider, Spring, UniformGravity)


def reason(problem: Motion) -> str | None:
    """None if Chipmunk can say the problem, else the missing feature."""
    scene = problem.scene
    if problem.interval < 0:
        return "negative time steps"
    if "dimension:3" in scene.features:
        return "motion or rotation in three dimensions"
    for element in scene.elements:
        if not isinstance(element, KNOWN):
            return UNKNOWN.get(
                element.kind,
                (
                    f"{element.kind} (Chipmunk has no such element; a user would program it as"
                    " a force)"
                ),
            )
    return _element_reason(scene) or _contact_reason(scene)


def _element_reason(scene: Scene) -> str | None:
    """Springs are linear, dry friction acts on every velocity at once."""
    if any(
        spring.exponent != 1 or spring.quadratic or spring.cubic for spring in scene.all(Spring)
    ):
        return "a spring with a nonlinear force"
    if scene.all(Dashpot) and fading(scene) is None:
        return "damping other than one rate of all bodies against the world (Space.damping)"
    if any(force.b >= 0 or scene.bodies.fixed[force.a] for force in scene.all(Force)):
        return "a force between bodies or on a fixed body (Chipmunk applies forces from outside)"
    if scene.all(Slider) and "dimension:1" not in scene.features:
        return "dry friction along one axis of a planar motion"
    return None


def fading(scene: Scene) -> float | None:
    """The rate [1/s] at which the dashpots take velocity from every body alike.

    None if they do not.
    """
    free = [number for number, fixed in enumerate(scene.bodies.fixed) if not fixed]
    damping = dict.fromkeys(free, 0.0)
    for dashpot in scene.all(Dashpot):
        if (
            dashpot.b >= 0
            or dashpot.van_der_pol
            or dashpot.damping < 0
            or any(dashpot.anchor_a)
            or dashpot.a not in damping
        ):
            return None
        damping[dashpot.a] += dashpot.damping
    rates = {damping[number] / float(scene.bodies.mass[number]) for number in free}
    turns = scene.all(Dashpot) and "rotation" in scene.features  # turning would be damped as well
    if len(rates) == 1 and not turns:
        return rates.pop()
    return None


def _contact_reason(scene: Scene) -> str | None:
    """Contact is rigid, between circles and prisms along z."""
    law = next(iter(scene.all(Contact)), None)
    if law is None or not scene.has_shapes():
        return None
    if law.law != "rigid":
        return f"contact:{law.law} (impulses between rigid bodies only, no contact stiffness)"
    for shape, inertia in zip(scene.bodies.shape, scene.bodies.inertia, strict=True):
        if not inertia[2] > 0 and (
            isinstance(shape, Polyhedron) or (isinstance(shape, Sphere) and law.friction > 0)
        ):
            return "contact forces that turn a body without a moment of inertia"
        if isinstance(shape, Polyhedron) and outline(shape) is None:
            return "a polyhedron that is not a prism along z"
    return None


def outline(shape: Polyhedron) -> list[tuple[float, float]] | None:
    """Corners in x-y of a prism along z, or None if the polyhedron is none."""
    corners = np.asarray(shape.vertices, float)
    low = corners[:, 2].min()
    high = corners[:, 2].max()
    bottom = {tuple(c[:2]) for c in corners.tolist() if c[2] == low}
    top = {tuple(c[:2]) for c in corners.tolist() if c[2] == high}
    if bottom == top and len(bottom) + len(top) == len(corners):
        return sorted(bottom)
    return None
