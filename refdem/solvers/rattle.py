"""Points on rods in uniform gravity and on springs: velocity Verlet with constraints, RATTLE
(kernels/rattle.c).
"""

from time import perf_counter
from typing import Any

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.errors import EngineError
from refdem.kernels import load, pointer
from refdem.scene import Scene
from refdem.scene.element import Link
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers.solver import Solver


class Rattle(Solver):
    """Rods are held in position and in velocity; the rod force is that of the sampled state."""

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

    def unsupported(self, problem: Motion) -> str | None:
        """None for points with at least one rod; springs and gravity are welcome."""
        scene = problem.scene
        others = [
            element.kind
            for element in scene.elements
            if not isinstance(element, Rod | Spring | UniformGravity)
        ]
        if others:
            return f"{others[0]} is not a rod, a spring or gravity"
        if not scene.all(Rod):
            return "no rod: velocity Verlet needs no constraints"
        if any(spring.quadratic or spring.cubic for spring in scene.all(Spring)):
            return "a spring with a square or a cube"
        return single.turning(scene)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position, velocity and the force [N] of every rod after each `stride` steps."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        n = len(scene.bodies)
        rods = scene.all(Rod)
        springs = scene.all(Spring)
        mass = np.where(scene.bodies.fixed, np.inf, scene.bodies.mass)
        length = np.array([rod.length for rod in rods])
        law = np.array([(s.stiffness, s.length, s.exponent) for s in springs]).reshape(-1, 3)
        work = np.empty(9 * n + 9 * len(rods) + len(rods) ** 2)
        position, velocity, force = _room(scene, len(t), len(rods))
        bodies = (n, _doubles(mass), _doubles(single.gravity(scene)))
        held = (len(rods), *_links(rods), _doubles(length))
        sprung = (len(springs), *_links(springs), _doubles(law))
        clock = (request.signed_step, len(t), request.stride)
        out = [
            pointer("rattle", column, output=True) for column in (work, position, velocity, force)
        ]
        started = perf_counter()
        failed = load("rattle").lib.refdem_rattle(*bodies, *held, *sprung, *clock, *out)
        cost = Cost(
            seconds=perf_counter() - started,
            setup=started - begun,
            steps=request.stride * (len(t) - 1),
        )
        if failed:
            raise EngineError(
                f"rattle: no multipliers hold the rods before sample {failed - 1} at a step of"
                f" {request.step} s; take a smaller one"
            )
        return Trajectory.of_points(t, position, velocity, channels={"rod_force": force}), cost


def _doubles(values: Any) -> Any:
    return pointer("rattle", values)


def _links(links: "list[Rod] | list[Spring]") -> tuple[Any, Any]:
    """Ends (M, 2) and world anchors (M, 3) as the kernel reads them."""
    every: list[Link] = list(links)
    pairs = [(link.a, max(link.b, -1)) for link in every]
    ends = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    anchors = np.array([link.anchor_b for link in every], dtype=float).reshape(-1, 3)
    return load("rattle").ffi.from_buffer("int64_t[]", ends), _doubles(anchors)


def _room(scene: Scene, samples: int, rods: int) -> tuple[Any, Any, Any]:
    """Arrays for position, velocity (T, N, 3) with the start in row 0, and force (T, rods)."""
    n = len(scene.bodies)
    position = np.empty((samples, n, 3))
    velocity = np.empty((samples, n, 3))
    position[0] = scene.bodies.position
    velocity[0] = np.where(scene.bodies.fixed[:, None], 0.0, scene.bodies.velocity)
    return position, velocity, np.empty((samples, rods))


METHOD = Rattle()
