"""Witnesses of spinning bodies: Euler's equations and qdot = q omega_body/2 by Taylor
integration.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.taylor import Solution
from refdem.truth.witnesses.testimony import Claimed, Said, Witness

METHOD = (
    "Taylor integration of Euler's equations and of qdot = q omega_body/2 at 58 digits, unproven"
    " (refdem/truth/witnesses/rotations.py)"
)


def rates(inertia: Sequence[arb]) -> Any:
    """The field of (omega_body, q)."""
    j1, j2, j3 = inertia

    def field(t: Any, y: Sequence[Any]) -> list[Any]:
        a, b, c, w, x, u, z = y
        spin = [b * c * ((j2 - j3) / j1), c * a * ((j3 - j1) / j2), a * b * ((j1 - j2) / j3)]
        turn = [
            -x * a - u * b - z * c,
            w * a + u * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - u * a,
        ]
        return spin + [part / 2 for part in turn]

    return field


def seen(y: Sequence[arb]) -> dict[str, arb]:
    """omega_body, omega, attitude (w >= 0) and R of a state, all from R = body to space."""
    omega = y[:3]
    if y[3] >= 0:
        q = y[3:]
    else:
        q = [-part for part in y[3:]]
    w = q[0]
    (x, u, z) = q[1:]
    turned = [
        [1 - 2 * (u * u + z * z), 2 * (x * u - w * z), 2 * (x * z + w * u)],
        [2 * (x * u + w * z), 1 - 2 * (x * x + z * z), 2 * (u * z - w * x)],
        [2 * (x * z - w * u), 2 * (u * z + w * x), 1 - 2 * (x * x + u * u)],
    ]
    found = {f"omega_body.{axis}": value for axis, value in zip("xyz", omega, strict=True)}
    found |= {
        f"omega.{axis}": sum((r * v for r, v in zip(row, omega, strict=True)), arb(0))
        for axis, row in zip("xyz", turned, strict=True)
    }
    found |= {f"attitude.{axis}": value for axis, value in zip("wxyz", q, strict=True)}
    return found | {
        f"R.{i}{j}": turned["xyz".index(i)]["xyz".index(j)] for i in "xyz" for j in "xyz"
    }


def tumbling(
    p: Mapping[str, Exact], omega: Sequence[arb], times: Sequence[Fraction], claimed: Claimed
) -> Said:
    """The motion of a free body with these initial rates."""
    q = [arb_of(part) for part in vector(p, "attitude")]
    size = sum((part * part for part in q), arb(0)).sqrt()
    found = Solution(
        rates([arb_of(part) for part in vector(p, "inertia")]),
        [*omega, *(part / size for part in q)],
    )
    for t in times:
        yield t, seen(found.at(t))
    if "period" in claimed:
        yield None, returned(found, claimed)


def returned(found: Solution, claimed: Claimed) -> dict[str, arb]:
    """The period of omega_body: when the component that changes fastest at the start is back; none
    of a motion that stands still.
    """
    start = found.at(Fraction(0))[:3]
    slopes = [abs(float(rate.mid())) for rate in found.field(arb(0), found.at(Fraction(0)))[:3]]
    which = slopes.index(max(slopes))
    if slopes[which] < 1e-3:
        return {}
    near = float(claimed["period"])
    return {"period": found.crossing(lambda y: y[which] - start[which], near, near / 256)}


def free(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The motion of a free body from omega_body of the case."""
    return tumbling(p, [arb_of(part) for part in vector(p, "omega_body")], times, claimed)


def beside_axis(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """The motion of a free body from omega_body plus `offset` times its size along the axis
    `direction`.
    """
    omega = [arb_of(part) for part in vector(p, "omega_body")]
    size = sum((part * part for part in omega), arb(0)).sqrt()
    omega[int(str(p["direction"])) - 1] += arb_of(number(p, "offset")) * size
    return tumbling(p, omega, times, claimed)


def damped(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Said:
    """Angular momentum L in principal axes: L' = L x (omega + c L x omega) with L x (L x omega) = L
    (L.omega) - omega |L|^2.
    """
    inertia, omega = (
        [arb_of(part) for part in vector(p, name)] for name in ("inertia", "omega_body")
    )
    damping = arb_of(number(p, "damping"))

    def field(t: Any, y: Sequence[Any]) -> list[Any]:
        a, b, c = y
        x, u, z = (part / j for part, j in zip(y, inertia, strict=True))
        along = a * x + b * u + c * z
        square = a * a + b * b + c * c
        turned = [b * z - c * u, c * x - a * z, a * u - b * x]
        return [
            part + damping * (own * along - rate * square)
            for part, own, rate in zip(turned, y, (x, u, z), strict=True)
        ]

    found = Solution(field, [j * w for j, w in zip(inertia, omega, strict=True)])
    for t in times:
        yield (
            t,
            {
                f"omega_body.{axis}": part / j
                for axis, part, j in zip("xyz", found.at(t), inertia, strict=True)
            },
        )


WITNESSES = {
    "dissipating-body": Witness(
        "Taylor integration of L in principal axes at 58 digits, unproven"
        " (refdem/truth/witnesses/rotations.py)",
        damped,
    ),
    "free-rigid-body": Witness(METHOD, free),
    "intermediate-axis": Witness(METHOD, beside_axis),
}
