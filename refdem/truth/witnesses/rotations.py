"""Witnesses of spinning bodies: Euler's equations and q' = q omega_body/2 by Taylor integration.

The state is (omega_body, q): three rates in principal axes and the quaternion (w, x, y, z) from the
body to space.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import Solution

METHOD = (
    "Taylor integration of Euler's equations and of qdot = q omega_body/2 at 58 digits, unproven"
    " (refdem/truth/witnesses/rotations.py)"
)


def rates(inertia: Sequence[arb]) -> Any:
    """The right-hand side for a free body with omega_body = (a, b, c).

    J1 a' = (J2 - J3) b c, J2 b' = (J3 - J1) c a, J3 c' = (J1 - J2) a b, and q' = q omega_body/2.
    """
    j1, j2, j3 = inertia

    def field(t: Any, state: Sequence[Any]) -> list[Any]:
        a, b, c, w, x, y, z = state
        # J1 a' = (J2 - J3) b c, and its cyclic permutations.
        a_rate = b * c * ((j2 - j3) / j1)
        b_rate = c * a * ((j3 - j1) / j2)
        c_rate = a * b * ((j1 - j2) / j3)
        # q' = q (0, omega_body)/2: the quaternion product q (0, a, b, c).
        product_w = -x * a - y * b - z * c
        product_x = w * a + y * c - z * b
        product_y = w * b + z * a - x * c
        product_z = w * c + x * b - y * a
        q_omega = [product_w, product_x, product_y, product_z]
        return [a_rate, b_rate, c_rate, *(component / 2 for component in q_omega)]

    return field


def quantities(state: Sequence[arb]) -> dict[str, arb]:
    """omega_body, omega = R omega_body, the attitude q with w >= 0, and R (body to space)."""
    omega_body = state[:3]
    q = state[3:]
    if not q[0] >= 0:
        q = [-component for component in q]
    w, x, y, z = q
    # R = 1 + 2 w [u]x + 2 [u]x^2 with u = (x, y, z), [u]x a = u x a, and w^2 + u^2 = 1.
    row_x = [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)]
    row_y = [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]
    row_z = [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
    r = [row_x, row_y, row_z]
    values = {f"omega_body.{axis}": rate for axis, rate in zip("xyz", omega_body, strict=True)}
    values |= {f"attitude.{axis}": component for axis, component in zip("wxyz", q, strict=True)}
    for axis, row in zip("xyz", r, strict=True):
        values[f"omega.{axis}"] = sum(
            (entry * rate for entry, rate in zip(row, omega_body, strict=True)), arb(0)
        )
        for column, entry in zip("xyz", row, strict=True):
            values[f"R.{axis}{column}"] = entry
    return values


def tumbling(
    p: Mapping[str, Exact], omega: Sequence[arb], times: Sequence[Fraction], claimed: Claimed
) -> Results:
    """The motion of a free body that starts with omega_body = `omega` [rad/s], and its period."""
    q = [arb_of(component) for component in vector(p, "attitude")]
    length = sum((component * component for component in q), arb(0)).sqrt()
    field = rates([arb_of(moment) for moment in vector(p, "inertia")])
    solution = Solution(field, [*omega, *(component / length for component in q)])
    for t in times:
        yield t, quantities(solution.at(t))
    if "period" in claimed:
        yield None, returned(solution, claimed)


def returned(solution: Solution, claimed: Claimed) -> dict[str, arb]:
    """The period [s] of omega_body near the claimed one; empty if omega_body is nearly constant.

    It is the time at which the component with the largest initial rate has its initial value again.
    """
    start = solution.at(Fraction(0))
    slopes = [abs(float(rate.mid())) for rate in solution.field(arb(0), start)[:3]]
    fastest = slopes.index(max(slopes))
    if slopes[fastest] < 1e-3:
        return {}
    period = float(claimed["period"])

    def change(state: Sequence[arb]) -> arb:
        return state[fastest] - start[fastest]

    return {"period": solution.crossing(change, period, period / 256)}


def free(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The motion of a free body from omega_body of the case."""
    return tumbling(p, [arb_of(part) for part in vector(p, "omega_body")], times, claimed)


def beside_axis(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The motion of a free body from omega_body + offset |omega_body| e, e the axis `direction`."""
    omega = [arb_of(component) for component in vector(p, "omega_body")]
    length = sum((component * component for component in omega), arb(0)).sqrt()
    axis = int(str(p["direction"])) - 1
    omega[axis] += arb_of(number(p, "offset")) * length
    return tumbling(p, omega, times, claimed)


def damped(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The body with internal damping c, by its angular momentum L in principal axes.

    L' = L x omega + c L x (L x omega) with omega_i = L_i/J_i and L x (L x omega) = L (L . omega) -
    omega |L|^2. |L| is constant and the energy decreases.
    """
    inertia = [arb_of(moment) for moment in vector(p, "inertia")]
    omega0 = [arb_of(component) for component in vector(p, "omega_body")]
    damping = arb_of(number(p, "damping"))

    def field(t: Any, momentum: Sequence[Any]) -> list[Any]:
        l1, l2, l3 = momentum
        w1, w2, w3 = (component / j for component, j in zip(momentum, inertia, strict=True))
        # L' = L x omega + c (L (L . omega) - omega |L|^2)
        l_omega = l1 * w1 + l2 * w2 + l3 * w3
        l_square = l1 * l1 + l2 * l2 + l3 * l3
        cross = [l2 * w3 - l3 * w2, l3 * w1 - l1 * w3, l1 * w2 - l2 * w1]
        rates = []
        for gyroscopic, l_i, w_i in zip(cross, momentum, (w1, w2, w3), strict=True):
            rates.append(gyroscopic + damping * (l_i * l_omega - w_i * l_square))
        return rates

    solution = Solution(field, [j * w for j, w in zip(inertia, omega0, strict=True)])
    for t in times:
        omega_body = {}
        for axis, component, j in zip("xyz", solution.at(t), inertia, strict=True):
            omega_body[f"omega_body.{axis}"] = component / j
        yield t, omega_body


WITNESSES = {
    "dissipating-body": Witness(
        "Taylor integration of L in principal axes at 58 digits, unproven"
        " (refdem/truth/witnesses/rotations.py)",
        damped,
    ),
    "free-rigid-body": Witness(METHOD, free),
    "intermediate-axis": Witness(METHOD, beside_axis),
}
