"""Free rigid bodies by exact rotations about the principal axes: half 1, half 2, whole 3, half 2, half 1 (Touma and Wisdom 1994)."""

from refdem.core.engine import Method
from refdem.solvers._free_bodies import SteppedFreeBodies


class SplittingFreeBody(SteppedFreeBodies):
    """Symmetric Strang splitting of the kinetic energy (McLachlan 1993; Reich 1994); L in space is kept to round-off."""

    claims = Method(
        name="splitting-free-body",
        summary="symmetric splitting of the free rigid body into exact rotations about its principal axes",
        control="step",
        order=2,
        conserves=frozenset({"momentum", "angular-momentum"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=20,
    )
    function = "refdem_rigid_body_splitting"


METHOD = SplittingFreeBody()
