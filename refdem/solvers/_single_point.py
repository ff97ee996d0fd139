"""Queries of scenes with one point in a field or on one link, which several methods share."""

from math import inf, log2

import numpy as np
from numpy.typing import NDArray

from refdem.scene import Scene
from refdem.scene.element import Link
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]
ORDINARY = 2.0**20
"""Seconds, 12 days: motions with times up to this, and down to its inverse (a microsecond), are
computed in seconds.
"""


def gravity(scene: Scene) -> Array:
    """Sum of all uniform gravity fields (3,) [m/s^2]."""
    fields = [np.asarray(field.g, float) for field in scene.all(UniformGravity)]
    together: Array = np.sum([np.zeros(3), *fields], axis=0)
    return together


def turning(scene: Scene) -> str | None:
    """None if no body rotates and every link is attached at a body's centre, else the reason."""
    if "rotation" in scene.features:
        return "rotation is coupled to the motion"
    for link in scene.all(Link):
        if any(link.anchor_a) or (link.b >= 0 and any(link.anchor_b)):
            return "a link is off a body's centre"
    return None


def is_linear(spring: Spring) -> bool:
    """True if the spring's force is proportional to its stretch."""
    return spring.exponent == 1 and not spring.quadratic and not spring.cubic


def time_unit(times: list[float]) -> float:
    """A power of two [s] near the shortest of the times of a motion; 1 if that lies between a
    microsecond and 12 days.

    The n-th coefficient of a Taylor series in seconds scales as t^-n: at order 20, times below
    1e-15 s or above 1e15 s leave the range of binary64. Scaling by powers of two is exact.
    """
    finite = [time for time in times if 0.0 < time < inf]
    shortest = min(finite, default=1.0)
    if 1.0 / ORDINARY <= shortest <= ORDINARY:
        return 1.0
    return 2.0 ** round(log2(shortest))


def anchor(link: Link) -> Array:
    """The point (3,) [m] of the world to which the link is attached."""
    return np.array(link.anchor_b, float)
