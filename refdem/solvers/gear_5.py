"""Points by Gear's predictor-corrector of order 5, in Nordsieck's form with 6 rows."""

from refdem.solvers._gear import GearPoints, of_points


class Gear5(GearPoints):
    """The predictor-corrector of order 5, neither symplectic nor reversible."""

    claims = of_points(5)


METHOD = Gear5()
