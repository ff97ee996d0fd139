"""Points by Gear's predictor-corrector of order 4, in Nordsieck's form with 5 rows."""

from refdem.solvers._gear import GearPoints, of_points


class Gear4(GearPoints):
    """The predictor-corrector of order 4, neither symplectic nor reversible."""

    claims = of_points(4)


METHOD = Gear4()
