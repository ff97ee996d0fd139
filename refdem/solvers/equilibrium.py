"""Bodies at rest on which the forces add up to zero: the state at all times is the initial one
(Newton 1687, law I).
"""

from time import perf_counter
from typing import Any

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import STATE, Cost, Trajectory
from refdem.scene import Polyhedron, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _balance, _particles
from refdem.solvers.solver import Solver


class Equilibrium(Solver):
    """Points and spheres whose forces add up to zero, and rigid bodies that stand in columns on a
    plane.
    """

    claims = Method(
        name="equilibrium",
        summary="the start itself, where every body is in balance",
        control="exact",
        conserves=frozenset({"energy", "momentum", "angular-momentum"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=0,
    )

    def unsupported(self, problem: Motion) -> str | None:
        """None if nothing moves and all forces balance, else the reason."""
        scene = problem.scene
        if np.any(scene.bodies.velocity) or np.any(scene.bodies.omega):
            return "something moves"
        laws = scene.all(Contact)
        if len(laws) == 1 and laws[0].law == "rigid" and scene.has_shapes():
            return _rigid_unsupported(scene, laws[0])
        return _particles.unsupported(problem) or _balance.unbalanced(scene)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """The initial state at every sample; no work is dissipated."""
        bodies = request.problem.scene.bodies
        times = request.problem.times
        started = perf_counter()
        state: Any = {
            name: np.repeat(getattr(bodies, name)[None], len(times), axis=0) for name in STATE
        }
        seconds = perf_counter() - started
        channels = {"dissipated_work": np.zeros(len(times))}
        return Trajectory(t=times, channels=channels, **state), Cost(seconds=seconds)


def _rigid_unsupported(scene: Scene, law: Contact) -> str | None:
    """None if the rigid bodies stand stably, else the reason."""
    others = [e.kind for e in scene.elements if not isinstance(e, Contact | Plane | UniformGravity)]
    if others:
        return f"{others[0]} beside rigid contacts"
    if not all(isinstance(shape, Polyhedron | Sphere) for shape in scene.bodies.shape):
        return "a point stands on nothing"
    return _balance.falling(scene, law)


METHOD = Equilibrium()
