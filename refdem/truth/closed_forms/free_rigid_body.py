"""Certified free rigid body: omega by Jacobi's elliptic functions, attitude by theta functions
(refdem/truth/free_body.py).
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth import rotation
from refdem.truth.balls import Guarded, arb_of
from refdem.truth.body_growth import diagonal, steady_growth, tumbling_growth
from refdem.truth.closed_form import DISPLACEMENT, ClosedForm, per_precision
from refdem.truth.free_body import Exact3, FreeBody, Steady, kind
from refdem.truth.growth import CLOSED_BITS, Grows
from refdem.truth.refiner import Refiner, Sensitivity, Size
from refdem.truth.smooth_flow import pair

AXES = "xyz"
WITNESS = (
    "Taylor series of Euler's and the quaternion equation (refdem/truth/witness.py): no elliptic or"
    " theta function"
)
BODY_OMEGA = tuple(f"omega_body.{a}" for a in AXES)
OMEGA = tuple(f"omega.{a}" for a in AXES)
ATTITUDE = tuple(f"attitude.{a}" for a in "wxyz")
MATRIX = tuple(f"R.{a}{b}" for a in AXES for b in AXES)


class Turning(Guarded, ABC):
    """The part that all free bodies share: their attitude, and its derivative by the start."""

    @property
    @abstractmethod
    def scale(self) -> dict[str, Fraction]:
        """The size of each quantity, against which its error counts."""

    @abstractmethod
    def body(self) -> FreeBody:
        """The motion in body axes at the current precision."""

    @abstractmethod
    def start(self) -> list[arb]:
        """The unit attitude at t = 0."""

    @abstractmethod
    def spin(self, t: arb) -> list[arb]:
        """omega_body (3) [rad/s] at the time t."""

    def turned(self, t: arb) -> list[arb]:
        """The attitude at t, of either sign."""
        if t.is_zero():
            return self.start()
        return rotation.times(self.start(), self.body().turn(t))

    def jacobian(self, t: Fraction) -> arb_mat:
        """Rows: turn in space, omega_body, omega; columns: turn in space (exact: all that follows
        turns) and omega_body.
        """
        columns = [self.scaled_changes(axis, arb_of(t)) for axis in range(3)]
        rows = [[column[i] for column in columns] for i in range(9)]
        # Central differences of motions displaced by +-DISPLACEMENT scales of omega_body.
        by_omega = (arb_mat(rows) / arb_of(2 * DISPLACEMENT)).table()
        x, y, z = rotation.rotated(self.turned(arb_of(t)), self.spin(arb_of(t)))
        # A start turned by a small d phi turns all of the motion: d omega = d phi x omega, where a
        # turn counts in the scale of the attitude and omega in its own.
        ratio = arb_of(self.scale["attitude.w"] / self.scale["omega.x"])
        none = arb(0)
        turning = [[none, z, -y], [-z, none, x], [y, -x, none]]
        by_turn = (
            [[arb(i == k) for k in range(3)] for i in range(3)]
            + [[none] * 3] * 3
            + [[ratio * v for v in row] for row in turning]
        )
        return arb_mat([a + b for a, b in zip(by_turn, by_omega, strict=True)])

    def scaled_changes(self, axis: int, t: arb) -> list[arb]:
        """Changes at t, each in its scale, of turn, omega_body and omega by a component of
        omega_body.
        """
        form: Any = self
        plus, minus = pair(form, axis)
        q_plus = plus.turned(t)
        q_minus = minus.turned(t)
        w_plus = plus.spin(t)
        w_minus = minus.spin(t)
        turn = rotation.times(q_plus, rotation.conjugate(q_minus))
        in_space = zip(
            rotation.rotated(q_plus, w_plus), rotation.rotated(q_minus, w_minus), strict=True
        )
        spins = [a - b for a, b in [*zip(w_plus, w_minus, strict=True), *in_space]]
        scaled = [2 * x / arb_of(self.scale["attitude.w"]) for x in turn[1:]]
        return scaled + [
            x / arb_of(self.scale[name])
            for x, name in zip(spins, (*BODY_OMEGA, *OMEGA), strict=True)
        ]


class FreeRigidBody(ClosedForm, Turning):
    """omega_body, omega, attitude (w >= 0) and R of a free body; the start is exact, the attitude
    need not be of unit size.

    S: the start is turned in space, which turns all that follows by as much, and omega_body is
    displaced; both by vectors of at most their scale. `counts_flips`: the scalars have flip_time,
    half a period, which lies between two sign changes of omega along the intermediate axis.
    """

    witness = WITNESS
    state = BODY_OMEGA
    proof_of_s = Sensitivity(CLOSED_BITS)

    def __init__(
        self,
        inertia: Exact3,
        omega: Exact3,
        attitude: tuple[Fraction, ...],
        scale: Mapping[str, Size],
        *,
        counts_flips: bool = False,
    ) -> None:
        self.refiner = Refiner.of(scale)
        self.inertia = inertia
        self.omega = omega
        self.attitude = attitude
        self.counts_flips = counts_flips
        self.kind = kind(inertia, omega)
        self.method = f"closed form in Arb balls; {self.kind.method}"

    @per_precision
    def body(self) -> FreeBody:
        """The motion in body axes at the current precision."""
        return self.kind(self.inertia, self.omega)

    @per_precision
    def start(self) -> list[arb]:
        """The unit attitude at t = 0."""
        size = arb_of(sum((x * x for x in self.attitude), Fraction(0))).sqrt()
        return [arb_of(x) / size for x in self.attitude]

    def spin(self, t: arb) -> list[arb]:
        """Angular velocity omega_body (3) [rad/s] at time t."""
        if t.is_zero():
            return [arb_of(w) for w in self.omega]
        return self.body().omega(t)

    def evaluate(self, t: arb) -> dict[str, arb]:
        q = rotation.upright(self.turned(t))
        omega = self.spin(t)
        r = rotation.matrix(q)
        names = (*BODY_OMEGA, *OMEGA, *ATTITUDE, *MATRIX)
        return dict(
            zip(names, [*omega, *rotation.applied(r, omega), *q, *r[0], *r[1], *r[2]], strict=True)
        )

    def displaced(self, axis: int, amount: Fraction) -> "FreeRigidBody":
        x, y, z = (w + (amount if i == axis else 0) for i, w in enumerate(self.omega))
        return FreeRigidBody(
            self.inertia, (x, y, z), self.attitude, self.scale, counts_flips=self.counts_flips
        )

    def constants(self) -> dict[str, arb]:
        found = self.body().constants()
        if self.counts_flips and len(set(self.inertia)) == 3 and "period" in found:
            found["flip_time"] = found["period"] / 2
        return found

    @per_precision
    def growth(self) -> Grows:
        turn = self.scale["attitude.w"]
        spin = self.scale["omega.x"]
        if self.kind is Steady:
            return steady_growth(diagonal(self.inertia), self.omega, turn, spin, self.turned)
        balls = [arb_of(moment) for moment in self.inertia]
        return tumbling_growth(diagonal(balls), self.body(), turn, spin, self.turned)


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at these parameters (inertia, omega_body, attitude)."""
    inertia, omega, attitude = exact_columns(p)
    return FreeRigidBody(inertia, omega, attitude, scale)


Rational3 = tuple[Fraction, Fraction, Fraction]


def exact_columns(p: Parameters) -> tuple[Rational3, Rational3, tuple[Fraction, ...]]:
    """inertia, omega_body and attitude as exact rationals."""
    inertia: Any = p["inertia"]
    omega: Any = p["omega_body"]
    attitude: Any = p["attitude"]
    return inertia, omega, attitude
