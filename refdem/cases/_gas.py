"""The granular gas: its parameters, the size and the walls of its box, and the contact law."""

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
        name="contact",
        default="soft",
        unit="1",
        doc="a spring and a dashpot that take time, or rigid impacts that take none",
        choices=("soft", "rigid"),
    ),
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
    Parameter(
        name="gravity",
        default="0",
        unit="m/s^2",
        doc="along -z; with rigid contacts in a periodic box, where the whole gas falls freely",
        at_least=0,
    ),
)


def edge(p: Parameters) -> float:
    """The edge [m] of the cube that holds the gas."""
    return float((p.n / p.density) ** (1 / 3))


def refuse(p: Parameters) -> None:
    """Raises UsageError for a box too full for a gas, or so small that a sphere would touch two
    periodic images of another one, and for gravity on a gas that something holds up.
    """
    edge_in_diameters = edge(p) / p.diameter
    if p.density * p.diameter**3 > 0.3 or edge(p) < 2.6 * p.diameter:
        raise UsageError(
            f"parameter density: got {p.density:g} 1/m^3, {edge_in_diameters:.3g} diameters an"
            " edge; expected density diameter^3 <= 0.3, and an edge of at least 2.6 diameters"
        )
    falls_freely = p.contact == "rigid" and p.boundary == "periodic"
    if p.gravity and not falls_freely:
        raise UsageError(
            f"parameter gravity: got {p.gravity:g} m/s^2 with contact={p.contact} and"
            f" boundary={p.boundary}; expected contact=rigid and boundary=periodic, where the gas"
            " falls freely and its temperature is that without gravity"
        )


def bounds(edge_length: float, *, periodic: bool) -> list[Element]:
    """The boundary of the cube [0, edge_length]^3 [m]: a periodic box, or six walls with inward
    normals.
    """
    if periodic:
        return [PeriodicBox(size=edge_length)]
    walls: list[Element] = []
    for axis in range(3):
        for coordinate, sign in ((0.0, 1.0), (edge_length, -1.0)):
            x, y, z = (sign * (k == axis) for k in range(3))
            point = (coordinate, coordinate, coordinate)
            walls.append(Plane(point=point, normal=(x, y, z)))
    return walls


def rigid_law(restitution: float, friction: float = 0.0) -> Contact:
    """Rigid impacts that return the part `restitution` of the normal velocity; friction stops the
    slip, or takes the coefficient `friction` times the normal impulse.
    """
    return Contact(law="rigid", restitution=restitution, friction=friction)


IN_TUNE = 2 / 7
"""Tangential over normal stiffness at which both springs of a homogeneous sphere that sticks have
the same period: its tangential effective mass is 2/7 of the normal one.
"""


def law(mass: float, contact_time: float, restitution: float, friction: float = 0.0) -> Contact:
    """Linear contact law of two bodies of `mass` [kg] with duration t_c = `contact_time` [s] and
    restitution e.

    k = m_eff (pi^2 + ln^2 e)/t_c^2 and c = -2 m_eff ln e/t_c with m_eff = m/2. At a wall, where
    m_eff is m, e is higher. With friction there is a tangential spring of 2/7 m_eff pi^2/t_c^2, by
    which spheres that never slide leave with their slip reversed.
    """
    loss = -float(np.log(restitution))
    k = mass / 2 * (np.pi**2 + loss**2) / contact_time**2
    c = mass * loss / contact_time
    if friction:
        tangential = IN_TUNE * mass / 2 * float(np.pi / contact_time) ** 2
    else:
        tangential = 0.0
    return Contact(
        law="linear", stiffness=k, damping=c, friction=friction, tangential_stiffness=tangential
    )
