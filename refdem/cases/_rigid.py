"""What cases of rigid impacts share: parameters of bodies and law, and samples that stay clear of
the impact.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.parameters import Parameter, Parameters
from refdem.core.refinement import HORIZON
from refdem.scene import Body, Sphere
from refdem.scene.elements.contact import Contact

Array = NDArray[np.float64]
FACTORS = "J = f m R^2: 2/5 solid, 2/3 hollow sphere; 1/2 disc, 1 ring in its plane"
INERTIA_FACTOR = Parameter(
    name="inertia_factor",
    default="2/5",
    unit="1",
    doc=FACTORS,
    above=0,
    at_most=1,
)
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


def one_sphere(noun: str) -> tuple[Parameter, ...]:
    """Mass, radius and inertia factor of the only sphere of a case, which its page calls `noun`."""
    return (
        Parameter(name="mass", default="1", unit="kg", doc=f"of the {noun}", above=0),
        Parameter(name="radius", default="1/2", unit="m", doc=f"of the {noun}", above=0),
        INERTIA_FACTOR,
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
    end there: an engine that detects contacts at the ends of its steps would be exact by chance. A
    third of an interval is at 1/3 or 2/3 of a step, however often steps are halved.
    """
    before = samples // 2 + 1 / 3
    return impact_time * samples / before


TRIED = 2000
"""Number of durations from which `clear_of_all` selects the best one."""
FINEST = 6
"""Number of halvings of the interval whose step grids `clear_of_all` considers."""


def clear_of_all(impact_times: Array, samples: int, *, least: float, most: float) -> float:
    """The duration [s] between `least` and `most` at which samples are clearest of the impacts, at
    times (n,) [s].

    A method that looks for contacts at the ends of its steps is late by up to a step, so that
    samples shortly after an impact show the velocities of before: those shall come late in the
    interval. No impact shall be at a sample, where velocities have no value, nor at the end of a
    step, where such a method would be exact by chance.
    """
    durations = np.linspace(least, most, TRIED)
    # The part of an interval by which each impact comes after a sample, (durations, n).
    past = np.modf(impact_times * samples / durations[:, None])[0]
    clearance = np.minimum(1.0 - past, 4.0 * past)
    for halvings in range(1, FINEST + 1):
        of_step = np.modf(past * 2.0**halvings)[0]
        off_grid = np.minimum(of_step, 1.0 - of_step)
        clearance = np.minimum(clearance, 4.0 * off_grid)
    best = int(clearance.min(axis=1).argmax())
    return float(durations[best])


SHORTER = 0.875
"""The factor by which `shortest_time` makes tau shorter until it is short enough."""


def shortest_time(impact_times: Array, allowed: Array, longest: float) -> float:
    """The time tau [s], at most `longest`, with which impacts at times (n,) [s] are seen late by
    less than is `allowed` (n,) [s] for each, wherever a sample is scored.

    A method that looks for contacts at the ends of its steps h is late by up to h in each impact,
    and by k h in the k-th of a chain. A sample at t is scored where (1 + t/tau) (h/tau) S <= 0.1,
    and S >= 1 + t/tau of free flight, so that

        k h <= 0.1 k tau/(1 + t/tau)^2.
    """
    numbers = np.arange(1, len(impact_times) + 1)
    tau = longest
    while np.any(HORIZON * numbers * tau > allowed * (1.0 + impact_times / tau) ** 2):
        tau *= SHORTER
    return tau
