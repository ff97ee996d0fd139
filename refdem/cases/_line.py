"""What the oscillators on a line share: a mass m on a spring k to the origin, with x and v along
the x axis; w0 = sqrt(k/m).
"""

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
    """Scales of the free motion about the equilibrium x = `shift` [m]; T = 20 tau.

    tau = 1/w0 = sqrt(m/k); L = amplitude + |shift|, amplitude^2 = (x0 - shift)^2 + (v0/w0)^2.
    """
    tau = float(np.sqrt(p.mass / p.stiffness))
    amplitude = float(np.hypot(p.x0 - shift, p.v0 * tau))
    return Scales(length=amplitude + abs(shift), tau=tau, duration=20 * tau, mass=p.mass)


def damped_rate(square: float, delta: float) -> float:
    """1/tau [1/s] of x'' + 2 delta x' + w0^2 x = 0: w0, or, above critical damping, the rate of the
    faster decay, delta + sqrt(delta^2 - w0^2); `square` is w0^2 [1/s^2].
    """
    faster_decay = delta + np.sqrt(max(0.0, delta**2 - square))
    return float(max(np.sqrt(square), faster_decay))


def refuse_nothing(length: float, *names: str) -> None:
    """Raises UsageError for a length scale of 0: nothing would ever move.

    `names` is the parameter to blame; x0 and v0 without one.
    """
    if not length > 0:
        if names:
            blamed = f"parameter {names[0]}: got 0"
        else:
            blamed = "parameters x0 and v0: got 0 and 0"
        raise UsageError(f"{blamed}; expected a start at which something moves")


def quantities(s: Scales) -> tuple[Quantity, ...]:
    """The quantities that are judged: position [m] and velocity [m/s]."""
    return (Quantity("x", "m", s.length), Quantity("v", "m/s", s.speed))


def observe(trajectory: Trajectory) -> dict[str, Array]:
    """Position [m] and velocity [m/s] (T,) of body 0 along x."""
    return {"x": trajectory.position[:, 0, 0], "v": trajectory.velocity[:, 0, 0]}
