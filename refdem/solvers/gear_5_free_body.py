"""Free rigid bodies by Gear's predictor-corrector of order 5, in Nordsieck's form with 6 rows."""

from refdem.solvers._gear import GearFreeBody, of_free_body


class Gear5FreeBody(GearFreeBody):
    """The predictor-corrector of order 5, neither symplectic nor reversible.

    With one correction a step the method is unstable for steps h >= 0.2 tau. Measured with 23
    bodies over 8 to 512 tau: for smaller steps the error is at most 1 (1 + t/tau) (h/tau)^5 S.
    The claimed constant C = 32 is larger, because of the unstable steps: a bound C (1 + t/tau)
    (h/tau)^5 of at most 1/10 then requires h < 0.204 tau at t = 8 tau, and less at later times.
    """

    claims = of_free_body(
        5,
        constant=32.0,
        constant_reason="one correction is unstable in steps of 0.2 of the shortest time or more",
    )


METHOD = Gear5FreeBody()
