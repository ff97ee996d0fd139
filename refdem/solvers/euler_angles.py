"""Free rigid bodies by the classical Runge-Kutta method (Kutta 1901), in Euler's angles and the
angular momentum in body axes.
"""

from refdem.core.engine import Method
from refdem.solvers._free_bodies import SteppedFreeBodies


class EulerAngles(SteppedFreeBodies):
    """Order 4, neither symplectic nor reversible: a method to compare with those in quaternions.

    The rates of the angles diverge where sin theta = 0 (1.39 to 1.41). Every step uses the one of
    two frames of axes in which the body's z axis is at least 45 degrees from the pole (Allen and
    Tildesley, Computer Simulation of Liquids).
    """

    claims = Method(
        name="euler-angles",
        summary=(
            "classical Runge-Kutta on Euler angles, in one of two frames of axes, and the angular"
            " momentum in body axes"
        ),
        control="step",
        order=4,
        conserves=frozenset({"momentum"}),
        backward=True,
        cost_rank=40,
    )
    function = "refdem_rigid_body_euler_angles"


METHOD = EulerAngles()
