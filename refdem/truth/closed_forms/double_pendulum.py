"""Certified double pendulum: validated integration of the angles, from Newton's law for both bobs.

With D = th1 - th2, M = m1 + m2 and N = m1 + m2 sin^2 D (eliminating both tensions):

    l1 N th1'' = -M g sin th1 + m2 (g sin th2 cos D - sin D (l2 th2'^2 + l1 th1'^2 cos D)),
    l2 N th2'' = M (g (sin th1 cos D - sin th2) + l1 th1'^2 sin D) + m2 l2 th2'^2 sin D cos D.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
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
    total_mass = m1 + m2

    def rates(y: Sequence[Any]) -> Sequence[Any]:
        theta1, theta2, rate1, rate2 = y
        sin_d = (theta1 - theta2).sin()
        cos_d = (theta1 - theta2).cos()
        sin_1 = theta1.sin()
        sin_2 = theta2.sin()
        # l theta'^2, the centripetal accelerations.
        centripetal1 = rate1 * rate1 * l1
        centripetal2 = rate2 * rate2 * l2
        # N = m1 + m2 sin^2 D.
        n = sin_d * sin_d * m2 + m1
        # N l1 th1'' = right1 and N l2 th2'' = right2, the right-hand sides at the top of this file.
        right1 = (
            sin_2 * cos_d * g - sin_d * (centripetal2 + centripetal1 * cos_d)
        ) * m2 - sin_1 * (total_mass * g)
        right2 = (
            (sin_1 * cos_d - sin_2) * g + centripetal1 * sin_d
        ) * total_mass + centripetal2 * sin_d * cos_d * m2
        return rate1, rate2, right1 / (n * l1), right2 / (n * l2)

    return rates


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at these parameters (masses, lengths, gravity, theta0, thetadot0)."""
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
