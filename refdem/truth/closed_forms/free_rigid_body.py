"""Certified free rigid body: omega by Jacobi's elliptic functions, attitude by theta functions (refdem/truth/free_body.py)."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth import rotation
from refdem.truth.balls import arb_of
from refdem.truth.closed_form import DISPLACEMENT, ClosedForm, Size, per_precision
from refdem.truth.free_body import Exact3, FreeBody, free_body

AXES = "xyz"
WITNESS = "Taylor series of Euler's and the quaternion equation (refdem/truth/witness.py): no elliptic or theta function"
BODY_OMEGA = tuple(f"omega_body.{a}" for a in AXES)
OMEGA = tuple(f"omega.{a}" for a in AXES)
ATTITUDE = tuple(f"attitude.{a}" for a in "wxyz")
MATRIX = tuple(f"R.{a}{b}" for a in AXES for b in AXES)


class FreeRigidBody(ClosedForm):
    """omega_body, omega, attitude (w >= 0) and R of a free body; the start is exact, the attitude need not be of unit size.

    S: the start is turned in space, which turns all that follows by as much, and omega_body is displaced; both as vectors of
    at most their scale.
    """

    witness = WITNESS
    state = BODY_OMEGA

    def __init__(self, inertia: Exact3, omega: Exact3, attitude: tuple[Fraction, ...], scale: Mapping[str, Size]) -> None:
        super().__init__(scale)
        self.inertia, self.omega, self.attitude = inertia, omega, attitude
        self.method = f"closed form ({type(self.body()).__name__.lower()}): Jacobi elliptic and theta functions, in Arb balls"

    @per_precision
    def body(self) -> FreeBody:
        """The motion in body axes at the current precision."""
        return free_body(self.inertia, self.omega)

    @per_precision
    def start(self) -> list[arb]:
        """The unit attitude at t = 0."""
        size = arb_of(sum((x * x for x in self.attitude), Fraction(0))).sqrt()
        return [arb_of(x) / size for x in self.attitude]

    def turned(self, t: arb) -> list[arb]:
        """The attitude at t, of either sign."""
        return self.start() if t.is_zero() else rotation.times(self.start(), self.body().turn(t))

    def spin(self, t: arb) -> list[arb]:
        """omega_body at t."""
        return [arb_of(w) for w in self.omega] if t.is_zero() else self.body().omega(t)

    def evaluate(self, t: arb) -> dict[str, arb]:
        q, omega = rotation.upright(self.turned(t)), self.spin(t)
        r = rotation.matrix(q)
        names = (*BODY_OMEGA, *OMEGA, *ATTITUDE, *MATRIX)
        return dict(zip(names, [*omega, *rotation.applied(r, omega), *q, *r[0], *r[1], *r[2]], strict=True))

    def displaced(self, axis: int, amount: Fraction) -> "FreeRigidBody":
        x, y, z = (w + (amount if i == axis else 0) for i, w in enumerate(self.omega))
        return FreeRigidBody(self.inertia, (x, y, z), self.attitude, self.scale)

    def constants(self) -> dict[str, arb]:
        return self.body().constants()

    def response(self, t: Fraction) -> list[arb]:
        """Sizes of the responses of the attitude (as a turn), omega_body and omega to a turn and to a change of omega_body."""
        time = arb_of(t)
        turns, spins, spins_in_space = zip(*(self._derivatives(axis, time) for axis in range(3)), strict=True)
        rows = [1 + _norm([x for turn in turns for x in turn]) / arb_of(self.scale["attitude.w"])]
        rows += [_norm([spin[i] for spin in spins]) / arb_of(self.scale[BODY_OMEGA[i]]) for i in range(3)]
        omega = rotation.rotated(self.turned(time), self.spin(time))
        for i in range(3):
            by_turn = _norm([omega[i - 1], omega[i - 2]]) * arb_of(self.scale["attitude.w"])
            rows.append((by_turn + _norm([spin[i] for spin in spins_in_space])) / arb_of(self.scale[OMEGA[i]]))
        return rows

    def _derivatives(self, axis: int, t: arb) -> tuple[list[arb], list[arb], list[arb]]:
        """Turn [rad], change of omega_body and of omega at t as omega_body's coordinate `axis` moves by its scale."""
        plus, minus = self.pair(axis)
        q_plus, q_minus = plus.turned(t), minus.turned(t)
        turn = rotation.times(q_plus, rotation.conjugate(q_minus))
        w_plus, w_minus = plus.spin(t), minus.spin(t)
        in_space = (rotation.rotated(q_plus, w_plus), rotation.rotated(q_minus, w_minus))
        step = arb_of(2 * DISPLACEMENT)
        return (
            [2 * x / step for x in turn[1:]],
            [(a - b) / step for a, b in zip(w_plus, w_minus, strict=True)],
            [(a - b) / step for a, b in zip(*in_space, strict=True)],
        )


def _norm(values: Sequence[arb]) -> arb:
    """Euclidean norm."""
    return arb(sum((x * x for x in values), arb(0)).abs_upper()).sqrt()


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at these parameters (inertia, omega_body, attitude)."""
    inertia, omega, attitude = exact_columns(p)
    return FreeRigidBody(inertia, omega, attitude, scale)


def exact_columns(p: Parameters) -> tuple[Exact3, Exact3, tuple[Fraction, ...]]:
    """inertia, omega_body and attitude as exact rationals."""
    inertia: Any = p["inertia"]
    omega: Any = p["omega_body"]
    attitude: Any = p["attitude"]
    return inertia, omega, attitude
