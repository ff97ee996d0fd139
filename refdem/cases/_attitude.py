"""What every case of a single spinning body shares: parameters, bounds, scene, quantities and their
observation.
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
    if 2 * max(inertia) > sum(inertia):
        raise UsageError(
            f"parameter inertia: got {p.texts()['inertia']}; it violates the triangle inequality:"
            " expected no principal moment to exceed the sum of the other two"
        )
    for name, what in (
        ("attitude", "a quaternion other than zero"),
        ("omega_body", "a body that spins"),
    ):
        if not any(_exact(p, name)):
            raise UsageError(f"parameter {name}: got {p.texts()[name]}; expected {what}")


def _exact(p: Parameters, name: str) -> tuple[Fraction, ...]:
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
    """tau = 1/|omega|; the length is the largest radius of gyration, so that m (L/tau)^2 is a
    rotational energy.
    """
    tau = 1.0 / float(np.linalg.norm(omega_body))
    return Scales(
        length=float(np.sqrt(p.inertia.max() / MASS)), tau=tau, duration=20 * tau, mass=MASS
    )


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
    return (
        spins
        + attitude
        + tuple(
            Quantity(f"R.{row}{column}", "1", 1.0, group="attitude")
            for row in "xyz"
            for column in "xyz"
        )
    )


def observe(trajectory: Trajectory) -> dict[str, Array]:
    """The quantities of body 0; the attitude with w >= 0."""
    attitude = trajectory.attitude[:, 0]
    omega = trajectory.omega[:, 0]
    upright = attitude * np.where(attitude[:, :1] < 0, -1.0, 1.0)
    seen = {f"attitude.{axis}": upright[:, i] for i, axis in enumerate("wxyz")}
    for name, vectors in (("omega_body", rotated(conjugate(attitude), omega)), ("omega", omega)):
        seen |= {f"{name}.{axis}": vectors[:, i] for i, axis in enumerate("xyz")}
    turned = matrix(attitude)
    for i, row in enumerate("xyz"):
        for j, column in enumerate("xyz"):
            seen[f"R.{row}{column}"] = turned[:, i, j]
    return seen
