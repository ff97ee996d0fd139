"""Certified dissipating body: validated integration of J omega' = (J omega) x omega + c (J omega) x
((J omega) x omega).

The final axis of rotation: |L| is constant and the energy decreases. Once the energy is below that
of the rotation about the middle axis, L^2/(2 J2), the rotation about the axis of the largest moment
is the only possible limit. A rotation exactly about a principal axis is stationary.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.traced_field import Field
from refdem.truth.validated_flow import ValidatedFlow
from refdem.truth.vectors import cross

DOUBLINGS = 12
"""How often the time is doubled in the search for a low enough energy: the damping may be weak."""
NAMES = ("omega_body.x", "omega_body.y", "omega_body.z")


WITNESS = (
    "another multiprecision integration, of L in place of omega; |L| is kept, and the energy falls"
    " by c |L x omega|^2"
)


def final_axis(
    omega: Sequence[Fraction], inertia: Sequence[Fraction], damping: Fraction, flow: ValidatedFlow
) -> dict[str, arb]:
    """The scalar `final_axis`: the principal axis (1, 2 or 3) of the rotation for t to infinity.

    It is the axis of a start exactly about a principal axis. Otherwise it is the axis of the
    largest moment, if 2 E < L^2/J_middle is proved at one of the times t, 2 t, 4 t, ...; if not,
    there is no such scalar.
    """
    started_about = [i for i in range(3) if omega[i]]
    if len(started_about) == 1:
        return {"final_axis": arb(started_about[0] + 1)}
    order = sorted(range(3), key=lambda i: inertia[i])
    middle, largest = (inertia[i] for i in order[1:])
    if middle == largest or not damping:
        return {}
    t = Fraction(0)
    for _ in range(DOUBLINGS):
        values = flow.evaluate(arb_of(t))
        pairs = [(values[name], j) for name, j in zip(NAMES, inertia, strict=True)]
        # 2 E = sum J w^2 and L^2 = sum (J w)^2; about the middle axis 2 E J2 = L^2.
        double_energy = sum((w * w * arb_of(j) for w, j in pairs), arb(0))
        momentum_square = sum((w * w * arb_of(j**2) for w, j in pairs), arb(0))
        # 2 E < L^2/J2.
        if double_energy * arb_of(middle) < momentum_square:
            return {"final_axis": arb(order[2] + 1)}
        # The first time is 0, the second `first_time`, and each later one twice the one before.
        t = 2 * t or first_time(omega, inertia)
    return {}


def first_time(omega: Sequence[Fraction], inertia: Sequence[Fraction]) -> Fraction:
    """About a quarter of the time of a turn by 1 rad [s]: min J over the sum of |J w|, over 4."""
    # |L| <= sum |J_i w_i|, and a rate of turning is at most |L|/min J.
    momentum = sum(j * abs(w) for w, j in zip(omega, inertia, strict=True))
    return Fraction(1, 4) / momentum * min(inertia)


def field(inertia: Sequence[Fraction], damping: Fraction) -> Field:
    """The field of omega_body: J omega' = L x omega + c L x (L x omega) with L = J omega."""

    def rates(omega: Sequence[Any]) -> Sequence[Any]:
        # J omega' = L x omega + c L x (L x omega)
        momentum = [w * j for w, j in zip(omega, inertia, strict=True)]
        gyroscopic = cross(momentum, omega)
        dissipative = cross(momentum, gyroscopic)
        return [
            (a + b * damping) / j for a, b, j in zip(gyroscopic, dissipative, inertia, strict=True)
        ]

    return rates


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters inertia, omega_body, damping: omega_body [rad/s]."""
    omega = vector(p, "omega_body")
    inertia = vector(p, "inertia")
    damping = number(p, "damping")
    return ValidatedFlow(
        field(inertia, damping),
        list(omega),
        lambda y: dict(zip(NAMES, y, strict=True)),
        scale,
        state=NAMES,
        moved=range(3),
        witness=WITNESS,
        constants=partial(final_axis, omega, inertia, damping),
    )
