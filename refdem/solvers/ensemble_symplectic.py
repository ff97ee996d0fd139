"""Many starts of one plane pendulum, stepped together to order 8: the cheaper one down to errors of
1e-11.
"""

from refdem.solvers._ensemble_symplectic import EnsembleSymplectic, claimed


class Order8(EnsembleSymplectic):
    """The composition of order 8."""

    claims = claimed("ensemble-symplectic", 8)


METHOD = Order8()
