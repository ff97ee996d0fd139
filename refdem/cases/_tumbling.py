"""The box of case neglected-gyroscopic, free or on its slope: parameters, bounds and scene."""

from typing import Any

import numpy as np

from refdem.cases import _attitude
from refdem.cases._attitude import Array
from refdem.core.parameters import Parameter, Parameters
from refdem.errors import UsageError
from refdem.mechanics.quaternion import rotated
from refdem.scene import Body, Scene, box
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

FREE = "free"
SLOPE = "slope"
PARAMETERS = (
    Parameter(name="mass", default="0.12", unit="kg", doc="m", above=0),
    Parameter(name="gravity", default="9.8125", unit="m/s^2", doc="slope alone: along -z", above=0),
    Parameter(
        name="slope",
        default="1/2",
        unit="rad",
        doc="slope alone: its angle; it falls along +x",
        at_least=0,
        at_most=1.5,
    ),
    Parameter(
        name="height",
        default="1/10",
        unit="m",
        doc="slope alone: z of the centre at the start, above the origin",
        above=0,
    ),
    Parameter(
        name="stiffness",
        default="1e5",
        unit="N/m",
        doc="slope alone: of a corner's contact",
        above=0,
    ),
    Parameter(
        name="damping",
        default="4",
        unit="N s/m",
        doc="slope alone: of a corner's contact",
        at_least=0,
    ),
    Parameter(
        name="friction",
        default="1/5",
        unit="1",
        doc="slope alone: of full size against the slip of a corner",
        at_least=0,
    ),
)


def squares(p: Parameters) -> Array:
    """The squared sides (3,) [m^2] of the homogeneous box that has this mass and these moments.

    J_x = m/12 (b^2 + c^2) and so on give a^2 = 6 (J_x + J_y + J_z - 2 J_x)/m.
    """
    squared_sides: Array = 6 * (p.inertia.sum() - 2 * p.inertia) / p.mass
    return squared_sides


def refuse(p: Parameters) -> None:
    """Raises UsageError for values that make no spinning box, or one that starts in the slope."""
    _attitude.refuse(p)
    if p.member == FREE:
        return
    if not squares(p).min() > 0:
        raise UsageError(
            f"parameter inertia: got {p.texts()['inertia']}; expected that of a box: each less than"
            " the sum of the others"
        )
    # The distance of the centre from the slope against half the diagonal of the box.
    if not p.height * np.cos(p.slope) > np.sqrt(squares(p).sum()) / 2:
        raise UsageError(
            f"parameter height: got {p.height:g} m; expected a box above the slope, however it is"
            " turned"
        )


def scene(p: Parameters) -> Scene:
    """The box, alone at the origin, or above a slope through the origin.

    On the slope there is a linear contact at its corners, which ends once its force would pull.
    """
    attitude = p.attitude / np.linalg.norm(p.attitude)
    state: dict[str, Any] = {
        "velocity": tuple(p.velocity),
        "attitude": tuple(attitude),
        "omega": tuple(rotated(attitude, p.omega_body)),
    }
    if p.member == FREE:
        return Scene.of([Body(mass=p.mass, inertia=tuple(p.inertia), **state)])
    shape = box(*np.sqrt(squares(p)).tolist())
    body = Body(
        mass=p.mass, inertia=tuple(p.inertia), position=(0.0, 0.0, p.height), shape=shape, **state
    )
    law = {name: getattr(p, name) for name in ("stiffness", "damping", "friction")}
    contact = Contact(law="linear", branch="R", cutoff="zero_force", **law)
    plane = Plane(normal=(float(np.sin(p.slope)), 0.0, float(np.cos(p.slope))))
    return Scene.of([body], [plane, UniformGravity(g=(0.0, 0.0, -p.gravity)), contact])
