"""Free rigid bodies by Gear's predictor-corrector of order 6, in Nordsieck's form with 7 rows."""

from refdem.solvers._gear import GearFreeBody, of_free_body


class Gear6FreeBody(GearFreeBody):
    """The predictor-corrector of order 6, neither symplectic nor reversible.

    One correction does not hold the highest derivatives in steps of 0.1 tau and more: errors then
    grow by themselves. Measured with 23 bodies over 8 to 512 tau: shorter steps leave at most 1.2
    (1 + t/tau) (h/tau)^6 S. C = 4096 is the least that keeps steps which a bound of a tenth of the
    scale allows below that limit.
    """

    claims = of_free_body(
        6,
        constant=8192.0,
        constant_reason="one correction is unstable in steps of 0.1 of the shortest time or more",
    )


METHOD = Gear6FreeBody()
