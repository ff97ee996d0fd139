"""How a rigid cluster is turned and how it turns, seen from its places alone, and clusters whose
start is displaced.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from flint import arb_mat

from refdem.core.truth import Ball
from refdem.truth import rotation
from refdem.truth.balls import arb_of, ball_of, precision
from refdem.truth.closed_forms.rigid_cluster import RigidCluster

BITS = 400
INSTANT = Fraction(1, 10**8)
"""The time between two looks in units of 1/|omega|: what is not straight in it is lost."""
AXES = "xyz"


def arms(places: Mapping[str, Ball]) -> arb_mat:
    """The arms from the fourth point to the other three, as columns."""
    return arb_mat(
        [
            [
                arb_of(places[f"r{point}.{axis}"].mid - places[f"r4.{axis}"].mid)
                for point in (1, 2, 3)
            ]
            for axis in AXES
        ]
    )


@dataclass(frozen=True)
class SeenCluster:
    """The attitude, and omega in body axes and in space, of a cluster whose places are certified.

    The attitude is the turn from the places of `reference`, a cluster that is not displaced.
    """

    truth: Any
    reference: Any

    def at(self, t: Fraction) -> Mapping[str, Ball]:
        """Attitude and omega [rad/s] at a time, from the places there and at two times soon
        after.
        """
        instant = INSTANT / self.truth.scale["omega.x"]
        with precision(BITS):
            at_start = arms(self.reference.at(Fraction(0)))
            now, soon, later = (arms(self.truth.at(t + k * instant)) for k in range(3))
            # The derivative of the parabola through three points: (-3 f0 + 4 f1 - f2)/(2 h).
            rate = (4 * soon - 3 * now - later) / arb_of(2 * instant)
            # The columns of `now` are R times those at the start, and rate = (omega x) now.
            r = (now * at_start.inv()).table()
            swept = (rate * now.inv()).table()
            omega = [swept[2][1], swept[0][2], swept[1][0]]
            omega_body = rotation.applied(rotation.transposed(r), omega)
            found = dict(
                zip((f"attitude.{a}" for a in "wxyz"), rotation.quaternion(r), strict=True)
            )
            found |= {f"omega_body.{a}": w for a, w in zip(AXES, omega_body, strict=True)}
            found |= {f"omega.{a}": w for a, w in zip(AXES, omega, strict=True)}
            return {name: ball_of(value) for name, value in found.items()}


def exactly_turned(vector: Sequence[Fraction], by: Sequence[Fraction]) -> tuple[Fraction, ...]:
    """A vector turned by the unit quaternion along (1, by/2), which is rational as a matrix."""
    half = [x / 2 for x in by]
    square = sum(x * x for x in half)
    along = sum(x * y for x, y in zip(half, vector, strict=True))
    across = rotation.cross(half, vector)
    # ((1 - u.u) v + 2 (u.v) u + 2 u x v)/(1 + u.u), with u = by/2.
    return tuple(
        ((1 - square) * v + 2 * along * u + 2 * w) / (1 + square)
        for v, u, w in zip(vector, half, across, strict=True)
    )


def displaced_cluster(truth: RigidCluster, by: Sequence[Fraction]) -> RigidCluster:
    """The cluster that at the start is turned by the first three numbers [rad], and spins faster by
    the others in scales of omega, in axes fixed to it.
    """
    rate = truth.scale["omega.x"]
    places = [exactly_turned(place, by[:3]) for place in truth.places]
    faster = [w + part * rate for w, part in zip(truth.omega, by[3:], strict=True)]
    omega = exactly_turned(faster, by[:3])
    return replace(truth, places=places, omega=omega)
