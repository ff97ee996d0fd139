"""The witness of Lorenz' equations: Taylor integration at many digits, without any proof."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import ceil
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of, precision
from refdem.truth.exact import number, vector
from refdem.truth.witnesses.cross_check import Claimed, Results, Witness
from refdem.truth.witnesses.taylor import BITS, Solution

METHOD = "Taylor integration at many digits, unproven (refdem/truth/witnesses/lorenz.py)"


def of_lorenz(p: Mapping[str, Exact], times: Sequence[Fraction], claimed: Claimed) -> Results:
    """The states by Taylor integration, and the claimed scalars (`scalars`)."""
    # The largest Lyapunov exponent, about 0.9, costs about 1.3 bits a unit of time.
    last = float(max(times, default=Fraction(0)) * number(p, "interval"))
    bits = BITS + 2 * ceil(last)
    with precision(bits):
        sigma, rho, beta, interval = (
            arb_of(number(p, name)) for name in ("sigma", "rho", "beta", "interval")
        )

        def rates(t: Any, state: Sequence[Any]) -> list[Any]:
            """The rates x', y' and z' at a state."""
            x, y, z = state
            return [y * sigma - x * sigma, x * rho - x * z - y, x * y - z * beta]

        solution = Solution(rates, [arb_of(value) for value in vector(p, "start")], bits=bits)
        for t in times:
            yield t, dict(zip(("x", "y", "z"), solution.at(arb_of(t) * interval), strict=True))
        yield None, scalars(sigma, rho, beta, claimed)


def scalars(sigma: arb, rho: arb, beta: arb, claimed: Claimed) -> dict[str, arb]:
    """The scalars that are claimed, each from the equation that defines it."""
    # div f = -sigma - 1 - beta, the trace of the Jacobian of the field.
    values = {"contraction_rate": -sigma - 1 - beta}
    if "equilibrium_z" in claimed:
        # x' = 0 at x = y; y' = x (rho - z) - x = 0 at z = rho - 1; z' = x^2 - beta z = 0.
        z = rho - 1
        values["equilibrium_z"] = z
        values["equilibrium_xy"] = (beta * z).sqrt()
    if "hopf_rho" in claimed:
        # l^3 + a l^2 + b l + c has roots +-i w exactly if a b = c. With a = sigma + beta + 1,
        # b = beta (sigma + rho), c = 2 beta sigma (rho - 1), the difference a b - c is linear in
        # rho: its zero from its values at rho = 0 and rho = 1.
        a = sigma + beta + 1
        at_0 = a * beta * sigma + 2 * beta * sigma
        at_1 = a * beta * (sigma + 1)
        values["hopf_rho"] = at_0 / (at_0 - at_1)
    return values


WITNESSES = {"lorenz": Witness(METHOD, of_lorenz)}
