"""The numbers of a force as compiled callbacks read them: a row an element, in the order of
`kernels/force_rows.h`.
"""

from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.spring import Spring

(DRIVE, SPRING, DASHPOT, CENTRAL, PIECEWISE) = range(5)
"""Kinds of forces, as the compiled callbacks number them."""
NUMBERS = 10
"""Columns of a table of rows; a row fills the first of them."""
Row = tuple[float, ...]
Field = CentralField | PiecewiseField
"""What acts on every body."""
Push = Force | Spring | Dashpot | RotatingDashpot
"""What acts on one body, or on two."""


def kind_of(element: Field | Push) -> int:
    """The number of the element's kind, DRIVE to PIECEWISE."""
    kinds = {
        Force: DRIVE,
        Spring: SPRING,
        Dashpot: DASHPOT,
        RotatingDashpot: DASHPOT,
        CentralField: CENTRAL,
        PiecewiseField: PIECEWISE,
    }
    return kinds[type(element)]


def row_of(element: Field | Push, mass: float = 1.0) -> Row:
    """The row of an element, for a body of that mass [kg], which only a central field needs."""
    if isinstance(element, Force):
        return (element.amplitude, element.frequency, element.phase, *element.axis)
    if isinstance(element, Spring):
        numbers = (element.stiffness, element.length, element.exponent, *element.anchor_b)
        return (*numbers, element.quadratic, element.cubic)
    if isinstance(element, Dashpot):
        at_rest = (0.0, 0.0, 0.0)
        return (element.damping, element.van_der_pol, *element.anchor_b, *at_rest)
    if isinstance(element, RotatingDashpot):
        return (element.damping, 0.0, *element.anchor_b, *element.rate)
    if isinstance(element, CentralField):
        return (element.gm * mass,)
    return (element.k1, element.k2, element.x1, element.x2, *element.point, *element.axis)
