"""Certified motion off the intermediate axis: the free rigid body's closed form, started `offset` off its axis."""

from collections.abc import Mapping
from fractions import Fraction
from math import isqrt
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.closed_forms.free_rigid_body import FreeRigidBody, exact_columns
from refdem.truth.free_body import Exact3, dot_exact

SIZE_BITS = 1000
"""Bits after the point to which |omega_body| is taken where it is irrational; that start is exact by definition."""


class IntermediateAxis(FreeRigidBody):
    """A free body; between two flips (sign changes of omega along the intermediate axis) lies half a period."""

    def constants(self) -> dict[str, arb]:
        found = super().constants()
        if len(set(self.inertia)) == 3 and "period" in found:
            found["flip_time"] = found["period"] / 2
        return found


def start(p: Parameters) -> Exact3:
    """omega_body [rad/s] at the start, exact: `omega_body` plus `offset` of its size along the axis `direction`."""
    _, omega, _ = exact_columns(p)
    offset: Any = p["offset"]
    side = int(str(p["direction"])) - 1
    x, y, z = (w + (offset * size(dot_exact(omega, omega)) if i == side else 0) for i, w in enumerate(omega))
    return x, y, z


def size(squared: Fraction) -> Fraction:
    """The square root of a rational: exact if rational, else rounded down to SIZE_BITS bits after the point."""
    top, bottom = isqrt(squared.numerator), isqrt(squared.denominator)
    if top * top == squared.numerator and bottom * bottom == squared.denominator:
        return Fraction(top, bottom)
    return Fraction(isqrt((squared.numerator << 2 * SIZE_BITS) // squared.denominator), 1 << SIZE_BITS)


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at these parameters (inertia, omega_body, attitude, offset, direction)."""
    inertia, _, attitude = exact_columns(p)
    return IntermediateAxis(inertia, start(p), attitude, scale)
