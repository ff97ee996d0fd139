"""What the oscillators on a line share: mass on a spring to the origin, x and v."""

import numpy as np
from numpy.typing import NDArray

from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.errors import UsageError
from refdem.scene import Body, Scene
from refdem.scene.element import Element
from refdem.scene.elements.spring import Spring

Array = NDArray[np.float64]

MASS = Parameter(name="mass", default="1", unit="kg", doc="the point mass", above=0)
STIFFNESS = Parameter(name="stiffness", default="1", unit="N/m", doc="the spring", above=0)
DELTA = Parameter(
    name="delta", default="1/10", unit="1/s", doc="damping: half the dashpot per mass", at_least=0
)
START = (
    Parameter(name="x0", default="1", unit="m", doc="place at the start"),
    Parameter(name="v0", default="0", unit="m/s", doc="velocity at the start"),
)


def scene(p: Parameters, *elements: Element) -> Scene:
    """A point on the x axis, a spring of natural length 0 to the origin, and whatever else acts."""
    point = Body(mass=p.mass, position=(p.x0, 0.0, 0.0), velocity=(p.v0, 0.0, 0.0))
    return Scene.of([point], [Spring(a=0, stiffness=p.stiffness), *elements])


def scales(p: Parameters, shift: float = 0.0) -> Scales:
    """tau = sqrt(m/k); the length is the amplitude about `shift` [m], and the shift itself."""
    tau = float(np.sqrt(p.mass / p.stiffness))
    return Scales(
        length=float(np.hypot(p.x0 - shift, p.v0 * tau)) + abs(shift),
        tau=tau,
        duration=20 * tau,
        mass=p.mass,
    )


def damped_rate(square: float, delta: float) -> float:
    """1/tau [1/s]: w0, or above critical damping the rate of the faster decay; `square` is w0^2."""
    return float(max(np.sqrt(square), delta + np.sqrt(max(0.0, delta**2 - square))))


def refuse_nothing(length: float, *names: str) -> None:
    """Raises UsageError if nothing would ever move and there is no length to compare with."""
    if not length > 0:
        if names:
            told = f"parameter {names[0]}: got 0"
        else:
            told = "parameters x0 and v0: got 0 and 0"
        raise UsageError(f"{told}; expected a start at which something moves")


def quantities(s: Scales) -> tuple[Quantity, ...]:
    """The quantities that are judged: place [m] and velocity [m/s]."""
    return (Quantity("x", "m", s.length), Quantity("v", "m/s", s.speed))


def observe(trajectory: Trajectory) -> dict[str, Array]:
    """Position [m] and velocity [m/s] (T,) of body 0 along x."""
    return {"x": trajectory.position[:, 0, 0], "v": trajectory.velocity[:, 0, 0]}
