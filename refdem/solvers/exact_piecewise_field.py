"""A point on the axis of a piecewise linear field, in closed form phase by phase
(kernels/piecewise_field.c).
"""

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.scene import Scene
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.solvers._kernel_solver import Elapsed, KernelCall, KernelSolver, samples
from refdem.solvers._scene_pattern import ONE, ScenePattern


class ExactPiecewiseField(KernelSolver):
    """Free flight, a hyperbolic phase on the rising flank of the force, a harmonic one on the
    falling flank, free flight.
    """

    claims = Method(
        name="exact-piecewise",
        summary="piecewise linear force in closed form, phase by phase",
        control="exact",
        conserves=frozenset({"energy"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=0,
    )
    kernels = ("piecewise_field",)

    pattern = ScenePattern(elements={PiecewiseField: ONE}, bodies=ONE, may_spin=False)

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a velocity along the field's axis, else the reason."""
        scene = problem.scene
        velocity = scene.bodies.velocity[0]
        across = np.cross(velocity, scene.all(PiecewiseField)[0].axis)
        if np.linalg.norm(across) > 1e-15 * np.linalg.norm(velocity):
            return "it moves across the axis of the field"
        return None

    def prepare(self, request: Request) -> KernelCall:
        """The field and the start along its axis; rows for position and velocity."""
        scene = request.problem.scene
        elapsed = Elapsed(request.problem)
        field = scene.all(PiecewiseField)[0]
        x0, v0 = _along(scene)
        law = (float(scene.bodies.mass[0]), field.k1, field.k2, field.x1, field.x2)
        return KernelCall(
            function="refdem_piecewise_field",
            inputs=(*law, x0, elapsed.sense * v0),
            clock=samples(elapsed.since),
            outputs=(np.empty((len(elapsed.since), 2)),),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """States at the samples; a run backward in time is one with velocities reversed."""
        scene = request.problem.scene
        bodies = scene.bodies
        sense = Elapsed(request.problem).sense
        x0, v0 = _along(scene)
        (rows,) = call.outputs
        axis = np.array(scene.all(PiecewiseField)[0].axis)
        position = bodies.position + (rows[:, :1, None] - x0) * axis
        velocity = bodies.velocity + sense * (rows[:, 1:, None] - sense * v0) * axis
        return Trajectory.of_points(request.problem.times, position, velocity)


def _along(scene: Scene) -> tuple[float, float]:
    """Position [m] from the field's reference point and velocity [m/s] at the start, both along the
    axis.
    """
    field = scene.all(PiecewiseField)[0]
    axis = np.array(field.axis)
    x0 = float((scene.bodies.position[0] - field.point) @ axis)
    return x0, float(scene.bodies.velocity[0] @ axis)


METHOD = ExactPiecewiseField()
