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


"""Of theta1, theta2 (continuous) and their rates."""
WITNESS = (
    "multiprecision integration of Cartesian equations with the rods' forces"
    " (refdem/truth/witnesses/linked.py); energy"
)


def field(p: Parameters) -> Field:
    """The rates of the four numbers."""
    (m1, m2), (l1, l2), g = vector(p, "masses"), vector(p, "lengths"), number(p, "gravity")
    whole = m1 + m2

    def rates(y: Sequence[Any]) -> Sequence[Any]:
        a, b, v, w = y
        sine = (a - b).sin()
        cosine = (a - b).cos()
        sa = a.sin()
        sb = b.sin()
        v2 = v * v * l1
        w2 = w * w * l2
        common = sine * sine * m2 + m1
        upper = (sb * cosine * g - sine * (w2 + v2 * cosine)) * m2 - sa * (whole * g)
        lower = ((sa * cosine - sb) * g + v2 * sine) * whole + w2 * sine * cosine * m2
        return v, w, upper / (common * l1), lower / (common * l2)

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
