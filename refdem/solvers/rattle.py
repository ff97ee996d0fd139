"""Points on rods, in uniform gravity and on springs, by RATTLE: velocity Verlet with constraints on
positions and velocities (kernels/rattle.c; Andersen 1983).

With the constraint Jacobian G and multipliers lambda and mu a step h is

    v += h/2 a,   x += h v,   x -= M^-1 G^T lambda and v -= M^-1 G^T lambda/h so that |d_r| = l_r,
    v += h/2 a,   v -= M^-1 G^T mu so that G v = 0.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.errors import EngineError
from refdem.scene import Scene
from refdem.scene.element import Link
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import (
    KernelCall,
    KernelSolver,
    steps_of,
    steps_to_samples,
)
from refdem.solvers._scene_pattern import ANY, SOME, ScenePattern

Array = NDArray[np.float64]


class Rattle(KernelSolver):
    """Rods constrain positions and velocities; the reported rod force is the exact one of the
    sampled state.
    """

    claims = Method(
        name="rattle",
        summary="RATTLE: velocity Verlet with rods held in position and velocity to round-off",
        control="step",
        order=2,
        conserves=frozenset({"momentum", "angular-momentum", "constraint"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=20,
    )
    kernels = ("rattle",)

    pattern = ScenePattern(
        elements={Rod: SOME, Spring: ANY, UniformGravity: ANY},
        may_be_fixed=True,
        only_points=True,
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for springs whose force is one power of their stretch, else the reason."""
        if any(spring.quadratic or spring.cubic for spring in problem.scene.all(Spring)):
            return "a spring with a square or a cube"
        return None

    def prepare(self, request: Request) -> KernelCall:
        """Masses, gravity, rods and springs; arrays for work space, position, velocity and rod
        force.
        """
        scene = request.problem.scene
        n = len(scene.bodies)
        rods = scene.all(Rod)
        springs = scene.all(Spring)
        # A fixed body has infinite mass.
        mass = np.where(scene.bodies.fixed, np.inf, scene.bodies.mass)
        length = np.array([rod.length for rod in rods])
        law = np.array([(s.stiffness, s.length, s.exponent) for s in springs]).reshape(-1, 3)
        rod_fields = (len(rods), *_links(rods), length)
        spring_fields = (len(springs), *_links(springs), law)
        work_space = np.empty(9 * n + 8 * len(rods) + len(rods) ** 2)
        pivots = np.empty(len(rods), dtype=np.int64)
        return KernelCall(
            function="refdem_rattle",
            inputs=(n, mass, single.gravity(scene), *rod_fields, *spring_fields),
            clock=steps_to_samples(request),
            outputs=(work_space, pivots, *_recorded(scene, len(request.problem.times), len(rods))),
            steps=steps_of(request),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position, velocity and force [N] of every rod at the samples; raises EngineError if a
        step has no solution.
        """
        if status:
            raise EngineError(
                f"rattle: no multipliers hold the rods before sample {status - 1} at a step of"
                f" {request.step} s; take a smaller one"
            )
        _, _, position, velocity, force = call.outputs
        channels = {"rod_force": force}
        return Trajectory.of_points(request.problem.times, position, velocity, channels=channels)


def _links(links: "list[Rod] | list[Spring]") -> tuple[NDArray[np.int64], Array]:
    """Bodies at the ends (M, 2), -1 for the world, and anchors in the world (M, 3), as the kernel
    reads them.
    """
    all_links: list[Link] = list(links)
    pairs = [(link.a, max(link.b, -1)) for link in all_links]
    ends = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    anchors = np.array([link.anchor_b for link in all_links], dtype=float).reshape(-1, 3)
    return ends, anchors


def _recorded(scene: Scene, samples: int, rods: int) -> tuple[Array, Array, Array]:
    """Arrays for position and velocity (T, N, 3) with the start in row 0, and for rod forces (T,
    rods).
    """
    n = len(scene.bodies)
    position = np.empty((samples, n, 3))
    velocity = np.empty((samples, n, 3))
    position[0] = scene.bodies.position
    velocity[0] = np.where(scene.bodies.fixed[:, None], 0.0, scene.bodies.velocity)
    return position, velocity, np.empty((samples, rods))


METHOD = Rattle()
