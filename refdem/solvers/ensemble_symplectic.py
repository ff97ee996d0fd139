"""Many starts of one plane pendulum, stepped together by a composition of order 8, which is cheaper
than that of order 10 for errors above 1e-11.
"""

from refdem.solvers._ensemble_symplectic import EnsembleSymplectic, claimed


class Order8(EnsembleSymplectic):
    """The composition of order 8."""

    claims = claimed("ensemble-symplectic", 8)


METHOD = Order8()
