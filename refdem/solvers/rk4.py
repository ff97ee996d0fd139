"""The classical Runge-Kutta method of fourth order (Kutta 1901) for points and spheres, with steps
that are divided where a contact begins or ends.
"""

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.scene import Scene
from refdem.scene.elements.spring import Spring
from refdem.solvers import _particles, _sliding
from refdem.solvers._particles import Array


class RungeKutta(_particles.ParticleSolver):
    """Fourth order, also through contacts; neither symplectic nor reversible. It conserves
    momentum, but not angular momentum.
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
        cuts_steps=True,
        cost_rank=40,
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None if velocity Verlet supports the problem and springs are smooth at their natural
        length, else the reason.
        """
        if any(spring.exponent % 2 != 1 for spring in problem.scene.all(Spring)):
            return "a spring whose force is not smooth where it changes sign"
        return _particles.unsupported_values(problem) or _sliding.unsupported(problem.scene)

    def origin(self, scene: Scene) -> Array:
        """The origin of space, so that positions are not shifted."""
        return _particles.ORIGIN

    def stride(self, request: Request) -> int:
        """The number of steps per sample of the request."""
        return request.stride


METHOD = RungeKutta()
