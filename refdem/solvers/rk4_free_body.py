"""Free rigid bodies by the classical Runge-Kutta method (Kutta 1901), in the quaternion and the
angular momentum in body axes.
"""

from refdem.core.engine import Method
from refdem.solvers._free_bodies import SteppedFreeBodies


class Rk4FreeBody(SteppedFreeBodies):
    """Order 4, neither symplectic nor reversible: a method to compare with others.

    q' = q w/2,   L' = L x w with w = J^-1 L, in body axes.
    """

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
