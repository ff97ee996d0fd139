"""The quantities that are compared, and the scales in which their errors are counted."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Scales:
    """Length L [m], shortest time tau = 1/omega_max [s], duration T [s], and mass [kg] for energies
    and momenta.
    """

    length: float
    tau: float
    duration: float
    mass: float = 1.0

    def __post_init__(self) -> None:
        """numpy's numbers become floats, which records and stores can hold."""
        for name in ("length", "tau", "duration", "mass"):
            object.__setattr__(self, name, float(getattr(self, name)))

    @property
    def speed(self) -> float:
        """The speed scale L / tau [m/s]."""
        return self.length / self.tau

    @property
    def energy(self) -> float:
        """The energy scale m (L/tau)^2 [J]."""
        return self.mass * self.speed**2


@dataclass(frozen=True)
class Quantity:
    """`scale` is the size against which an error counts; an `angle` is compared modulo 2 pi.

    `group` joins the components of an attitude, which are compared together as one rotation.
    """

    name: str
    unit: str
    scale: float
    angle: bool = False
    group: str = ""

    def __post_init__(self) -> None:
        """numpy's number becomes a float, which records and stores can hold."""
        object.__setattr__(self, "scale", float(self.scale))
