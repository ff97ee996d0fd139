"""How hard MuJoCo's constraints are set: friction, rigid contact, and the linear contact law in its own terms."""

from typing import Any

import numpy as np

from refdem.engines.mujoco.shapes import pairs
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact

HARDEST = 0.9999
"""mjMAXIMP: the largest impedance; MuJoCo clamps to it."""
ANY = 0.5
"""Impedance of the linear law; it cancels (see `linear_law`) and halves exactly."""


def stiffest(step: float) -> list[float]:
    """solref (time constant [s], damping ratio): two steps is the shortest time constant that MuJoCo's refsafe allows."""
    return [2 * step, 1.0]


def impedance(value: float) -> list[float]:
    """solimp that does not depend on the violation."""
    return [value, value, 0.001, 0.5, 2.0]


def linear_law(scene: Scene, law: Contact) -> list[float]:
    """solref in direct form, (-stiffness, -damping) per effective mass [1/s^2, 1/s].

    Contact acceleration a with impedance d obeys `a + d (b v + k r) = (1 - d) a_free`, where direct form sets
    `b = damping/d`, `k = stiffness/d` if d is constant (MuJoCo, Modeling chapter, "Solver parameters"). With a_free = 0
    the d cancels: `m_eff a = -(m_eff damping) v - (m_eff stiffness) r`.
    """
    (effective_mass,) = pairs(scene)
    return [-law.stiffness / effective_mass, -law.damping / effective_mass]


def contact(scene: Scene, law: Contact, step: float) -> dict[str, Any]:
    """Parameters of every geom: all alike, so that MuJoCo's rules of combination change nothing."""
    if law.law == "linear":
        return {"condim": 1, "solref": linear_law(scene, law), "solimp": impedance(ANY)}
    sliding = (law.friction, 0.0, 0.0)
    return {"condim": 3 if law.friction > 0 else 1, "friction": sliding, "solref": stiffest(step), "solimp": impedance(HARDEST)}


def friction(step: float) -> dict[str, Any]:
    """Parameters of dry friction in a joint."""
    return {"solref_friction": np.array(stiffest(step)), "solimp_friction": np.array(impedance(HARDEST))}
