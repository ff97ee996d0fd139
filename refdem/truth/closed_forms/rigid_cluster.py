"""Certified rigid cluster: points r_i = c + R(t) (r_i(0) - c), R the free rigid body's turn in the
cluster's principal axes.

The tensor of inertia of exact points is rational; its principal moments are roots of its
characteristic polynomial, isolated with their multiplicities, its axes cross products of rows of J
- lambda. Where moments are equal, J1 = J1 != J3 about the unit vector e, R = exp(t L/J1) exp(t
  (omega.e)(1 - J3/J1) e) needs no axes across e (Landau and Lifshitz, Mechanics, section 33).
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import lcm
from typing import Any

from flint import arb, fmpz_poly

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth import rotation
from refdem.truth.balls import UndecidedError, arb_of, precision
from refdem.truth.body_growth import diagonal, steady_growth, tumbling_growth
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.closed_forms.free_rigid_body import ATTITUDE, BODY_OMEGA, OMEGA, Turning
from refdem.truth.exact import vector
from refdem.truth.free_body import (
    Elliptic,
    FreeBody,
    Separatrix,
    Steady,
    dot_exact,
    length_of,
    steady_lead,
)
from refdem.truth.growth import CLOSED_BITS, Grows, Times
from refdem.truth.refiner import FIRST_BITS, Refiner, Sensitivity, Size

WITNESS = (
    "multiprecision integration of q' = q omega/2 with L kept, in axes that are not principal"
    " (refdem/truth/witnesses/linked.py)"
)
Vector = tuple[Fraction, ...]
AXES = (0, 1, 2)
NONE: Vector = (Fraction(0),) * 3


class AboutAxis(FreeBody):
    """Two equal moments `across` (rational) and `along` the unit vector e, in any axes; three equal
    ones are the same.
    """

    method = "two equal moments: one turn about L after one about the body's own axis"

    def __init__(self, across: arb, along: arb, e: Sequence[arb], omega: Sequence[arb]) -> None:
        self.axis, self.start = list(e), tuple(omega)
        about = rotation.dot(self.start, self.axis)
        momentum = [
            across * w + (along - across) * about * x
            for w, x in zip(self.start, self.axis, strict=True)
        ]
        self.length = rotation.dot(momentum, momentum).sqrt()
        self.along = [m / self.length for m in momentum]
        self.across = across
        self.rate = about * (1 - along / across)
        self.moment, self.twice_energy = along, rotation.dot(momentum, self.start)

    def omega(self, t: arb) -> list[arb]:
        return rotation.applied(
            rotation.matrix(rotation.turn(self.axis, -self.rate * t)), self.start
        )

    def turn(self, t: arb) -> list[arb]:
        return rotation.times(
            rotation.turn(self.along, self.length / self.across * t),
            rotation.turn(self.axis, self.rate * t),
        )

    def constants(self) -> dict[str, arb]:
        return {"period": 2 * arb.pi() / abs(self.rate)}

    def fastest(self) -> arb:
        """The largest |omega| [rad/s], which stays."""
        return length_of(self.start)

    def lead(self, t: arb) -> arb:
        square = rotation.dot(self.start, self.start)
        return steady_lead(self.moment, self.twice_energy, self.length, square) * t


class RigidCluster(ClosedForm, Turning):
    """r1.x .. r4.z of points whose centre rests; the start is exact, `shift` is added to omega in
    principal axes.

    S: that of the body (its turn moves a point by at most L), times J3/J1, by which the same change
    of a velocity may change omega the more, plus once more for the centre of mass, whose way grows
    no faster than a turn.
    """

    witness = WITNESS
    state = BODY_OMEGA
    proof_of_s = Sensitivity(CLOSED_BITS)

    def __init__(
        self,
        masses: Vector,
        places: Sequence[Vector],
        omega: Vector,
        scale: Mapping[str, Size],
        shift: Vector = NONE,
    ) -> None:
        self.refiner = Refiner.of(scale)
        self.masses = masses
        self.places = places
        self.omega = omega
        self.shift = shift
        whole = sum(masses, Fraction(0))
        self.centre = [dot_exact(masses, [r[i] for r in places]) / whole for i in AXES]
        self.arms = [[r[i] - self.centre[i] for i in AXES] for r in places]
        square = sum(
            (m * dot_exact(r, r) for m, r in zip(masses, self.arms, strict=True)), Fraction(0)
        )
        self.tensor = [
            [
                (square if i == j else 0)
                - sum(m * r[i] * r[j] for m, r in zip(masses, self.arms, strict=True))
                for j in AXES
            ]
            for i in AXES
        ]
        self.method = (
            f"closed form in Arb balls; {self.form().method}, in principal axes that are isolated"
            " roots"
        )

    def form(self) -> type[FreeBody]:
        """Which closed form it is: at the lowest precision at which balls tell; raises
        NotCertifiedError if none does.
        """
        for bits in (FIRST_BITS << n for n in range(7)):
            with precision(bits):
                try:
                    return type(self.body())
                except UndecidedError:
                    continue
        told = (
            "separatrix: balls cannot decide about which principal axis the cluster turns; move its"
            " spin off the boundary"
        )
        raise NotCertifiedError(told, code="separatrix", time=0.0)

    @per_precision
    def moments(self) -> list[tuple[arb, int]]:
        """Principal moments, smallest first, with their multiplicities."""
        a, b, c = self.tensor
        trace = a[0] + b[1] + c[2]
        minors = a[0] * b[1] - a[1] * b[0] + a[0] * c[2] - a[2] * c[0] + b[1] * c[2] - b[2] * c[1]
        coefficients = [-dot_exact(a, cross(b, c)), minors, -trace, Fraction(1)]
        common = lcm(*(x.denominator for x in coefficients))
        roots: Any = fmpz_poly([int(x * common) for x in coefficients]).complex_roots()
        return sorted(
            ((root.real, count) for root, count in roots), key=lambda pair: float(pair[0].mid())
        )

    def axis(self, moment: arb) -> list[arb]:
        """The unit vector of a moment that occurs once: the largest cross product of two rows of J
        - lambda.
        """
        rows = [[arb_of(self.tensor[i][j]) - (moment if i == j else 0) for j in AXES] for i in AXES]
        found = [rotation.cross(rows[i], rows[j]) for i, j in ((0, 1), (0, 2), (1, 2))]
        best = max(found, key=lambda v: float(rotation.dot(v, v).mid()))
        size = rotation.dot(best, best).sqrt()
        return [x / size for x in best]

    @per_precision
    def axes(self) -> list[list[arb]]:
        """Rows: right-handed unit vectors of the axes in which the body is told; those of space
        where moments are equal.
        """
        if len(self.moments()) < 3:
            return [[arb(int(i == j)) for j in AXES] for i in AXES]
        first, second = (self.axis(moment) for moment, _ in self.moments()[:2])
        return [first, second, rotation.cross(first, second)]

    @property
    def is_steady(self) -> bool:
        """Whether the momentum is along omega, but for the shift."""
        momentum = [dot_exact(row, self.omega) for row in self.tensor]
        return not any(cross(momentum, self.omega))

    @per_precision
    def body(self) -> FreeBody:
        """The motion of the free body in its principal axes."""
        omega = [arb_of(w) for w in self.omega]
        moments = [moment for moment, _ in self.moments()]
        momentum = [dot_exact(row, self.omega) for row in self.tensor]
        energy2 = dot_exact(momentum, self.omega)
        momentum2 = dot_exact(momentum, momentum)
        steady = self.is_steady
        at_rest = not any(self.shift)
        if len(moments) < 3:
            once = next((moment for moment, count in self.moments() if count == 1), moments[0])
            twice = next(moment for moment, count in self.moments() if count > 1)
            if len(moments) == 2:
                e = self.axis(once)
            else:
                e = [arb(0), arb(0), arb(1)]
            return AboutAxis(
                twice, once, e, [w + arb_of(s) for w, s in zip(omega, self.shift, strict=True)]
            )
        turned = rotation.applied(self.axes(), omega)
        if steady:
            k = min(
                AXES,
                key=lambda i: abs(
                    float(moments[i].mid()) - float(energy2 / dot_exact(self.omega, self.omega))
                ),
            )
            turned = [w if i == k else arb(0) for i, w in enumerate(turned)]
        shifted: Any = tuple(w + arb_of(s) for w, s in zip(turned, self.shift, strict=True))
        three: Any = tuple(moments)
        if steady and not any(s for i, s in enumerate(self.shift) if i != k):
            return Steady(three, shifted)
        on_it = (
            at_rest
            and self.characteristic(momentum2 / energy2) == 0
            and moments[1].contains(arb_of(momentum2 / energy2).mid())
        )
        return (Separatrix if on_it else Elliptic)(three, shifted)

    def characteristic(self, value: Fraction) -> Fraction:
        """det(J - value), exact: 0 for L^2/(2E) on the separatrix."""
        a, b, c = (
            [x - (value if i == j else 0) for j, x in enumerate(row)]
            for i, row in enumerate(self.tensor)
        )
        found: Fraction = dot_exact(a, cross(b, c))
        return found

    @per_precision
    def start(self) -> list[arb]:
        return rotation.quaternion(rotation.transposed(self.axes()))

    def spin(self, t: arb) -> list[arb]:
        return self.body().omega(t)

    def evaluate(self, t: arb) -> dict[str, arb]:
        turn = rotation.matrix(rotation.times(self.turned(t), rotation.conjugate(self.start())))
        found: dict[str, arb] = {}
        for number, arm in enumerate(self.arms):
            away = rotation.applied(turn, [arb_of(x) for x in arm])
            found |= {
                f"r{number + 1}.{axis}": arb_of(c) + x
                for axis, c, x in zip("xyz", self.centre, away, strict=True)
            }
        return found

    def displaced(self, axis: int, amount: Fraction) -> "RigidCluster":
        shift = tuple(s + (amount if i == axis else 0) for i, s in enumerate(self.shift))
        return RigidCluster(self.masses, self.places, self.omega, self.scale, shift)

    @per_precision
    def growth(self) -> Grows:
        moments = [moment for moment, _ in self.moments()]
        turn = self.scale["attitude.w"]
        spin = self.scale["omega.x"]
        if self.is_steady:
            body = steady_growth(self.tensor, self.omega, turn, spin, self.in_own_axes)
        elif len(moments) < 3:
            tensor = [[arb_of(x) for x in row] for row in self.tensor]
            body = tumbling_growth(tensor, self.body(), turn, spin, self.in_own_axes)
        else:
            body = tumbling_growth(diagonal(moments), self.body(), turn, spin, self.turned)
        return Times(body, 1 + moments[-1] / moments[0])

    def in_own_axes(self, t: arb) -> list[arb]:
        """The turn since the start, in the axes of space in which the places are given."""
        return rotation.times(self.turned(t), rotation.conjugate(self.start()))


def cross(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """The cross product a x b of exact vectors (3)."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def truth(p: Parameters, scale: Mapping[str, float], rate: float) -> Truth:
    """The truth at these parameters (masses, positions, omega).

    `rate` [rad/s] is the scale of omega.
    """
    flat = vector(p, "positions")
    places = [flat[k : k + 3] for k in range(0, 12, 3)]
    sizes = {**scale, **dict.fromkeys((*BODY_OMEGA, *OMEGA), rate), **dict.fromkeys(ATTITUDE, 1.0)}
    return RigidCluster(vector(p, "masses"), places, vector(p, "omega"), sizes)
