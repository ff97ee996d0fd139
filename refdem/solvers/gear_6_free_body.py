"""Free rigid bodies by Gear's predictor-corrector of order 6, in Nordsieck's form with 7 rows."""

from refdem.solvers._gear import GearFreeBody, of_free_body


class Gear6FreeBody(GearFreeBody):
    """The predictor-corrector of order 6, neither symplectic nor reversible.

    With one correction a step the method is unstable for steps h >= 0.1 tau. Measured with 23
    bodies over 8 to 512 tau: for smaller steps the error is at most 1.2 (1 + t/tau) (h/tau)^6 S.
    The claimed constant C = 8192 is larger, because of the unstable steps: a bound C (1 + t/tau)
    (h/tau)^6 of at most 1/10 then requires h < 0.106 tau at t = 8 tau, and less at later times.
    """

    claims = of_free_body(
        6,
        constant=8192.0,
        constant_reason="one correction is unstable in steps of 0.1 of the shortest time or more",
    )


METHOD = Gear6FreeBody()
