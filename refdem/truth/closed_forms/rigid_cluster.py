"""A rigid cluster of points that rotates freely about its centre of mass, in closed form.

Theorem: r_i = c + R(t) (r_i(0) - c), where the centre c is at rest and R is the rotation of the
free rigid body (free_body.py) whose inertia tensor is J = sum m (r^2 1 - r r^T).

Hypotheses, and where each is checked:

* J is that of exact points, so it is rational; its principal moments are the roots lambda of
  det(J - lambda) = 0, isolated with their multiplicities (`RigidCluster.moments`);
* which formula holds is decided from the exact tensor (`is_steady`, `_is_on_separatrix`); about
  which axis the body turns is decided in ball arithmetic (`form`; otherwise reported as
  `separatrix`).

Formula: the axis of a moment that occurs once is a cross product of two rows of J - lambda; in
these axes the motion is that of free_body.py. If two moments are equal, J1 = J2 != J3, the axes at
right angles to e, the unit vector of the axis of J3, are not determined. The formula

    R = exp(t L/J1) exp(t (omega . e)(1 - J3/J1) e)

does not need them (exp of a vector is the rotation about it by its length; Landau and Lifshitz,
Mechanics, section 33).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Any

from flint import arb, fmpz_poly

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth import rotation
from refdem.truth.balls import UndecidedError, arb_of, precision
from refdem.truth.body_growth import diagonal, steady_growth, tumbling_growth
from refdem.truth.closed_form import ClosedForm, displaced_tuple, per_precision
from refdem.truth.closed_forms.free_rigid_body import (
    ATTITUDE,
    BODY_OMEGA,
    OMEGA,
    attitude_at,
    derivative_of_turning,
)
from refdem.truth.exact import vector
from refdem.truth.free_body import (
    Elliptic,
    FreeBody,
    Principal,
    Separatrix,
    Steady,
    dot_exact,
    length_of,
    steady_lead,
)
from refdem.truth.growth import CLOSED_BITS, Grows
from refdem.truth.refiner import FIRST_BITS, Refiner, Sensitivity
from refdem.truth.validated_flow import DualReading, ValidatedFlow
from refdem.truth.vectors import cross, dot

WITNESS = (
    "multiprecision integration of q' = q omega/2 with L kept, in axes that are not principal"
    " (refdem/truth/witnesses/linked.py)"
)
Vector = tuple[Fraction, ...]
AXES = (0, 1, 2)
NONE: Vector = (Fraction(0),) * 3


@dataclass(frozen=True)
class AboutAxis(FreeBody):
    """A body with two equal moments: J1 = `across` the unit vector `e`, and J3 = `along` it.

    The vectors e and omega [rad/s] are in any axes fixed to the body at t = 0. Three equal moments
    are a special case.
    """

    method = "two equal moments: one turn about L after one about the body's own axis"

    across: arb
    along: arb
    e: Sequence[arb]
    start: Sequence[arb]

    @cached_property
    def spin(self) -> arb:
        """The component omega . e [rad/s], which is constant."""
        return rotation.dot(self.start, self.e)

    @cached_property
    def momentum(self) -> list[arb]:
        """L = J1 omega + (J3 - J1)(omega . e) e [kg m^2/s]."""
        return [
            self.across * w + (self.along - self.across) * self.spin * x
            for w, x in zip(self.start, self.e, strict=True)
        ]

    @cached_property
    def length(self) -> arb:
        """The angular momentum |L| [kg m^2/s]."""
        return rotation.dot(self.momentum, self.momentum).sqrt()

    @cached_property
    def unit_momentum(self) -> list[arb]:
        """The direction L/|L| of the angular momentum."""
        return [m / self.length for m in self.momentum]

    @cached_property
    def twice_energy(self) -> arb:
        """Twice the energy, 2 E = L . omega [J]."""
        return rotation.dot(self.momentum, self.start)

    @cached_property
    def rate(self) -> arb:
        """The rate (omega . e)(1 - J3/J1) [rad/s] about e."""
        return self.spin * (1 - self.along / self.across)

    def omega(self, t: arb) -> list[arb]:
        """omega in body axes turns about e by -rate t."""
        # omega_body(t) = exp(-rate t e) omega_body(0).
        back = rotation.matrix(rotation.turn(self.e, -self.rate * t))
        return rotation.applied(back, self.start)

    def turn(self, t: arb) -> list[arb]:
        """The quaternion of R = exp(t L/J1) exp(t rate e)."""
        about_momentum = rotation.turn(self.unit_momentum, self.length / self.across * t)
        about_axis = rotation.turn(self.e, self.rate * t)
        return rotation.times(about_momentum, about_axis)

    def constants(self) -> dict[str, arb]:
        """The period of omega in body axes, 2 pi/|rate| [s]."""
        return {"period": 2 * arb.pi() / abs(self.rate)}

    def fastest(self) -> arb:
        """|omega| [rad/s], which is constant."""
        return length_of(self.start)

    def lead(self, t: arb) -> arb:
        """The lead of a steady rotation per time (free_body.steady_lead), times t."""
        square = rotation.dot(self.start, self.start)
        return steady_lead(self.along, self.twice_energy, self.length, square) * t


@dataclass(frozen=True)
class RigidCluster(ClosedForm):
    """The truth of a cluster: r1.x .. r4.z [m] of points whose centre of mass rests.

    `masses` [kg], `places` (positions [m]) and `omega` [rad/s, space axes] at the start are exact.
    `shift` [rad/s] is added to omega in principal axes: a displaced cluster has one that is not 0.

    S is that of the free body (body_growth.py), in its norm at both ends: the largest Euclidean
    length of the turn [1 rad], of omega [|omega| of the start] in body axes and in space, and of
    the place [L] and velocity [L |omega|] of the centre of mass, L the distance of the farthest
    point from it. A turn of one scale moves no point by more than L.

    The centre of mass needs no part of its own. What is left of its error after tau is at most
    1 + tau |omega| times what it was, and the turn psi = m with the change d = |omega| m of omega
    grows as much: psi . m gains d . m a second (the theorem on errors there).
    """

    witness = WITNESS
    state = BODY_OMEGA
    proof_of_s = Sensitivity(CLOSED_BITS)

    masses: Vector
    places: Sequence[Vector]
    omega: Vector
    shift: Vector = NONE
    method: str = field(init=False)

    displaced = displaced_tuple("shift")
    jacobian = derivative_of_turning
    turned = attitude_at

    def __post_init__(self) -> None:
        """Raises NotCertifiedError if no precision decides about which axis it rotates."""
        vars(self)["method"] = (
            f"closed form in Arb balls; {self.form().method}, in principal axes that are isolated"
            " roots"
        )

    @cached_property
    def centre(self) -> list[Fraction]:
        """The centre of mass of the points [m]."""
        # c = sum m r/sum m.
        total_mass = sum(self.masses, Fraction(0))
        return [dot_exact(self.masses, [r[i] for r in self.places]) / total_mass for i in AXES]

    @cached_property
    def arms(self) -> list[list[Fraction]]:
        """The places from the centre of mass [m]."""
        return [[r[i] - self.centre[i] for i in AXES] for r in self.places]

    @cached_property
    def tensor(self) -> list[list[Fraction]]:
        """The inertia tensor [kg m^2] about the centre of mass."""
        return inertia_tensor(self.masses, self.arms)

    def form(self) -> type[FreeBody]:
        """The closed form of the motion, at the lowest precision at which balls decide it.

        Raises NotCertifiedError if no precision does.
        """
        for bits in (FIRST_BITS << doubling for doubling in range(7)):
            with precision(bits):
                try:
                    return type(self.body())
                except UndecidedError:
                    continue
        message = (
            "separatrix: balls cannot decide about which principal axis the cluster turns; move its"
            " spin off the boundary"
        )
        raise NotCertifiedError(message, code="separatrix", time=0.0)

    @per_precision
    def moments(self) -> list[tuple[arb, int]]:
        """The distinct principal moments with their multiplicities, smallest first.

        They are the roots of the characteristic polynomial lambda^3 - trace lambda^2 + (sum of the
        principal minors) lambda - det J, which FLINT isolates exactly from whole coefficients.
        """
        # det(J - lambda) = 0 as lambda^3 - tr(J) lambda^2 + (m_x + m_y + m_z) lambda - det J
        a, b, c = self.tensor
        trace = a[0] + b[1] + c[2]
        minor_z = a[0] * b[1] - a[1] * b[0]
        minor_y = a[0] * c[2] - a[2] * c[0]
        minor_x = b[1] * c[2] - b[2] * c[1]
        determinant = dot_exact(a, cross(b, c))
        coefficients = [-determinant, minor_z + minor_y + minor_x, -trace, Fraction(1)]
        # Multiplied by a common denominator, the coefficients are whole.
        common = lcm(*(x.denominator for x in coefficients))
        roots: Any = fmpz_poly([int(x * common) for x in coefficients]).complex_roots()
        moments = [(root.real, multiplicity) for root, multiplicity in roots]
        return sorted(moments, key=lambda pair: float(pair[0].mid()))

    def axis(self, moment: arb) -> list[arb]:
        """The unit vector of the principal axis of a moment that occurs once.

        J - moment then has rank 2 and its rows span the plane across the axis, so that the axis is
        along the cross product of two of them: the largest of the three is the best known.
        """
        rows = [[arb_of(self.tensor[i][j]) - (moment if i == j else 0) for j in AXES] for i in AXES]
        normals = [rotation.cross(rows[i], rows[j]) for i, j in ((0, 1), (0, 2), (1, 2))]
        best = max(normals, key=lambda v: float(rotation.dot(v, v).mid()))
        length = rotation.dot(best, best).sqrt()
        return [x / length for x in best]

    @per_precision
    def axes(self) -> list[list[arb]]:
        """The axes of the body in which its motion is computed: right-handed unit vectors, as rows.

        They are the principal axes, or those of space where two moments are equal (AboutAxis).
        """
        if len(self.moments()) < 3:
            return [[arb(int(i == j)) for j in AXES] for i in AXES]
        # The third axis is first x second, so that the three are right-handed.
        first, second = (self.axis(moment) for moment, _ in self.moments()[:2])
        return [first, second, rotation.cross(first, second)]

    @property
    def is_steady(self) -> bool:
        """True if L is parallel to omega, without the shift: the cluster turns steadily."""
        momentum = [dot_exact(row, self.omega) for row in self.tensor]
        # L x omega = (J omega) x omega = 0.
        return not any(cross(momentum, self.omega))

    @per_precision
    def body(self) -> FreeBody:
        """The motion of the free body in `axes`, of the kind that follows from the exact initial
        state.
        """
        omega = [arb_of(w) for w in self.omega]
        if len(self.moments()) < 3:
            return self._about_axis(omega)
        moments: Any = tuple(moment for moment, _ in self.moments())
        omega_body = rotation.applied(self.axes(), omega)
        steady_axis = None
        if self.is_steady:
            # omega is exactly along one principal axis: set the other components to exactly 0.
            steady_axis = self._steady_axis(moments)
            omega_body = [w if i == steady_axis else arb(0) for i, w in enumerate(omega_body)]
        shifted: Any = tuple(w + arb_of(s) for w, s in zip(omega_body, self.shift, strict=True))
        start = Principal.of(moments, shifted)
        # The rotation stays steady if only the component along its axis is displaced.
        shift_across = [s for i, s in enumerate(self.shift) if i != steady_axis]
        if steady_axis is not None and not any(shift_across):
            return Steady(start)
        if self._is_on_separatrix(moments[1]):
            return Separatrix(start)
        return Elliptic(start)

    def _about_axis(self, omega: Sequence[arb]) -> AboutAxis:
        """The motion with equal moments; three equal ones have no axis of their own, so take z."""
        counted = self.moments()
        once = next((moment for moment, count in counted if count == 1), counted[0][0])
        twice = next(moment for moment, count in counted if count > 1)
        if len(counted) == 2:
            e = self.axis(once)
        else:
            e = [arb(0), arb(0), arb(1)]
        shifted = [w + arb_of(s) for w, s in zip(omega, self.shift, strict=True)]
        return AboutAxis(twice, once, e, shifted)

    def _steady_axis(self, moments: Sequence[arb]) -> int:
        """The principal axis along which omega lies: that of the moment 2 E/omega^2."""
        momentum = [dot_exact(row, self.omega) for row in self.tensor]
        # 2 E/omega^2 = (L . omega)/(omega . omega).
        moment = dot_exact(momentum, self.omega) / dot_exact(self.omega, self.omega)
        return min(AXES, key=lambda i: abs(float(moments[i].mid()) - float(moment)))

    def _is_on_separatrix(self, middle_moment: arb) -> bool:
        """True if L^2/(2 E) is exactly the middle moment: a root of det(J - lambda), and that one.

        A displaced cluster never is: its shift is not exact in the axes of space.
        """
        if any(self.shift):
            return False
        momentum = [dot_exact(row, self.omega) for row in self.tensor]
        # L^2/(2 E) = L . L/(L . omega).
        ratio = dot_exact(momentum, momentum) / dot_exact(momentum, self.omega)
        return self.characteristic(ratio) == 0 and middle_moment.contains(arb_of(ratio).mid())

    def characteristic(self, value: Fraction) -> Fraction:
        """det(J - value), exact: the scalar triple product of the rows."""
        rows = [list(row) for row in self.tensor]
        for i in AXES:
            rows[i][i] -= value
        a, b, c = rows
        # det = a . (b x c).
        determinant: Fraction = dot_exact(a, cross(b, c))
        return determinant

    @per_precision
    def start(self) -> list[arb]:
        """The quaternion from `axes` to space at t = 0."""
        # The axes are the rows of the matrix from space to `axes`; its transpose is the inverse.
        return rotation.quaternion(rotation.transposed(self.axes()))

    def spin(self, t: arb) -> list[arb]:
        """omega [rad/s] in `axes` at time t."""
        return self.body().omega(t)

    def evaluate(self, t: arb) -> dict[str, arb]:
        """r_i = c + R(t) (r_i(0) - c), with R(t) = q(t) q(0)* in axes of space."""
        since_start = rotation.times(self.turned(t), rotation.conjugate(self.start()))
        return places_of(self.centre, self.arms, since_start)

    def by_equation(self) -> ValidatedFlow:
        """The same motion from the equation q' = q omega/2 of the turn q since the start, where
        omega = J^-1 R^T L in axes of the body, and L is constant.
        """
        momentum = [dot_exact(row, self.omega) for row in self.tensor]
        inverse = inverse_of(self.tensor)
        centre = self.centre
        arms = self.arms

        def rates(q: Sequence[Any]) -> list[Any]:
            a, b, c, d = q
            # L_body = R^T L, and omega = J^-1 L_body.
            columns = rotation.transposed(rotation.matrix(q))
            momentum_body = [dot(column, momentum) for column in columns]
            wx, wy, wz = (dot(row, momentum_body) for row in inverse)
            # 2 q' = q (0, omega), Hamilton's product of (a, b, c, d) and (0, omega).
            twice_a = -(b * wx + c * wy + d * wz)
            twice_b = a * wx + c * wz - d * wy
            twice_c = a * wy + d * wx - b * wz
            twice_d = a * wz + b * wy - c * wx
            return [twice_a / 2, twice_b / 2, twice_c / 2, twice_d / 2]

        def seen(q: Sequence[arb]) -> dict[str, arb]:
            return places_of(centre, arms, q)

        start = [Fraction(1), *NONE]
        flow = ValidatedFlow(
            rates,
            start,
            DualReading(seen),
            self.scale,
            state=ATTITUDE,
            moved=range(4),
        )
        return flow.refined(self.digits)

    @per_precision
    def growth(self) -> Grows:
        """How errors grow: as those of the free body (see the class)."""
        moments = [moment for moment, _ in self.moments()]
        turn = self.scale["attitude.w"]
        spin = self.scale["omega.x"]
        if self.is_steady:
            return steady_growth(self.tensor, self.omega, turn, spin, self.in_own_axes)
        if len(moments) < 3:
            tensor = [[arb_of(x) for x in row] for row in self.tensor]
            return tumbling_growth(tensor, self.body(), turn, spin, self.in_own_axes)
        return tumbling_growth(diagonal(moments), self.body(), turn, spin, self.turned)

    def in_own_axes(self, t: arb) -> list[arb]:
        """The turn since the start, in the axes of space in which the places are given."""
        return rotation.times(self.turned(t), rotation.conjugate(self.start()))


def places_of(
    centre: Sequence[Fraction], arms: Sequence[Sequence[Fraction]], turn: Sequence[arb]
) -> dict[str, arb]:
    """The places r1.x to r4.z [m] of points at these arms from the centre, after a turn by a unit
    quaternion.
    """
    r = rotation.matrix(turn)
    places: dict[str, arb] = {}
    for number, arm in enumerate(arms):
        # r_i = c + R a_i.
        turned_arm = rotation.applied(r, [arb_of(x) for x in arm])
        for axis, c, x in zip("xyz", centre, turned_arm, strict=True):
            places[f"r{number + 1}.{axis}"] = arb_of(c) + x
    return places


def inverse_of(tensor: Sequence[Sequence[Fraction]]) -> list[list[Fraction]]:
    """The inverse of a symmetric matrix, exact: vector products of its rows over its
    determinant.
    """
    a, b, c = tensor
    # (b x c, c x a, a x b)/(a . b x c): columns of the inverse, and rows of it by symmetry.
    determinant = dot_exact(a, cross(b, c))
    return [[x / determinant for x in row] for row in (cross(b, c), cross(c, a), cross(a, b))]


def inertia_tensor(
    masses: Sequence[Fraction], arms: Sequence[Sequence[Fraction]]
) -> list[list[Fraction]]:
    """J_ij = sum m (r^2 delta_ij - r_i r_j) [kg m^2] of points at the arms r [m], exact."""
    points = list(zip(masses, arms, strict=True))
    # sum m r^2, which is added on the diagonal.
    trace_term = sum((m * dot_exact(r, r) for m, r in points), Fraction(0))
    tensor = [[-sum((m * r[i] * r[j] for m, r in points), Fraction(0)) for j in AXES] for i in AXES]
    for i in AXES:
        tensor[i][i] += trace_term
    return tensor


def truth(p: Parameters, scale: Mapping[str, float], rate: float) -> Truth:
    """The truth at parameters masses [kg], positions [m, four times x, y, z], omega [rad/s].

    `scale` has the sizes of the positions against which their errors count, `rate` [rad/s] is that
    of omega.
    """
    flat = vector(p, "positions")
    places = [flat[k : k + 3] for k in range(0, 12, 3)]
    sizes = {**scale, **dict.fromkeys((*BODY_OMEGA, *OMEGA), rate), **dict.fromkeys(ATTITUDE, 1.0)}
    return RigidCluster(Refiner.of(sizes), vector(p, "masses"), places, vector(p, "omega"))
