"""A point on a spring whose force is a power of its stretch, m x'' + k |x|^n sgn x = 0, in closed
form (kernels/power_oscillator.c).
"""

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.scene.elements.spring import Spring
from refdem.solvers import _line
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, samples_from_start
from refdem.solvers._scene_pattern import ONE, ScenePattern


class ExactPower(KernelSolver):
    """The power-law oscillator, n > 1, through any number of zero crossings."""

    claims = Method(
        name="exact-power",
        summary="power-law oscillator in closed form: inverse incomplete beta functions",
        control="exact",
        conserves=frozenset({"energy"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=1,
    )
    kernels = ("power_oscillator",)

    pattern = ScenePattern(elements={Spring: ONE}, bodies=ONE, only_points=True)

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for one power above 1 of the stretch from natural length 0, else the reason."""
        spring = problem.scene.all(Spring)[0]
        other_terms = spring.length or spring.quadratic or spring.cubic
        if other_terms or not (spring.exponent > 1 and spring.stiffness > 0):
            return (
                "the spring does not pull with one power above 1 of its stretch from natural"
                " length 0"
            )
        return _line.askew(problem.scene)

    def prepare(self, request: Request) -> KernelCall:
        """The law and the start along the line; rows for x and v."""
        line = _line.line_of(request.problem.scene)
        law = (line.mass, line.spring.stiffness, line.spring.exponent)
        t = request.problem.times
        return KernelCall(
            function="refdem_power_oscillator",
            inputs=(*law, line.x0, line.v0),
            clock=samples_from_start(t),
            outputs=(np.empty((len(t), 2)),),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position and velocity at the samples."""
        x, v = call.outputs[0].T
        line = _line.line_of(request.problem.scene)
        return line.trajectory(request.problem.times, x, v)


METHOD = ExactPower()
