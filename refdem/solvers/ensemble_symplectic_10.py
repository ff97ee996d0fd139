"""Many starts of one plane pendulum, stepped together to order 10: the cheaper one from errors of
1e-11 down.
"""

from refdem.solvers._ensemble_symplectic import EnsembleSymplectic, claimed


class Order10(EnsembleSymplectic):
    """The composition of order 10."""

    claims = claimed("ensemble-symplectic-10", 10)


METHOD = Order10()
