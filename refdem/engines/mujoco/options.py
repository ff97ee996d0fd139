"""MuJoCo's options and flags: features that the scene does not need are disabled, and so is every
automatic change of forces or states.
"""

from typing import Any

import numpy as np

from refdem.engines.mujoco import solver
from refdem.engines.mujoco.claims import INTEGRATORS, is_tuned
from refdem.engines.mujoco.passive import is_passive
from refdem.scene import Scene
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.uniform_gravity import UniformGravity

NEVER = ("LIMIT", "EQUALITY", "ACTUATION", "SENSOR", "WARMSTART", "AUTORESET")
NOSLIP = 100
"""Most iterations of the post-solver that takes the softness out of friction; it ends by itself
when nothing changes.
"""
ITERATIONS = 100
"""Most Newton iterations of the constraint solver, MuJoCo's default; it ends at TOLERANCE, in a
few.
"""
TOLERANCE = 1e-15
"""Tolerance of the constraint solver, scaled by mean inertia: a few units of round-off of binary64.
"""
FRICTION_TO_NORMAL = 1.0
"""Ratio of the impedances of friction and of normal constraints, MuJoCo's default."""


def set_compiler(mujoco: Any, spec: Any) -> None:
    """Makes the compiler use mass and inertia as they are given."""
    compiler = spec.compiler
    compiler.degree = False
    compiler.balanceinertia = False
    compiler.boundmass = compiler.boundinertia = 0.0
    compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    compiler.settotalmass = -1.0
    compiler.fusestatic = False
    compiler.alignfree = False


def set_options(mujoco: Any, spec: Any, scene: Scene, method: str, step: float) -> None:
    """Sets step, integrator and gravity, and also solver and flags for a tuned method."""
    option = spec.option
    option.timestep = step
    option.integrator = getattr(mujoco.mjtIntegrator, INTEGRATORS[method])
    option.gravity = np.sum(
        np.array([(0.0, 0.0, 0.0), *(e.g for e in scene.all(UniformGravity))]), axis=0
    )
    if is_tuned(method):
        _tune(mujoco, option, scene)


def _tune(mujoco: Any, option: Any, scene: Scene) -> None:
    """Sets the solver to round-off accuracy, and disables what the scene does not need."""
    option.density = option.viscosity = 0.0
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.tolerance = option.noslip_tolerance = TOLERANCE
    option.ls_tolerance = 1e-6
    option.iterations = ITERATIONS
    if "friction" in scene.features:
        option.noslip_iterations = NOSLIP
    else:
        option.noslip_iterations = 0
    # Boxes stand and slide with an impratio of 1; spheres roll with LIFTLESS.
    if {"contact:friction", "shape:sphere"} <= scene.features:
        option.impratio = solver.LIFTLESS
    else:
        option.impratio = FRICTION_TO_NORMAL
    for name in (*NEVER, *unneeded(scene)):
        option.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}"))
    option.enableflags = int(mujoco.mjtEnableBit.mjENBL_DIAGEXACT)


def unneeded(scene: Scene) -> tuple[str, ...]:
    """Names of the mjtDisableBit flags of what the scene does not have."""
    features = scene.features
    # A slider on a belt is a contact with a body that moves; others are MuJoCo's frictionloss.
    has_belt = "slider:belt" in features
    has_contacts = has_belt or ("contact" in features and scene.has_shapes())
    has_joint_friction = any(not slider.belt_velocity for slider in scene.all(Slider))
    # Without springs and dampers MuJoCo leaves out its callback as well.
    has_callback = any(is_passive(element, scene) for element in scene.elements)
    off = {
        "CONTACT": not has_contacts,
        "CONSTRAINT": not has_contacts and "slider" not in features,
        "FRICTIONLOSS": not has_joint_friction,
        "SPRING": "spring" not in features and not has_callback,
        "DAMPER": "dashpot" not in features,
        "GRAVITY": "uniform_gravity" not in features,
    }
    return tuple(name for name, is_off in off.items() if is_off)
