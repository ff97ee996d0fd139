"""Physical dimensions as types: a field annotated `Stiffness` carries (mass, length, time)
exponents that tools can read.
"""

from typing import Annotated, NamedTuple


class Dimension(NamedTuple):
    """Exponents of mass [kg], length [m] and time [s]."""

    mass: float
    length: float
    time: float


Number = Annotated[float, Dimension(0, 0, 0)]
Mass = Annotated[float, Dimension(1, 0, 0)]
Length = Annotated[float, Dimension(0, 1, 0)]
Force = Annotated[float, Dimension(1, 1, -2)]
Stiffness = Annotated[float, Dimension(1, 0, -2)]
Damping = Annotated[float, Dimension(1, 0, -1)]
Frequency = Annotated[float, Dimension(0, 0, -1)]
GravityParameter = Annotated[float, Dimension(0, 3, -2)]

Direction = Annotated[tuple[float, float, float], Dimension(0, 0, 0)]
Attitude = Annotated[tuple[float, float, float, float], Dimension(0, 0, 0)]
Position = Annotated[tuple[float, float, float], Dimension(0, 1, 0)]
Velocity = Annotated[tuple[float, float, float], Dimension(0, 1, -1)]
Acceleration = Annotated[tuple[float, float, float], Dimension(0, 1, -2)]
Omega = Annotated[tuple[float, float, float], Dimension(0, 0, -1)]
Inertia = Annotated[tuple[float, float, float], Dimension(1, 2, 0)]
