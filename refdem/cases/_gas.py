"""What a gas is: its parameters, how large its box is, what bounds it, and the law by which spheres
meet.
"""

import numpy as np

from refdem.core.parameters import Parameter, Parameters
from refdem.errors import UsageError
from refdem.scene.element import Element
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane

PARAMETERS = (
    Parameter(
        name="n",
        default="100",
        unit="1",
        doc="number of spheres",
        at_least=2,
        at_most=1_000_000,
        whole=True,
    ),
    Parameter(name="diameter", default="1", unit="m", doc="of every sphere", above=0),
    Parameter(
        name="restitution",
        default="9/10",
        unit="1",
        doc="normal velocity after over before",
        at_least=0.1,
        at_most=1,
    ),
    Parameter(
        name="friction", default="0", unit="1", doc="Coulomb's, of every contact", at_least=0
    ),
    Parameter(
        name="density",
        default="1/20",
        unit="1/m^3",
        doc="number of spheres in the volume of the box",
        above=0,
    ),
    Parameter(
        name="boundary",
        default="periodic",
        unit="1",
        doc="of the cube",
        choices=("periodic", "walls"),
    ),
    Parameter(
        name="seed",
        default="1",
        unit="1",
        doc="of the start",
        at_least=0,
        at_most=2**32,
        whole=True,
    ),
    Parameter(name="t0", default="1", unit="J", doc="temperature at the start", above=0),
)


def edge(p: Parameters) -> float:
    """The edge [m] of the cube that holds the gas."""
    return float((p.n / p.density) ** (1 / 3))


def refuse(p: Parameters) -> None:
    """Raises UsageError for a box too full for a gas, or so small that a sphere would meet two
    images of another.
    """
    if p.density * p.diameter**3 > 0.3 or edge(p) < 2.6 * p.diameter:
        told = f"{p.density:g} 1/m^3, {edge(p) / p.diameter:.3g} diameters an edge"
        raise UsageError(
            f"parameter density: got {told}; expected density diameter^3 <= 0.3, and an edge of at"
            " least 2.6 diameters"
        )


def bounds(size: float, *, periodic: bool) -> list[Element]:
    """A periodic box, or six walls that look inwards, at 0 and `size` [m]."""
    if periodic:
        return [PeriodicBox(size=size)]
    walls: list[Element] = []
    for axis in range(3):
        for side, sign in ((0.0, 1.0), (size, -1.0)):
            x, y, z = (sign * (k == axis) for k in range(3))
            walls.append(Plane(point=(side, side, side), normal=(x, y, z)))
    return walls


IN_TUNE = 2 / 7
"""Tangential over normal stiffness: a homogeneous sphere that sticks then swings back sideways in
the time in which it swings back.
"""


def law(mass: float, lasts: float, restitution: float, friction: float = 0.0) -> Contact:
    """Linear contact of two bodies of `mass` [kg] that lasts t_c = `lasts` [s] and gives back e =
    `restitution`.

    k = m_eff (pi^2 + ln^2 e)/t_c^2 and c = -2 m_eff ln e/t_c with m_eff = m/2. At a wall, where
    m_eff is m, e is higher. With friction a tangential spring has 2/7 of m_eff pi^2/t_c^2: spheres
    that never slide give back all of their slip, turned round.
    """
    loss = -float(np.log(restitution))
    k = mass / 2 * (np.pi**2 + loss**2) / lasts**2
    c = mass * loss / lasts
    if friction:
        sideways = IN_TUNE * mass / 2 * float(np.pi / lasts) ** 2
    else:
        sideways = 0.0
    return Contact(
        law="linear", stiffness=k, damping=c, friction=friction, tangential_stiffness=sideways
    )
