"""Collisions to round-off: extrapolation (Bulirsch and Stoer 1966) from event to event of the
contact law.
"""

from math import ceil, log2, pi, sqrt

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.solvers import _particles
from refdem.solvers.rk4 import METHOD as RK4
from refdem.solvers.solver import Solver


class ContactEvents(Solver):
    """Oblique, spinning, damped, rubbing collisions: contact, stick, slip and release are found to
    the last bits of the step.
    """

    claims = Method(
        name="contact-events",
        summary=(
            "extrapolated midpoint rule to round-off; contact, stick, slip and release as events"
        ),
        control="exact",
        conserves=frozenset({"momentum", "angular-momentum"}),
        backward=True,
        cost_rank=20,
    )
    kernels = (_particles.FAMILY,)

    def unsupported(self, problem: Motion) -> str | None:
        """Scenes with linear contact between shapes that can meet."""
        law = _particles.contact_of(problem.scene)
        if law is None:
            return "no shapes that can meet"
        if law.law != "linear":
            return f"contact law {law.law}: not smooth at its onset"
        return RK4.unsupported(problem)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Steps of at most a twentieth of the shortest contact; events inside a step are found by
        its ends.

        Places count from the middle of the shapes: far away their rounding would be what no step
        settles.
        """
        scene = request.problem.scene
        law = _particles.contact_of(scene)
        assert law is not None
        # Half a period of the lightest pair lasts pi sqrt(m/(2 k)).
        lightest = float(scene.bodies.mass.min())
        most = pi * sqrt(lightest / 2 / law.stiffness) / 20
        interval = request.problem.interval
        halvings = max(0, ceil(log2(abs(interval) / most)))
        stride = 2**halvings
        return _particles.run(request, interval / stride, stride, _particles.middle(scene))


METHOD = ContactEvents()
