"""What the cases of a single spinning body share: parameters, bounds, scene, quantities and their
observation.

J are the principal moments [kg m^2], `omega_body` the angular velocity in principal axes, `omega`
that in space axes, R the rotation matrix from body to space.
"""

from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.errors import UsageError
from refdem.mechanics.quaternion import conjugate, matrix, rotated
from refdem.scene import Body, Scene

Array = NDArray[np.float64]

INERTIA = Parameter(
    name="inertia",
    default="1,2,3",
    unit="kg m^2",
    doc="principal moments of inertia",
    shape=(3,),
    above=0,
)
ATTITUDE = Parameter(
    name="attitude",
    default="1,0,0,0",
    unit="1",
    doc="attitude at the start (w, x, y, z), made unit",
    shape=(4,),
)
MASS = 1.0
"""Nothing moves the centre of mass, so any mass [kg] will do."""


def refuse(p: Parameters) -> None:
    """Raises UsageError for an inertia that no body has, a zero quaternion, or a body that does not
    spin.
    """
    inertia: Any = p["inertia"]
    # J1 <= J2 + J3 for the largest moment: moments are sums of m (y^2 + z^2) and so on.
    if 2 * max(inertia) > sum(inertia):
        raise UsageError(
            f"parameter inertia: got {p.texts()['inertia']}; it violates the triangle inequality:"
            " expected no principal moment to exceed the sum of the other two"
        )
    for name, expected in (
        ("attitude", "a quaternion other than zero"),
        ("omega_body", "a body that spins"),
    ):
        if not any(_exact(p, name)):
            raise UsageError(f"parameter {name}: got {p.texts()[name]}; expected {expected}")


def _exact(p: Parameters, name: str) -> tuple[Fraction, ...]:
    """The exact components of the vector parameter of that name."""
    value: Any = p[name]
    return tuple(value)


def scene(p: Parameters, omega_body: Array) -> Scene:
    """One body at rest at the origin that spins with `omega_body` (3,) [rad/s] about its principal
    axes.
    """
    attitude = p.attitude / np.linalg.norm(p.attitude)
    omega = rotated(attitude, omega_body)
    return Scene.of(
        [Body(mass=MASS, inertia=tuple(p.inertia), attitude=tuple(attitude), omega=tuple(omega))]
    )


def scales(p: Parameters, omega_body: Array) -> Scales:
    """Scales of the rotation: tau = 1/|omega|, L the largest radius of gyration sqrt(J/m), T = 20
    tau.

    m (L/tau)^2 = J omega^2 is then the size of the rotational energy.
    """
    tau = 1.0 / float(np.linalg.norm(omega_body))
    gyration_radius = float(np.sqrt(p.inertia.max() / MASS))
    return Scales(length=gyration_radius, tau=tau, duration=20 * tau, mass=MASS)


def quantities(rate: float) -> tuple[Quantity, ...]:
    """Angular velocity in body and in space axes on the scale `rate` [rad/s]; attitude and R,
    compared as one rotation.
    """
    spins = tuple(
        Quantity(f"{name}.{axis}", "rad/s", rate)
        for name in ("omega_body", "omega")
        for axis in "xyz"
    )
    attitude = tuple(Quantity(f"attitude.{axis}", "1", 1.0, group="attitude") for axis in "wxyz")
    matrix_entries = tuple(
        Quantity(f"R.{row}{column}", "1", 1.0, group="attitude")
        for row in "xyz"
        for column in "xyz"
    )
    return spins + attitude + matrix_entries


def observe(trajectory: Trajectory) -> dict[str, Array]:
    """The quantities of body 0, each (T,): attitude with w >= 0, omega in both axes, R."""
    attitude = trajectory.attitude[:, 0]
    omega = trajectory.omega[:, 0]
    # q and -q are the same attitude.
    positive_w = attitude * np.where(attitude[:, :1] < 0, -1.0, 1.0)
    observed = {f"attitude.{axis}": positive_w[:, i] for i, axis in enumerate("wxyz")}
    # omega_body = q* omega q.
    omega_body = rotated(conjugate(attitude), omega)
    observed |= {f"omega_body.{axis}": omega_body[:, i] for i, axis in enumerate("xyz")}
    observed |= {f"omega.{axis}": omega[:, i] for i, axis in enumerate("xyz")}
    rotation = matrix(attitude)
    for i, row in enumerate("xyz"):
        for j, column in enumerate("xyz"):
            observed[f"R.{row}{column}"] = rotation[:, i, j]
    return observed
