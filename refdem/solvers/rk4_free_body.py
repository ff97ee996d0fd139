"""Free rigid bodies by the classical Runge-Kutta method on the quaternion and the body's angular
momentum (Kutta 1901).
"""

from refdem.core.engine import Method
from refdem.solvers._free_bodies import SteppedFreeBodies


class Rk4FreeBody(SteppedFreeBodies):
    """Order 4, neither symplectic nor reversible: there to be measured."""

    claims = Method(
        name="rk4-free-body",
        summary="classical Runge-Kutta on the quaternion and the angular momentum in body axes",
        control="step",
        order=4,
        conserves=frozenset({"momentum"}),
        backward=True,
        cost_rank=30,
    )
    function = "refdem_rigid_body_rk4"


METHOD = Rk4FreeBody()
