"""Certified coupled pendulums: validated integration of the angles, from the torques on both rods.

With the vector D = r2 - r1 of the spring, its length s = |D|, and the tangents t = (cos th, sin th)
of the circles on which the bobs move:

    l1 th1'' = -g sin th1 + (k/m1) (1 - s0/s) D . t1,
    l2 th2'' = -g sin th2 - (k/m2) (1 - s0/s) D . t2.

A spring of length s0 = 0 without force pulls with k D, and s does not enter.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.dual import stays_zero
from refdem.truth.exact import number, vector
from refdem.truth.traced_field import Field
from refdem.truth.validated_flow import ValidatedFlow

NAMES = ("theta1", "theta2", "thetadot1", "thetadot2")
"""The state, and the quantities: the angles are continuous."""
WITNESS = (
    "multiprecision integration of Cartesian equations with the rods' forces"
    " (refdem/truth/witnesses/linked.py); energy"
)


def field(p: Parameters) -> Field:
    """The rates of (th1, th2, th1', th2'), by the equations above."""
    m1, m2 = vector(p, "masses")
    l1, l2 = vector(p, "lengths")
    g = number(p, "gravity")
    distance = number(p, "distance")
    stiffness = number(p, "stiffness")
    spring_length = number(p, "spring_length")

    def rates(y: Sequence[Any]) -> Sequence[Any]:
        theta1, theta2, rate1, rate2 = y
        sin_1 = theta1.sin()
        cos_1 = theta1.cos()
        sin_2 = theta2.sin()
        cos_2 = theta2.cos()
        # D = (d + l2 sin th2 - l1 sin th1, l1 cos th1 - l2 cos th2).
        spring_x = sin_2 * l2 - sin_1 * l1 + distance
        spring_y = cos_1 * l1 - cos_2 * l2
        # D . t1 and D . t2 with t = (cos th, sin th).
        along_1 = spring_x * cos_1 + spring_y * sin_1
        along_2 = spring_x * cos_2 + spring_y * sin_2
        if not stays_zero(spring_length):
            length = (spring_x * spring_x + spring_y * spring_y).sqrt()
            # The force over the length of the spring, in units of k: F/(k s) = 1 - s0/s.
            share = 1 - spring_length / length
            along_1 = along_1 * share
            along_2 = along_2 * share
        acceleration1 = along_1 * (stiffness / m1) - sin_1 * g
        acceleration2 = -(along_2 * (stiffness / m2)) - sin_2 * g
        return rate1, rate2, acceleration1 / l1, acceleration2 / l2

    return rates


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at these parameters (masses, lengths, distance, gravity, stiffness, spring_length,
    theta0, thetadot0).
    """
    start = [*vector(p, "theta0"), *vector(p, "thetadot0")]
    return ValidatedFlow(
        field(p),
        start,
        lambda y: dict(zip(NAMES, y, strict=True)),
        scale,
        state=NAMES,
        moved=range(4),
        witness=WITNESS,
    )
