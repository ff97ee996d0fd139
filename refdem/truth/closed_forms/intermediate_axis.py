"""Certified motion off the intermediate axis: the free rigid body's closed form, started `offset`
off its axis.
"""

from collections.abc import Mapping
from typing import Any

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.closed_forms.free_rigid_body import FreeRigidBody, exact_columns
from refdem.truth.free_body import Exact3, dot_exact
from refdem.truth.reals import root
from refdem.truth.refiner import Refiner


def start(p: Parameters) -> Exact3:
    """omega_body [rad/s] at the start: `omega_body` plus `offset` of its size, which may be
    irrational, along the axis `direction`.
    """
    _, omega, _ = exact_columns(p)
    offset: Any = p["offset"]
    side = int(str(p["direction"])) - 1
    size = root(dot_exact(omega, omega))
    # omega(0) = omega_body + offset |omega_body| e, with the unit vector e of the axis.
    x, y, z = (w + (offset * size if i == side else 0) for i, w in enumerate(omega))
    return x, y, z


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at these parameters (inertia, omega_body, attitude, offset, direction)."""
    inertia, _, attitude = exact_columns(p)
    return FreeRigidBody(Refiner.of(scale), inertia, start(p), attitude, counts_flips=True)
