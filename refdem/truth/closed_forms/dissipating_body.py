"""Certified dissipating body: validated integration of J omega' = (J omega) x omega + c (J omega) x
((J omega) x omega).

The axis about which it ends: at |L| = const the energy falls; once it is below that of a turn about
the middle axis, L^2/(2 J2), only the axis of largest inertia is left. A start exactly about an axis
stays there.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.traced_field import Field
from refdem.truth.validated_flow import ValidatedFlow

DOUBLINGS = 12
"""How often the time is doubled until the energy has fallen far enough: the damping may be weak."""
NAMES = ("omega_body.x", "omega_body.y", "omega_body.z")


class DissipatingBody(ValidatedFlow):
    """Angular velocity omega_body [rad/s] of a body with internal damping."""

    witness = (
        "another multiprecision integration, of L in place of omega; |L| is kept, and the energy"
        " falls by c |L x omega|^2"
    )

    def __init__(
        self,
        omega: Sequence[Fraction],
        inertia: Sequence[Fraction],
        damping: Fraction,
        scale: Mapping[str, float],
    ) -> None:
        super().__init__(
            field(inertia, damping),
            list(omega),
            lambda y: dict(zip(NAMES, y, strict=True)),
            scale,
            state=NAMES,
            moved=range(3),
        )
        self.omega = omega
        self.inertia = inertia
        self.damping = damping

    def constants(self) -> dict[str, arb]:
        """`final_axis`, the principal axis (1, 2 or 3) about which the body ends, where that is
        proved.
        """
        about = [i for i in range(3) if self.omega[i]]
        if len(about) == 1:
            return {"final_axis": arb(about[0] + 1)}
        order = sorted(range(3), key=lambda i: self.inertia[i])
        middle, largest = (self.inertia[i] for i in order[1:])
        if middle == largest or not self.damping:
            return {}
        t = Fraction(0)
        for _ in range(DOUBLINGS):
            omega = [self.evaluate(arb_of(t))[name] for name in NAMES]
            pairs = list(zip(omega, self.inertia, strict=True))
            energy, square = (sum((w * w * arb_of(j**n) for w, j in pairs), arb(0)) for n in (1, 2))
            if energy * arb_of(middle) < square:
                return {"final_axis": arb(order[2] + 1)}
            t = 2 * t or Fraction(1, 4) / sum(
                j * abs(w) for w, j in zip(self.omega, self.inertia, strict=True)
            ) * min(self.inertia)
        return {}


def field(inertia: Sequence[Fraction], damping: Fraction) -> Field:
    """The time derivative of omega_body [rad/s^2]."""

    def crossed(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
        return [a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3] for i in range(3)]

    def rates(omega: Sequence[Any]) -> Sequence[Any]:
        momentum = [w * j for w, j in zip(omega, inertia, strict=True)]
        torque = crossed(momentum, omega)
        lost = crossed(momentum, torque)
        return [(a + b * damping) / j for a, b, j in zip(torque, lost, inertia, strict=True)]

    return rates


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters inertia, omega_body, damping."""
    return DissipatingBody(
        vector(p, "omega_body"), vector(p, "inertia"), number(p, "damping"), scale
    )
