"""A rigid block that slides from rest down a plane under gravity and Coulomb friction, with
constant acceleration.
"""

from time import perf_counter

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.scene import Polyhedron
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _balance
from refdem.solvers._scene_pattern import ANY, ONE, ScenePattern, SceneSolver


class ExactSlide(SceneSolver):
    """One polyhedron with a face on one plane; a block that friction holds is answered by the
    method `equilibrium`.
    """

    claims = Method(
        name="exact-slide",
        summary="constant acceleration down the plane, friction against it",
        control="exact",
        complete_state=False,
        cost_rank=1,
    )

    pattern = ScenePattern(
        elements={Contact: ONE, Plane: ONE, UniformGravity: ANY},
        bodies=ONE,
        shape=Polyhedron,
        law="rigid",
        may_spin=False,
        irreversible="the block slides from rest",
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a block at rest on a plane that is too steep for friction to hold it, and that
        does not tip over, else the reason.
        """
        scene = problem.scene
        if np.any(scene.bodies.velocity):
            return "the block moves at the start; expected one that slides from rest"
        load = _balance.pressed(scene)
        if isinstance(load, str):
            return load
        return _balance.tipping(scene, scene.all(Contact)[0], load)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """s = a t^2/2 down the steepest line of the plane, with a = g (sin - mu cos) and friction's
        work mu N s.
        """
        begun = perf_counter()
        scene = request.problem.scene
        times = request.problem.times
        load = _balance.pressed(scene)
        assert not isinstance(load, str)
        steepness = load.steepness
        # a = g sin - mu g cos = g sin (1 - mu/tan), along the component of gravity in the plane.
        acceleration = (1 - scene.all(Contact)[0].friction / steepness) * load.along
        started = perf_counter()
        t = (times - times[0])[:, None, None]
        bodies = scene.bodies
        # r = r0 + a t^2/2, v = a t.
        position = bodies.position + acceleration * (t * t / 2)
        velocity = acceleration * t
        seconds = perf_counter() - started
        # W = mu N |r - r0|, N = m g_n.
        friction = scene.all(Contact)[0].friction * load.pressing * bodies.mass[0]
        work = friction * np.linalg.norm(position - bodies.position, axis=-1)[:, 0]
        attitude_columns = {
            "attitude": np.repeat(bodies.attitude[None], len(times), axis=0),
            "omega": np.zeros_like(velocity),
        }
        trajectory = Trajectory(
            t=times,
            position=position,
            velocity=velocity,
            channels={"dissipated_work": work},
            **attitude_columns,
        )
        return trajectory, Cost(seconds=seconds, setup=started - begun)


METHOD = ExactSlide()
