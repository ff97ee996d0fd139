"""Many starts of one plane pendulum, stepped together to order 10: the cheaper one from errors of 1e-11 down."""

from refdem.solvers.ensemble_symplectic import EnsembleSymplectic

METHOD = EnsembleSymplectic("ensemble-symplectic-10", 10)
