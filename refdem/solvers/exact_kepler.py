"""A point on a bound orbit in a central field, in closed form by Kepler's equation
(kernels/kepler.c): M = E - e sin E with the mean anomaly M = M0 + n (t - t0).
"""

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.scene import Scene
from refdem.scene.elements.central_field import CentralField
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, samples_from_start
from refdem.solvers._scene_pattern import ONE, ScenePattern


class ExactKepler(KernelSolver):
    """Elliptical orbits of any eccentricity below 1."""

    claims = Method(
        name="exact-kepler",
        summary="bound Kepler orbits in closed form, the mean anomaly in double-double",
        control="exact",
        conserves=frozenset({"energy", "angular-momentum"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=0,
    )
    kernels = ("kepler",)

    pattern = ScenePattern(elements={CentralField: ONE}, bodies=ONE, only_points=True)

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a bound orbit that misses the centre, else the reason."""
        return _unbound(problem.scene)

    def prepare(self, request: Request) -> KernelCall:
        """The field, the start, and columns for position and velocity."""
        scene = request.problem.scene
        t = request.problem.times
        bodies = scene.bodies
        return KernelCall(
            function="refdem_kepler",
            inputs=(scene.all(CentralField)[0].gm, bodies.position[0], bodies.velocity[0]),
            clock=samples_from_start(t),
            outputs=(np.empty((len(t), 1, 3)), np.empty((len(t), 1, 3))),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position and velocity at the samples."""
        position, velocity = call.outputs
        return Trajectory.of_points(request.problem.times, position, velocity)


def _unbound(scene: Scene) -> str | None:
    """None if the orbit is bound and misses the centre, else the reason."""
    gm = scene.all(CentralField)[0].gm
    position = scene.bodies.position[0]
    velocity = scene.bodies.velocity[0]
    distance = float(np.linalg.norm(position))
    speed2 = float(velocity @ velocity)
    # With the semi-major axis a: r/a = 2 - r v^2/gm from the energy, and
    # 1 - e^2 = L^2/(a gm) = L^2 (r/a)/(r gm) from the angular momentum L per mass.
    if distance > 0:
        distance_over_a = 2.0 - distance * speed2 / gm
    else:
        distance_over_a = -1.0
    if distance_over_a <= 1e-9:
        return "the orbit is not bound"
    momentum = np.cross(position, velocity)
    one_minus_e2 = float(momentum @ momentum) * distance_over_a / (distance * gm)
    if one_minus_e2 <= 1e-9:
        return "the orbit goes through the centre"
    return None


METHOD = ExactKepler()
