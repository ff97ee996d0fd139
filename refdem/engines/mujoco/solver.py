"""Parameters of MuJoCo's soft constraints: friction, rigid contact, and the linear contact law in
terms of solref and solimp.
"""

from typing import Any

import numpy as np

from refdem.engines.mujoco.shapes import effective_masses
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact

HARDEST = 0.9999
"""mjMAXIMP: the largest impedance; MuJoCo clamps to it."""
ROUNDING = 2.0**-50
"""Margin at which shapes touch, relative to the size of the scene: a contact of depth 0 would not
act.
"""
SLIDING = 2.0**-10
"""Impedance of sliding contacts. A convex contact law lifts a sliding body off its support (see
`rubbing`), less so the smaller the impedance.
"""
BELT = 2.0**-14
"""Impedance of what a belt carries. The velocity of a stick-slip oscillator with steps of 6e-5 s
has an error of 2.4e-4 at 2^-6, 1.4e-5 at 2^-10, where a shorter step no longer helps, 7e-10 at
2^-14, and 1.7e-7 at 2^-18.
"""
LIFTLESS = 2.0**-30
"""impratio of spheres with friction. Friction is then so soft in the first solve that slip does not
lift the sliding body. The lift ends where the acceleration by the normal force is this fraction of
slip/step. Forces have a rounding error of u/impratio, with the unit round-off u: at 2^-40 two runs
that differ by a boost diverge by 2e-10, with this value by 7e-13.
"""
ANY = 0.5
"""Impedance of the linear law; it cancels (see `linear_law`) and halves exactly."""


def stiffest(step: float) -> list[float]:
    """solref (time constant [s], damping ratio): two steps is the shortest time constant that
    MuJoCo's refsafe allows.
    """
    return [2 * step, 1.0]


def impedance(value: float) -> list[float]:
    """solimp that does not depend on the violation."""
    return [value, value, 0.001, 0.5, 2.0]


def linear_law(scene: Scene, law: Contact) -> list[float]:
    """solref in direct form, (-stiffness, -damping) per effective mass [1/s^2, 1/s].

    Contact acceleration a with impedance d obeys `a + d (b v + k r) = (1 - d) a_free`, where direct
    form sets
    `b = damping/d`, `k = stiffness/d` if d is constant (MuJoCo, Modeling chapter, "Solver
    parameters"). With a_free = 0 the d cancels: `m_eff a = -(m_eff damping) v - (m_eff stiffness)
    r`.
    """
    (effective_mass,) = effective_masses(scene)
    return [-law.stiffness / effective_mass, -law.damping / effective_mass]


def linear_rubbing(scene: Scene, law: Contact, step: float) -> dict[str, Any]:
    """Parameters of a pair under the linear law with sliding friction of full size.

    With the tangential regularisation R_t = (1 - d)/d A_n / impratio, slip lifts the sliding body
    (see `rubbing`) while `A_n f_n < impratio b_t |v_t| / mu`. With impratio = LIFTLESS this holds
    only for negligible forces f_n, so that the normal force is that of the linear law. The
    post-solver has no R_t. It takes the normal force as given, and either stops the slip within a
    step (b_t = 1/step) or limits friction to mu f_n.
    """
    # Direct form: MuJoCo divides by the impedance, so that b_t = (ANY/step)/ANY = 1/step; the
    # stiffness is negligible.
    tangential = [-np.finfo(float).tiny, -ANY / step]
    return {
        "condim": 3,
        "friction": _coulomb(law.friction),
        "solref": linear_law(scene, law),
        "solimp": impedance(ANY),
        "solreffriction": tangential,
    }


def _coulomb(friction: float) -> tuple[float, ...]:
    """The five coefficients of a pair: both tangents have the same, torsion and rolling none."""
    return friction, friction, 0.0, 0.0, 0.0


def rubbing(friction: float, step: float, size: float, soft: float = SLIDING) -> dict[str, Any]:
    """Parameters of a pair of impedance `soft` that slides or sticks, in direct form: its depth is
    a critically damped oscillator of rate 1/(2 step), r'' + r'/step + r/(4 step^2) = 0.

    MuJoCo minimises one cost of normal and tangential residuals, so that slip at v_t also pushes
    along the normal, until `a_n + b v_n + k r = mu |a_t + b_t v_t|` less a term that grows as the
    impedance d decreases. With d near 1 a sliding body therefore leaves the ground at mu v_t and
    hops, however short the step. In direct form MuJoCo takes b and k as the given values divided by
    d, and the depth obeys d b and d k. Hence with a small d only b_t can be 1/step: a sliding body
    stays in contact, and friction is mu times the normal force. A sticking body comes to rest
    within a step, because the post-solver removes the softness of friction.
    """
    normal = [-1 / (4 * step**2), -1 / step]
    tangential = [-np.finfo(float).tiny, -soft / step]
    return {
        "condim": 3,
        "friction": _coulomb(friction),
        "solref": normal,
        "solimp": impedance(soft),
        "solreffriction": tangential,
        "margin": ROUNDING * size,
    }


def contact(scene: Scene, law: Contact, step: float, size: float) -> dict[str, Any]:
    """Parameters of every geom; as all are equal, MuJoCo's combination rules have no effect."""
    if law.law == "linear":
        return {"condim": 1, "solref": linear_law(scene, law), "solimp": impedance(ANY)}
    sliding = (law.friction, 0.0, 0.0)
    rigid = {"solref": stiffest(step), "solimp": impedance(HARDEST), "margin": ROUNDING * size}
    # condim: the normal alone, or with two tangents.
    dimension = 1
    if law.friction > 0:
        dimension = 3
    return rigid | {"condim": dimension, "friction": sliding}


def friction(step: float) -> dict[str, Any]:
    """solref and solimp of dry friction in a joint, as stiff and as hard as MuJoCo permits.

    A sticking joint then creeps least.
    """
    return {
        "solref_friction": np.array(stiffest(step)),
        "solimp_friction": np.array(impedance(HARDEST)),
    }
