"""A point on a linear spring of natural length 0 to the world, in uniform gravity or none, in
closed form (kernels/oscillator.c).
"""

from time import perf_counter

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import load, pointer
from refdem.scene.elements.spring import Spring
from refdem.solvers import _single_point as single
from refdem.solvers.solver import Solver


class ExactHarmonic(Solver):
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

    def unsupported(self, problem: Motion) -> str | None:
        """None for one point on one spring to the world, linear and of natural length 0."""
        scene = problem.scene
        reason = single.unsupported(scene, Spring)
        if reason:
            return reason
        spring = scene.all(Spring)[0]
        if scene.bodies.fixed.any():
            return "the spring does not pull towards a place in the world"
        if spring.length or not single.is_linear(spring) or not spring.stiffness > 0:
            return "the spring is not linear from natural length 0"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position and velocity at the samples."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        spring = scene.all(Spring)[0]
        given = (
            single.gravity(scene),
            single.anchor(spring),
            scene.bodies.position[0].copy(),
            scene.bodies.velocity[0].copy(),
        )
        position = np.empty((len(t), 1, 3))
        velocity = np.empty((len(t), 1, 3))
        columns = [pointer("oscillator", column) for column in given]
        samples = pointer("oscillator", t)
        out = [pointer("oscillator", column, output=True) for column in (position, velocity)]
        law = (scene.bodies.mass[0], spring.stiffness)
        lib = load("oscillator").lib
        started = perf_counter()
        lib.refdem_harmonic(*law, *columns, t[0], len(t), samples, *out)
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        return Trajectory.of_points(t, position, velocity), cost


METHOD = ExactHarmonic()
