"""Certified free rigid body: omega by Jacobi's elliptic functions, attitude by theta functions.

The motion in principal axes is that of refdem/truth/free_body.py: J omega' = (J omega) x omega and
the turn q(0)* q(t). Quaternions (w, x, y, z) and the matrix R lead from the body to space; omega is
in space axes, omega_body in principal axes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property, partial
from typing import Any, Protocol

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth import rotation
from refdem.truth.balls import arb_of
from refdem.truth.body_growth import diagonal, steady_growth, tumbling_growth
from refdem.truth.closed_form import DISPLACEMENT, ClosedForm, displaced_tuple, per_precision
from refdem.truth.free_body import Exact3, FreeBody, Kind, Principal, Steady, kind
from refdem.truth.growth import CLOSED_BITS, Grows
from refdem.truth.refiner import Refiner, Sensitivity
from refdem.truth.smooth_flow import Displaceable, pair
from refdem.truth.validated_flow import DualReading, ValidatedFlow
from refdem.truth.vectors import cross

AXES = "xyz"
WITNESS = (
    "Taylor series of Euler's and the quaternion equation (tests/quadratic_flows.py): no elliptic"
    " or theta function"
)
BODY_OMEGA = tuple(f"omega_body.{a}" for a in AXES)
OMEGA = tuple(f"omega.{a}" for a in AXES)
ATTITUDE = tuple(f"attitude.{a}" for a in "wxyz")
MATRIX = tuple(f"R.{a}{b}" for a in AXES for b in AXES)


class Turning(Displaceable, Protocol):
    """A free body, as its attitude and the derivative of that by the start need it."""

    def body(self) -> FreeBody:
        """The motion in body axes at the current precision."""

    def start(self) -> list[arb]:
        """The unit attitude at t = 0."""

    def spin(self, t: arb) -> list[arb]:
        """omega_body (3) [rad/s] at the time t."""

    def turned(self, t: arb) -> list[arb]:
        """The attitude at t, of either sign."""


def attitude_at(form: Turning, t: arb) -> list[arb]:
    """The attitude at t, of either sign: the method `turned` of a free body."""
    if t.is_zero():
        return form.start()
    return rotation.times(form.start(), form.body().turn(t))


def derivative_of_turning(form: Turning, t: Fraction) -> arb_mat:
    """The derivative of the motion at t by its start, in scales: 9 rows, 6 columns.

    Rows are a small turn in space (3), omega_body (3) and omega (3) at t; columns are a small
    turn in space (3) and omega_body (3) at the start. The columns of the turn are exact, those
    of omega_body are central differences. It is the method `jacobian` of a free body.
    """
    columns = [scaled_changes(form, axis, arb_of(t)) for axis in range(3)]
    rows = [[column[i] for column in columns] for i in range(9)]
    # Central differences of motions displaced by +-DISPLACEMENT scales of omega_body.
    by_omega = (arb_mat(rows) / arb_of(2 * DISPLACEMENT)).table()
    x, y, z = rotation.rotated(form.turned(arb_of(t)), form.spin(arb_of(t)))
    # A start turned by a small d phi turns all of the motion: d omega = d phi x omega, where a
    # turn counts in the scale of the attitude and omega in its own.
    ratio = arb_of(form.scale["attitude.w"] / form.scale["omega.x"])
    zero = arb(0)
    # The matrix of d phi -> d phi x omega.
    cross_omega = [[zero, z, -y], [-z, zero, x], [y, -x, zero]]
    turn_by_turn = [[arb(i == k) for k in range(3)] for i in range(3)]
    omega_body_by_turn = [[zero] * 3] * 3
    omega_by_turn = [[ratio * v for v in row] for row in cross_omega]
    by_turn = turn_by_turn + omega_body_by_turn + omega_by_turn
    return arb_mat([a + b for a, b in zip(by_turn, by_omega, strict=True)])


def scaled_changes(form: Turning, axis: int, t: arb) -> list[arb]:
    """Differences at t of turn, omega_body and omega (9), each in its scale.

    They are those of the two motions whose omega_body at the start is displaced along `axis`,
    to both sides. To first order the turn between their attitudes q+ and q- is twice the vector
    part of q+ q-*.
    """
    plus, minus = pair(form, axis)
    q_plus = plus.turned(t)
    q_minus = minus.turned(t)
    body_plus = plus.spin(t)
    body_minus = minus.spin(t)
    space_plus = rotation.rotated(q_plus, body_plus)
    space_minus = rotation.rotated(q_minus, body_minus)
    turn = rotation.times(q_plus, rotation.conjugate(q_minus))
    # q+ q-* = (cos(phi/2), sin(phi/2) n) = (1, phi n/2) to first order: phi n = 2 (x, y, z).
    scaled = [2 * x / arb_of(form.scale["attitude.w"]) for x in turn[1:]]
    omegas_plus = [*body_plus, *space_plus]
    omegas_minus = [*body_minus, *space_minus]
    names = (*BODY_OMEGA, *OMEGA)
    for name, plus_value, minus_value in zip(names, omegas_plus, omegas_minus, strict=True):
        scaled.append((plus_value - minus_value) / arb_of(form.scale[name]))
    return scaled


@dataclass(frozen=True)
class FreeRigidBody(ClosedForm):
    """The truth of a free body: omega_body, omega [rad/s], attitude (w >= 0) and the matrix R.

    Inertia [kg m^2, principal], omega [rad/s, body axes] and attitude at the start are exact; the
    attitude need not be of unit length. With `counts_flips` the scalars have flip_time [s], half a
    period, which lies between two sign changes of omega along the intermediate axis.

    S: the start is turned in space, which turns all that follows by as much, and omega_body is
    displaced; both by vectors of at most their scale.
    """

    witness = WITNESS
    state = BODY_OMEGA
    proof_of_s = Sensitivity(CLOSED_BITS)

    inertia: Exact3
    omega: Exact3
    attitude: tuple[Fraction, ...]
    counts_flips: bool = False
    method: str = field(init=False)

    displaced = displaced_tuple("omega")
    jacobian = derivative_of_turning
    turned = attitude_at

    @cached_property
    def kind(self) -> Kind:
        """The closed form of the motion, which follows from the exact initial state."""
        return kind(self.inertia, self.omega)

    def __post_init__(self) -> None:
        vars(self)["method"] = f"closed form in Arb balls; {self.kind.method}"

    @per_precision
    def body(self) -> FreeBody:
        """The motion in body axes at the current precision."""
        return self.kind(Principal.of(self.inertia, self.omega))

    @per_precision
    def start(self) -> list[arb]:
        """The unit attitude at t = 0."""
        # q0/|q0|.
        length = arb_of(sum((x * x for x in self.attitude), Fraction(0))).sqrt()
        return [arb_of(x) / length for x in self.attitude]

    def spin(self, t: arb) -> list[arb]:
        """Angular velocity omega_body (3) [rad/s] at time t."""
        if t.is_zero():
            return [arb_of(w) for w in self.omega]
        return self.body().omega(t)

    def evaluate(self, t: arb) -> dict[str, arb]:
        """omega_body, omega = R omega_body, the attitude with w >= 0, and R, at time t."""
        return seen([*self.spin(t), *self.turned(t)])

    def by_equation(self) -> ValidatedFlow:
        """The same motion from Euler's equations and that of the attitude q, to the same digits:
        J omega' = J omega x omega, q' = q omega/2.
        """
        inertia = self.inertia

        def rates(y: Sequence[Any]) -> list[Any]:
            wx, wy, wz, a, b, c, d = y
            momentum = [w * j for w, j in zip(y[:3], inertia, strict=True)]
            # omega_i' = ((J omega) x omega)_i/J_i.
            gyroscopic = cross(momentum, y[:3])
            spin_up = [torque / j for torque, j in zip(gyroscopic, inertia, strict=True)]
            # Hamilton's product (a, b, c, d) (0, omega).
            turning = [
                -(b * wx + c * wy + d * wz),
                a * wx + c * wz - d * wy,
                a * wy + d * wx - b * wz,
                a * wz + b * wy - c * wx,
            ]
            return [*spin_up, *(rate / 2 for rate in turning)]

        attitude = (partial(self.start_of, part) for part in range(4))
        start: list[Any] = [*self.omega, *attitude]
        flow = ValidatedFlow(
            rates,
            start,
            DualReading(seen),
            self.scale,
            state=BODY_OMEGA,
            moved=range(3),
        )
        return flow.refined(self.digits)

    def start_of(self, part: int) -> arb:
        """One of the four parts of the unit attitude at t = 0, at the current precision."""
        return self.start()[part]

    def constants(self) -> dict[str, arb]:
        """The period [s] of omega_body and the elliptic parameter, where there are any; flip_time
        [s] where flips are counted.
        """
        scalars = self.body().constants()
        if self.counts_flips and len(set(self.inertia)) == 3 and "period" in scalars:
            scalars["flip_time"] = scalars["period"] / 2
        return scalars

    @per_precision
    def growth(self) -> Grows:
        """How errors of attitude and omega grow: of a steady turn, or of a tumbling body."""
        turn = self.scale["attitude.w"]
        spin = self.scale["omega.x"]
        if self.kind is Steady:
            return steady_growth(diagonal(self.inertia), self.omega, turn, spin, self.turned)
        balls = [arb_of(moment) for moment in self.inertia]
        return tumbling_growth(diagonal(balls), self.body(), turn, spin, self.turned)


def seen(y: Sequence[arb]) -> dict[str, arb]:
    """The quantities of a state: omega_body (3) [rad/s] and the unit attitude (4), of any sign."""
    omega_body = list(y[:3])
    q = rotation.upright(y[3:])
    r = rotation.matrix(q)
    # omega = R omega_body.
    omega = rotation.applied(r, omega_body)
    names = (*BODY_OMEGA, *OMEGA, *ATTITUDE, *MATRIX)
    values = [*omega_body, *omega, *q, *r[0], *r[1], *r[2]]
    return dict(zip(names, values, strict=True))


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters inertia [kg m^2], omega_body [rad/s], attitude.

    `scale` has the size of each quantity against which its error counts.
    """
    inertia, omega, attitude = exact_columns(p)
    return FreeRigidBody(Refiner.of(scale), inertia, omega, attitude)


Rational3 = tuple[Fraction, Fraction, Fraction]


def exact_columns(p: Parameters) -> tuple[Rational3, Rational3, tuple[Fraction, ...]]:
    """inertia, omega_body and attitude as exact rationals."""
    inertia: Any = p["inertia"]
    omega: Any = p["omega_body"]
    attitude: Any = p["attitude"]
    return inertia, omega, attitude
