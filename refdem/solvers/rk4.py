"""Classical Runge-Kutta of fourth order (Kutta 1901) for points and spheres, its steps cut where a
contact begins or ends.
"""

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.scene.elements.spring import Spring
from refdem.solvers import _particles, _sliding
from refdem.solvers.solver import Solver


class RungeKutta(Solver):
    """Fourth order, through contacts too; neither symplectic nor reversible; momentum is kept,
    angular momentum is not.
    """

    claims = Method(
        name="rk4",
        summary="classical Runge-Kutta; steps end where a contact begins, sticks, slips or ends",
        control="step",
        order=4,
        order_with={"contact:hertz": 2},
        conserves=frozenset({"momentum"}),
        backward=True,
        locates_events=True,
        cost_rank=40,
    )
    kernels = (_particles.FAMILY,)

    def unsupported(self, problem: Motion) -> str | None:
        """The reason why the problem is unsupported, as for velocity Verlet; springs must also be
        smooth at their natural length.
        """
        if any(spring.exponent % 2 != 1 for spring in problem.scene.all(Spring)):
            return "a spring whose force is not smooth where it changes sign"
        return _particles.unsupported(problem) or _sliding.unsupported(problem.scene)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Fixed steps in the direction of time."""
        return _particles.run(request, request.signed_step, request.stride)


METHOD = RungeKutta()
