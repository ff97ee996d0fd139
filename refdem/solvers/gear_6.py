"""Points by Gear's predictor-corrector of order 6, in Nordsieck's form with 7 rows."""

from refdem.solvers._gear import GearPoints, of_points


class Gear6(GearPoints):
    """The predictor-corrector of order 6, neither symplectic nor reversible."""

    claims = of_points(6)


METHOD = Gear6()
