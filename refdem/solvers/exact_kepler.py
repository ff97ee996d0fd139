"""A point on a bound orbit in a central field, in closed form: Kepler's equation
(kernels/kepler.c).
"""

from time import perf_counter

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import load, pointer, prepared, timed
from refdem.scene import Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers.solver import Solver


class ExactKepler(Solver):
    """Ellipses of any eccentricity below 1."""

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

    def unsupported(self, problem: Motion) -> str | None:
        """None for one point on a bound orbit about one centre."""
        scene = problem.scene
        reason = single.unsupported(scene, CentralField)
        if reason:
            return reason
        if scene.all(UniformGravity) or scene.bodies.fixed.any():
            return "more than the central field acts on the point"
        return _unbound(scene)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position and velocity at the samples."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        gm = scene.all(CentralField)[0].gm
        bodies = scene.bodies
        start = [pointer("kepler", bodies.position[0].copy())]
        start.append(pointer("kepler", bodies.velocity[0].copy()))
        position = np.empty((len(t), 1, 3))
        velocity = np.empty((len(t), 1, 3))
        out = [pointer("kepler", column, output=True) for column in (position, velocity)]
        lib = load("kepler").lib
        motion = prepared("kepler")
        lib.refdem_kepler_prepare(gm, *start, t[0], len(t), pointer("kepler", t), *out, motion)
        started = perf_counter()
        seconds = timed(lib.refdem_kepler_run, motion)
        cost = Cost(seconds=seconds, setup=started - begun)
        return Trajectory.of_points(t, position, velocity), cost


def _unbound(scene: Scene) -> str | None:
    """None if the point comes back and misses the centre."""
    gm = scene.all(CentralField)[0].gm
    position = scene.bodies.position[0]
    velocity = scene.bodies.velocity[0]
    distance = float(np.linalg.norm(position))
    square = float(velocity @ velocity)
    # r/a = 2 - r v^2/gm by the energy, and 1 - e^2 = L^2 (r/a)/(r gm).
    if distance > 0:
        inverse = 2.0 - distance * square / gm
    else:
        inverse = -1.0
    if inverse <= 1e-9:
        return "the orbit is not bound"
    moment = np.cross(position, velocity)
    flatness = float(moment @ moment) * inverse / (distance * gm)
    if flatness <= 1e-9:
        return "the orbit goes through the centre"
    return None


METHOD = ExactKepler()
