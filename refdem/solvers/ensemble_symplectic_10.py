"""Many starts of one plane pendulum, stepped together by a composition of order 10, which is
cheaper than that of order 8 for errors below 1e-11.
"""

from refdem.solvers._ensemble_symplectic import EnsembleSymplectic, claimed


class Order10(EnsembleSymplectic):
    """The composition of order 10."""

    claims = claimed("ensemble-symplectic-10", 10)


METHOD = Order10()
