"""Lorenz' equations x' = sigma (y - x), y' = x (rho - z) - y, z' = x y - beta z by validated
integration; their equilibria and the rate at which volumes shrink in closed form.

Theorem (Liouville): the determinant of the flow's derivative is exp(-(sigma + 1 + beta) t), because
the divergence of the field is the same everywhere.

Theorem (Routh-Hurwitz): at the two equilibria C+- beside the origin the characteristic polynomial
is l^3 + (sigma + beta + 1) l^2 + beta (sigma + rho) l + 2 beta sigma (rho - 1). For rho > 1 all its
coefficients are positive, and all roots are on the left exactly if the product of the middle two
exceeds the last: rho (sigma - beta - 1) < sigma (sigma + beta + 3). If sigma <= beta + 1 this
always holds, and the border does not exist.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of
from refdem.truth.exact import number, numbers, vector
from refdem.truth.refiner import Size
from refdem.truth.validated_flow import ValidatedFlow

WITNESS = (
    "Runge and Kutta's method extrapolated at 70 digits; mpmath's Taylor series; Liouville's"
    " determinant; equilibria and border from the field and its characteristic polynomial"
)


def hopf_rho(sigma: Fraction, beta: Fraction) -> Fraction | None:
    """The rho at which the equilibria C+- lose their stability; None if they never do."""
    # rho_H = sigma (sigma + beta + 3)/(sigma - beta - 1), if sigma > beta + 1.
    if sigma <= beta + 1:
        return None
    return sigma * (sigma + beta + 3) / (sigma - beta - 1)


def constants(sigma: Fraction, rho: Fraction, beta: Fraction) -> dict[str, arb]:
    """The rate at which volumes shrink, per unit of time; the places of the equilibria C+- where
    there are any, and the rho from which on they are unstable.

    C+- = (+-equilibrium_xy, +-equilibrium_xy, equilibrium_z); the third equilibrium is the origin.
    """
    # div f = -(sigma + 1 + beta);  C+- = (+-sqrt(beta (rho - 1)), +-sqrt(beta (rho - 1)), rho - 1)
    scalars = {"contraction_rate": arb_of(-(sigma + 1 + beta))}
    if rho > 1:
        scalars["equilibrium_xy"] = arb_of(beta * (rho - 1)).sqrt()
        scalars["equilibrium_z"] = arb_of(rho - 1)
    border = hopf_rho(sigma, beta)
    if border is not None:
        scalars["hopf_rho"] = arb_of(border)
    return scalars


def truth(p: Parameters, scale: Mapping[str, Size]) -> Truth:
    """The truth at parameters sigma, rho, beta, start, interval; `scale` of x, y and z.

    x, y and z at iterate t >= 0: after the time t interval.
    """
    sigma, rho, beta = numbers(p, "sigma", "rho", "beta").values()
    interval = number(p, "interval")

    def field(state: Sequence[Any]) -> list[Any]:
        """The rates of (x, y, z) by the number of the iterate: interval times those by the time."""
        x, y, z = state
        # dx/di = T sigma (y - x), dy/di = T (x (rho - z) - y), dz/di = T (x y - beta z), with T the
        # interval.
        return [
            interval * (sigma * (y - x)),
            interval * (x * (rho - z) - y),
            interval * (x * y - beta * z),
        ]

    return ValidatedFlow(
        field,
        list(vector(p, "start")),
        lambda state: dict(zip(("x", "y", "z"), state, strict=True)),
        scale,
        state=("x", "y", "z"),
        moved=(0, 1, 2),
        witness=WITNESS,
        constants=lambda flow: constants(sigma, rho, beta),
    )
