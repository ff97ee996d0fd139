"""Velocity Verlet for points and spheres: kick, drift, kick (Swope et al. 1982), with steps that
are divided where a contact begins or ends.

    v += h/2 F(r)/m,   r += h v,   v += h/2 F(r)/m.
"""

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.scene import Scene
from refdem.solvers import _particles
from refdem.solvers._particles import Array


class VelocityVerlet(_particles.ParticleSolver):
    """Second order, also through contacts; symplectic and reversible while no contact changes,
    reversible through contacts.

    Forces that depend on velocity (damping, friction) use a predicted velocity and one correction.
    Every pair force is computed once, so momentum is conserved to round-off, and total angular
    momentum where the lever arms add up to the centre distance.
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
        cuts_steps=True,
        cost_rank=30,
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None if the kernel supports all springs, bodies and contacts, else the reason."""
        return _particles.unsupported_values(problem)

    def origin(self, scene: Scene) -> Array:
        """The origin of space, so that positions are not shifted."""
        return _particles.ORIGIN

    def stride(self, request: Request) -> int:
        """The number of steps per sample of the request."""
        return request.stride


METHOD = VelocityVerlet()
