"""The same as lattice-verlet in whole numbers of 60 bits: sums so exact that energy does not drift in 1e8 steps."""

from dataclasses import replace

from refdem.solvers import lattice_verlet
from refdem.solvers.lattice_verlet import LatticeVerlet


class FixedPointVerlet(LatticeVerlet):
    """Finer than binary64 can show: states are rounded when they are read, so that only the run itself can go back exactly."""

    claims = replace(
        lattice_verlet.METHOD.claims,
        name="fixed-point-verlet",
        summary="Verlet's method in whole numbers of 60 bits, for runs of 1e8 steps",
        cost_rank=33,
    )
    bits = 60


METHOD = FixedPointVerlet()
