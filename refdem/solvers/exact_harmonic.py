"""A point on a linear spring of natural length 0, with or without uniform gravity, in closed form
(kernels/oscillator.c).

m r'' = -k (r - anchor) + m g: harmonic motion about anchor + m g/k.
"""

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, samples_from_start
from refdem.solvers._scene_pattern import ANY, ONE, ScenePattern


class ExactHarmonic(KernelSolver):
    """Harmonic motion along a line or on an ellipse about the equilibrium."""

    claims = Method(
        name="exact-harmonic",
        summary="harmonic motion in closed form, its phase in double-double",
        control="exact",
        conserves=frozenset({"energy"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=0,
    )
    kernels = ("oscillator",)

    pattern = ScenePattern(
        elements={Spring: ONE, UniformGravity: ANY}, bodies=ONE, only_points=True
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a linear spring of natural length 0, else the reason."""
        spring = problem.scene.all(Spring)[0]
        if spring.length or not single.is_linear(spring) or not spring.stiffness > 0:
            return "the spring is not linear from natural length 0"
        return None

    def prepare(self, request: Request) -> KernelCall:
        """The law and the start; arrays for position and velocity."""
        scene = request.problem.scene
        t = request.problem.times
        spring = scene.all(Spring)[0]
        bodies = scene.bodies
        law = (bodies.mass[0], spring.stiffness, single.gravity(scene), single.anchor(spring))
        return KernelCall(
            function="refdem_harmonic",
            inputs=(*law, bodies.position[0], bodies.velocity[0]),
            clock=samples_from_start(t),
            outputs=(np.empty((len(t), 1, 3)), np.empty((len(t), 1, 3))),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position and velocity at the samples."""
        position, velocity = call.outputs
        return Trajectory.of_points(request.problem.times, position, velocity)


METHOD = ExactHarmonic()
