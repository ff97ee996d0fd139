"""What MuJoCo cannot say, read off the scene's content: None, or the missing feature in a few words."""

from itertools import islice

import numpy as np

from refdem.core.problem import Motion
from refdem.engines.mujoco.shapes import box_sides, pairs
from refdem.scene import Polyhedron, Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring

SAID = {"spring", "slider", "rod", "plane", "contact", "uniform_gravity"}
SMALLEST = 1e-15
"""mjMINVAL: mass [kg] and principal inertia [kg m^2] of a moving body may not be below it."""


def refusal(problem: Motion) -> str | None:
    """None if the scene can be said exactly, else the first reason why not."""
    scene = problem.scene
    if problem.interval < 0:
        return "negative steps: MuJoCo takes them but does not document what they mean"
    for element in scene.elements:
        if element.kind not in SAID:
            return {"central_field": "no central field: gravity is uniform"}.get(element.kind, f"no element {element.kind}")
    for judged in (_of_bodies, _of_springs, _of_sliders, _of_rods, _of_contact):
        if reason := judged(scene):
            return reason
    return None


def _of_bodies(scene: Scene) -> str | None:
    bodies = scene.bodies
    moving = ~bodies.fixed
    if np.any(bodies.mass[moving] < SMALLEST):
        return f"a mass below {SMALLEST:g} kg"
    solid = bodies.inertia[moving & bodies.inertia.any(axis=1)]
    if "rotation" in scene.features and np.any(solid < SMALLEST):
        return "a turning body without inertia about one axis"
    return None


def _of_springs(scene: Scene) -> str | None:
    rods = {body for rod in scene.all(Rod) for body in (rod.a, rod.b)} - {-1}
    for spring in scene.all(Spring):
        if spring.exponent not in (1, 3):
            return f"no spring of exponent {spring.exponent:g}: its force is a polynomial, linear or cubic where it is odd"
        if rods & {spring.a, spring.b}:
            return "this adapter says no spring on a body that hangs on a rod"
    return None


def _of_sliders(scene: Scene) -> str | None:
    for slider in scene.all(Slider):
        if slider.b >= 0:
            return "this adapter says dry friction against the world only"
        if sorted(np.abs(slider.axis)) != [0, 0, 1]:
            return "this adapter says dry friction along x, y or z only"
        if "rotation" in scene.features and scene.bodies.inertia[slider.a].any():
            return "no dry friction along an axis on a free joint"
        if any(rod.a == slider.a for rod in scene.all(Rod)):
            return "this adapter says no dry friction on a body that hangs on a rod"
    return None


def _of_rods(scene: Scene) -> str | None:
    rods = scene.all(Rod)
    if rods and "dimension:3" in scene.features:
        return "this adapter says a rod in a plane only (as a hinge); else it would be a soft constraint"
    if any(rod.b >= 0 for rod in rods) or len({rod.a for rod in rods}) < len(rods):
        return "this adapter says rods that hang from the world only, one a body; else they would be soft constraints"
    for rod in rods:
        arm = np.subtract(scene.bodies.position[rod.a], rod.anchor_b)
        if any(rod.anchor_a) or scene.bodies.fixed[rod.a]:
            return "this adapter says a rod to a body's centre only"
        slip = abs(arm @ scene.bodies.velocity[rod.a])
        if abs(np.linalg.norm(arm) - rod.length) > 1e-9 * rod.length or slip > 1e-9 * rod.length * (1 + slip):
            return "a start off the rod: a hinge cannot show it"
    return None


def _of_contact(scene: Scene) -> str | None:
    found = scene.all(Contact)
    if not found or not scene.has_shapes():
        return None
    if len(found) > 1:
        return "this adapter says one contact law a scene"
    law, shapes = found[0], scene.bodies.shape
    if law.law == "rigid":
        if law.restitution > 0:
            return "no coefficient of restitution"
        if any(isinstance(shape, Polyhedron) and box_sides(shape) is None for shape in shapes):
            return "this adapter says boxes only, no other polyhedra"
        return None
    if any(isinstance(shape, Polyhedron) for shape in shapes):
        return "no linear contact law for polyhedra"
    if law.friction > 0:
        return "no tangential contact spring with a Coulomb limit: its friction is a velocity constraint"
    if law.damping > 0 and law.cutoff == "zero_overlap":
        return "no contact force that pulls: it ends when it would, before the overlap does"
    if len(list(islice(pairs(scene), 2))) > 1:
        return "a linear contact law holds for one pair only: where contacts share a body they change each other"
    if scene.elements and {e.kind for e in scene.elements} - {"contact", "plane"}:
        return "its linear contact law holds in the absence of other forces only"
    return None
