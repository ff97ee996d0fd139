"""What the methods for one point in a field or on one link share: reasons to refuse, and the
scene's gravity.
"""

from math import inf, log2

import numpy as np
from numpy.typing import NDArray

from refdem.scene import Scene
from refdem.scene.element import Link
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]
ORDINARY = 2.0**20
"""Seconds, 12 days: motions of up to such times, and down to a microsecond, are told in seconds."""


def gravity(scene: Scene) -> Array:
    """Acceleration (3,) [m/s^2] of all uniform fields together."""
    fields = [np.asarray(field.g, float) for field in scene.all(UniformGravity)]
    return np.sum([np.zeros(3), *fields], axis=0)


def turning(scene: Scene) -> str | None:
    """None if every body is a point as far as the motion goes: nothing turns, and no link holds it
    off its centre.
    """
    if "rotation" in scene.features:
        return "rotation is coupled to the motion"
    for link in scene.all(Link):
        if any(link.anchor_a) or (link.b >= 0 and any(link.anchor_b)):
            return "a link is off a body's centre"
    return None


def is_linear(spring: Spring) -> bool:
    """Its force is proportional to its stretch."""
    return spring.exponent == 1 and not spring.quadratic and not spring.cubic


def time_unit(times: list[float]) -> float:
    """A power of two [s] near the shortest of the times of a motion; 1 where that is neither very
    short nor very long.

    The n-th coefficient of a Taylor series in seconds is as t^-n: at order 20, times below 1e-15 s
    or above 1e15 s leave binary64. Multiplied by powers of two, all numbers of a motion keep their
    digits.
    """
    found = [time for time in times if 0.0 < time < inf]
    shortest = min(found, default=1.0)
    if 1.0 / ORDINARY <= shortest <= ORDINARY:
        return 1.0
    return 2.0 ** round(log2(shortest))


def anchor(link: Link) -> Array:
    """Where the link meets the world (3,) [m]."""
    return np.array(link.anchor_b, float)
