"""What cases of rigid impacts share: parameters of bodies and law, and samples that stay clear of
the impact.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.parameters import Parameter, Parameters
from refdem.scene import Body, Sphere
from refdem.scene.elements.contact import Contact

Array = NDArray[np.float64]
FACTORS = "J = f m R^2: 2/5 solid, 2/3 hollow sphere; 1/2 disc, 1 ring in its plane"
LAW = (
    Parameter(
        name="restitution",
        default="3/4",
        unit="1",
        doc="closing speed after the impact over that before it",
        at_least=0,
        at_most=1,
    ),
    Parameter(
        name="tangential_restitution",
        default="0",
        unit="1",
        doc="part of the slip that friction reverses, if it suffices; 0 stops it",
        at_least=0,
        at_most=1,
    ),
    Parameter(name="friction", default="0", unit="1", doc="Coulomb's coefficient", at_least=0),
)


def contact(p: Parameters) -> Contact:
    """The rigid law of the parameters."""
    return Contact(
        law="rigid",
        restitution=p.restitution,
        tangential_restitution=p.tangential_restitution,
        friction=p.friction,
    )


def sphere(
    *, mass: float, factor: float, radius: float, position: Array, velocity: Array, omega: Array
) -> Body:
    """A sphere whose moments of inertia are factor m R^2."""
    moment = float(factor * mass * radius * radius)
    return Body(
        mass=float(mass),
        inertia=(moment, moment, moment),
        shape=Sphere(radius=float(radius)),
        position=tuple(position.tolist()),
        velocity=tuple(velocity.tolist()),
        omega=tuple(omega.tolist()),
    )


def clear_of(impact_time: float, samples: int) -> float:
    """The duration [s] of about twice the time to the impact, which is then a third of an interval
    after a sample.

    Velocities have no value at the impact itself, so that no sample may be there. Nor may any step
    end there: an engine that looks for contacts at the ends of its steps would be exact by chance.
    A third of an interval is at 1/3 or 2/3 of a step, however often steps are halved.
    """
    before = samples // 2 + 1 / 3
    return impact_time * samples / before
