"""What MuJoCo cannot express, from the contents of the scene: None, or the missing feature in a few
words.
"""

from itertools import islice

import numpy as np

from refdem.core.problem import Motion
from refdem.core.refusal import adapter_lacks, engine_cannot
from refdem.engines.mujoco import contacts, links, solver
from refdem.engines.mujoco.ball import of_ball_joints
from refdem.engines.mujoco.belts import belts
from refdem.engines.mujoco.claims import differentiates, is_tuned
from refdem.engines.mujoco.passive import of_passive
from refdem.engines.mujoco.shapes import box_sides, effective_masses
from refdem.scene import Polyhedron, Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.uniform_gravity import UniformGravity

SUPPORTED = {
    "ball_joint",
    "central_field",
    "dashpot",
    "force",
    "piecewise_field",
    "spring",
    "slider",
    "rod",
    "rotating_dashpot",
    "plane",
    "contact",
    "uniform_gravity",
}
UNSUPPORTED = {
    "moving_anchor": engine_cannot(
        "a joint that follows a function of time: a mocap body is moved between"
        " steps and has no velocity"
    ),
    "string_over_wheel": engine_cannot(
        "a taut string: a tendon holds its length as a soft constraint"
    ),
    "catch": engine_cannot(
        "a constraint that begins at closest approach: constraints are switched"
        " between steps only, and are soft"
    ),
    "periodic_box": engine_cannot("a periodic box"),
    "wedge": adapter_lacks("wedge (a force by mjcb_passive, and a body that turns)"),
    "internal_damping": adapter_lacks("internal_damping (a torque by mjcb_passive)"),
}
SMALLEST = 1e-15
"""mjMINVAL: mass [kg] and principal inertia [kg m^2] of a moving body may not be below it."""


def heaviest(impedance: float) -> float:
    """The largest effective mass [kg] at which a constraint of impedance d has its proper softness.

    MuJoCo regularises a constraint with R = max(mjMINVAL, (1 - d)/d / m_eff) (mj_makeImpedance).
    Above m_eff = (1 - d)/(d mjMINVAL) R is too large, and the force of the constraint tends to 0.
    """
    return (1 - impedance) / impedance / SMALLEST


def unsupported(problem: Motion, method: str = "rk4") -> str | None:
    """None if MuJoCo can express the scene exactly, else the first reason why not."""
    scene = problem.scene
    if not is_tuned(method) and (reason := _as_shipped(scene)):
        return reason
    if differentiates(method) and (scene.is_kinked() or "contact" in scene.features):
        return adapter_lacks("derivatives through contact, dry friction and other kinks")
    if problem.interval < 0:
        return engine_cannot(
            "negative time steps: MuJoCo accepts them but does not document their meaning"
        )
    for element in scene.elements:
        if element.kind not in SUPPORTED:
            return UNSUPPORTED.get(element.kind, adapter_lacks(f"the element {element.kind}"))
    for judged in (
        _of_bodies,
        links.of_springs,
        links.of_dashpots,
        links.of_sliders,
        links.of_rods,
        of_ball_joints,
        of_passive,
        _of_contact,
        _of_soft_constraints,
    ):
        if reason := judged(scene):
            return reason
    return None


def _as_shipped(scene: Scene) -> str | None:
    """None if MuJoCo's default solver settings can express the scene, else the reason why not."""
    if any(law.law == "linear" for law in scene.all(Contact)):
        return engine_cannot("a linear contact law as shipped: solref and solimp are settings")
    if belts(scene):
        return adapter_lacks("a belt as shipped")
    return None


def _of_bodies(scene: Scene) -> str | None:
    bodies = scene.bodies
    moving = ~bodies.fixed
    if np.any(bodies.mass[moving] < SMALLEST):
        return engine_cannot(f"a mass below {SMALLEST:g} kg")
    solid = bodies.inertia[moving & bodies.inertia.any(axis=1)]
    if "rotation" in scene.features and np.any(solid < SMALLEST):
        return engine_cannot("a rotating body with zero inertia about one axis")
    return None


def _of_contact(scene: Scene) -> str | None:
    laws = scene.all(Contact)
    if not laws or not scene.has_shapes():
        return None
    if len(laws) > 1:
        return adapter_lacks("more than one contact law per scene")
    law = laws[0]
    if law.law == "rigid":
        return _of_rigid_contact(scene, law)
    if law.law == "linear":
        return _of_linear_contact(scene, law)
    return engine_cannot(
        f"contact law {law.law}: MuJoCo's contacts are linear springs and dampers in the"
        " acceleration"
    )


def _of_rigid_contact(scene: Scene, law: Contact) -> str | None:
    """None if the rigid law can be expressed, else the reason why not.

    MuJoCo prevents penetration, but has no law of restitution.
    """
    if law.restitution > 0:
        return engine_cannot("a coefficient of restitution")
    if not scene.all(UniformGravity):
        return engine_cannot(
            "impacts with restitution 0: its contacts are springs, which return energy"
        )
    solids = [shape for shape in scene.bodies.shape if isinstance(shape, Polyhedron)]
    if any(box_sides(solid) is None for solid in solids):
        return adapter_lacks("polyhedra other than boxes")
    return None


def _of_linear_contact(scene: Scene, law: Contact) -> str | None:
    """None if the linear law can be expressed, else the reason why not.

    A constraint can have the acceleration of a spring and a damper of one pair, with friction that
    has no tangential spring.
    """
    if any(isinstance(shape, Polyhedron) for shape in scene.bodies.shape):
        return engine_cannot("a linear contact law for polyhedra")
    if law.friction > 0 and law.tangential_stiffness > 0:
        return engine_cannot(
            "a tangential contact spring with a Coulomb limit: MuJoCo's friction is a"
            " velocity constraint"
        )
    if law.friction > 0 and law.branch != "R-d/2":
        return engine_cannot(
            f"friction at the lever arm {law.branch}: MuJoCo's contacts are in the middle of the"
            " overlap"
        )
    if law.damping > 0 and law.cutoff == "zero_overlap":
        return engine_cannot(
            "an attractive contact force: MuJoCo's force ends before the overlap does"
        )
    if len(list(islice(effective_masses(scene), 2))) > 1:
        return engine_cannot(
            "a linear contact law for more than one pair: contacts that share a body"
            " change each other"
        )
    if scene.elements and {e.kind for e in scene.elements} - {"contact", "plane"}:
        return engine_cannot("a linear contact law beside other forces")
    return None


def _of_soft_constraints(scene: Scene) -> str | None:
    """None if no contact or dry friction acts on so much mass that MuJoCo would soften it."""
    softened = []
    for slider in scene.all(Slider):
        if slider.belt_velocity:
            impedance = solver.BELT
        else:
            impedance = solver.HARDEST
        softened.append((impedance, scene.bodies.mass[slider.a]))
    for law in scene.all(Contact):
        impedance = contacts.impedance_of(scene, law)
        softened += [(impedance, effective_mass) for effective_mass in effective_masses(scene)]
    for impedance, mass in softened:
        if mass > heaviest(impedance):
            return engine_cannot(
                f"a contact or dry friction with more than {heaviest(impedance):.0e} kg:"
                f" MuJoCo softens every constraint by at least mjMINVAL = {SMALLEST:g} per"
                " kg"
            )
    return None
