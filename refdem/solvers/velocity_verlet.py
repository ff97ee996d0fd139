"""Velocity Verlet for points and spheres: kick, drift, kick (Swope et al. 1982), its steps cut
where a contact begins or ends.
"""

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.solvers import _particles
from refdem.solvers.solver import Solver


class VelocityVerlet(Solver):
    """Second order, symplectic and reversible while no contact changes; second order and reversible
    through contacts.

    Damping and friction get a predicted velocity and one correction. Every pair force is computed
    once, so that momentum is kept to round-off, and total angular momentum where the lever arms add
    up to the centre distance.
    """

    claims = Method(
        name="velocity-verlet",
        summary=(
            "velocity Verlet; damping by one correction; steps end where a contact begins, sticks,"
            " slips or ends"
        ),
        control="step",
        order=2,
        conserves=frozenset({"momentum", "angular-momentum"}),
        reversible=True,
        symplectic=True,
        backward=True,
        locates_events=True,
        cost_rank=30,
    )
    kernels = (_particles.FAMILY,)

    def unsupported(self, problem: Motion) -> str | None:
        """Points and spheres under springs, gravity, a central field and linear contact."""
        return _particles.unsupported(problem)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Fixed steps in the direction of time."""
        return _particles.run(request, request.signed_step, request.stride)


METHOD = VelocityVerlet()
