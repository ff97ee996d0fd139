"""What Chipmunk cannot express of a scene, and the words in which it is refused."""

import numpy as np

from refdem.core.problem import Motion
from refdem.core.refusal import adapter_lacks, engine_cannot
from refdem.scene import Polyhedron, Scene, Sphere
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

UNKNOWN = {
    "moving_anchor": engine_cannot(
        "a pivot that follows a function of time (a kinematic body keeps its velocity for a whole"
        " step)"
    ),
    "string_over_wheel": engine_cannot("a string over a wheel (no pulley among the joints)"),
    "catch": engine_cannot(
        "a hook that catches at closest approach (joints hold from the start, or are added between"
        " steps)"
    ),
    "periodic_box": engine_cannot("a periodic box"),
    "wedge": adapter_lacks("wedge (a force by the velocity function, and a body that turns)"),
}
KNOWN = (
    CentralField,
    Contact,
    Dashpot,
    Force,
    PiecewiseField,
    Plane,
    Rod,
    RotatingDashpot,
    Slider,
    Spring,
    UniformGravity,
)


def reason(problem: Motion) -> str | None:
    """None if Chipmunk can run the problem, else the missing feature."""
    scene = problem.scene
    if problem.interval < 0:
        return engine_cannot("negative time steps")
    if "dimension:3" in scene.features:
        return engine_cannot("motion or rotation in three dimensions")
    for element in scene.elements:
        if not isinstance(element, KNOWN):
            return UNKNOWN.get(element.kind, adapter_lacks(f"the element {element.kind}"))
    return _element_reason(scene) or _contact_reason(scene)


def _element_reason(scene: Scene) -> str | None:
    """None if all dashpots, forces and sliders can be expressed, else the first that cannot."""
    for dashpot in scene.all(Dashpot):
        if dashpot.b >= 0:
            return engine_cannot(
                "a dashpot between bodies that resists in all directions (DampedSpring resists"
                " along its line)"
            )
        if any(dashpot.anchor_a):
            return adapter_lacks("a dashpot off the centre of a body")
    if any(force.b >= 0 or scene.bodies.fixed[force.a] for force in scene.all(Force)):
        return adapter_lacks("a periodic force between bodies or on a fixed body")
    if scene.all(Slider) and "dimension:1" not in scene.features:
        return engine_cannot(
            "dry friction along one axis of a planar motion (a joint rubs in all directions)"
        )
    return None


def fading(scene: Scene) -> float | None:
    """The rate [1/s] at which the dashpots damp the velocity of every body, dv/dt = -rate v.

    None if the dashpots do not damp all bodies alike and relative to the world. `Space.damping`
    cannot express these, and they become forces.
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
    """None if the contact law can be expressed, else the missing feature.

    Rigid contact is between circles and prisms along z, soft contact between circles only.
    """
    law = next(iter(scene.all(Contact)), None)
    if law is None or not scene.has_shapes():
        return None
    if law.law != "rigid":
        return _soft_contact_reason(scene, law)
    if "contact:tangential-restitution" in scene.features:
        return engine_cannot("an impact that reverses the slip (friction of impulses stops it)")
    for shape, inertia in zip(scene.bodies.shape, scene.bodies.inertia, strict=True):
        if not inertia[2] > 0 and (
            isinstance(shape, Polyhedron) or (isinstance(shape, Sphere) and law.friction > 0)
        ):
            return engine_cannot("contact forces that turn a body without a moment of inertia")
        if isinstance(shape, Polyhedron) and outline(shape) is None:
            return engine_cannot("a polyhedron that is not a prism along z")
    return None


def _soft_contact_reason(scene: Scene, law: Contact) -> str | None:
    """None if the soft contacts are those of spheres without friction, which a spring along the
    line of their centres can express; else the missing feature.
    """
    if law.friction > 0:
        return engine_cannot(
            "friction of a contact that has a stiffness (friction belongs to Chipmunk's own rigid"
            " contacts; a spring acts along its line)"
        )
    if any(isinstance(shape, Polyhedron) for shape in scene.bodies.shape):
        return engine_cannot("a soft contact of polyhedra (a spring joins two points)")
    if scene.all(Plane):
        return engine_cannot("a soft contact with a wall (a spring joins two points)")
    return None


def outline(shape: Polyhedron) -> list[tuple[float, float]] | None:
    """Corners in x-y of a prism along z; None for another polyhedron."""
    corners = np.asarray(shape.vertices, float)
    low = corners[:, 2].min()
    high = corners[:, 2].max()
    bottom = {tuple(c[:2]) for c in corners.tolist() if c[2] == low}
    top = {tuple(c[:2]) for c in corners.tolist() if c[2] == high}
    if bottom == top and len(bottom) + len(top) == len(corners):
        return sorted(bottom)
    return None
