"""A point that moves along the axis of a piecewise linear field, in closed form phase by phase
(kernels/piecewise_field.c).
"""

from time import perf_counter

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import load, pointer
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.solvers.solver import Solver


class ExactPiecewiseField(Solver):
    """Free flight, a hyperbola, an ellipse, free flight."""

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

    def unsupported(self, problem: Motion) -> str | None:
        """None for one free point, nothing but one such field, and a velocity along its axis."""
        scene = problem.scene
        bodies = problem.scene.bodies
        if len(scene.elements) != 1 or not isinstance(scene.elements[0], PiecewiseField):
            return "something else than one piecewise linear field"
        if len(bodies) != 1 or bodies.fixed.any() or np.any(bodies.omega):
            return "not one free body that does not turn"
        across = np.cross(bodies.velocity[0], scene.elements[0].axis)
        if np.linalg.norm(across) > 1e-15 * np.linalg.norm(bodies.velocity[0]):
            return "it moves across the axis of the field"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """States at the samples; a run backwards is one with flipped velocities."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        field = scene.all(PiecewiseField)[0]
        axis = np.array(field.axis)
        sense = float(np.sign(request.problem.interval))
        place = float((scene.bodies.position[0] - field.point) @ axis)
        speed = sense * float(scene.bodies.velocity[0] @ axis)
        since = sense * (t - t[0])
        out = np.empty((len(t), 2))
        numbers = (
            float(scene.bodies.mass[0]),
            field.k1,
            field.k2,
            field.x1,
            field.x2,
            place,
            speed,
        )
        kernel = load("piecewise_field").lib
        times = pointer("piecewise_field", since)
        target = pointer("piecewise_field", out, output=True)
        started = perf_counter()
        kernel.refdem_piecewise_field(*numbers, len(t), times, target)
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        position = scene.bodies.position + (out[:, :1, None] - place) * axis
        velocity = scene.bodies.velocity + sense * (out[:, 1:, None] - speed) * axis
        return Trajectory.of_points(t, position, velocity), cost


METHOD = ExactPiecewiseField()
