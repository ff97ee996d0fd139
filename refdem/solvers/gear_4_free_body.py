"""Free rigid bodies by Gear's predictor-corrector of order 4, in Nordsieck's form with 5 rows."""

from refdem.solvers._gear import GearFreeBody, of_free_body


class Gear4FreeBody(GearFreeBody):
    """The predictor-corrector of order 4, neither symplectic nor reversible."""

    claims = of_free_body(4)


METHOD = Gear4FreeBody()
