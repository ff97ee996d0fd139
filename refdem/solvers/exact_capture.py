"""A free point that a hook of the world catches at closest approach: a straight line, then a
circle.
"""

from time import perf_counter

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.scene.elements.catch import Catch
from refdem.solvers import _single_point as single
from refdem.solvers._scene_pattern import ONE, ScenePattern, SceneSolver

REACH = 1.0 + 1e-9
"""A mass that just reaches the hook is caught in any turned frame."""
ACROSS = 1e-12
"""Part of the speed along the line to the hook that is rounding: closest approach is now."""


class ExactCapture(SceneSolver):
    """What is not caught flies on; the force [N] of the hook is m v^2/d."""

    claims = Method(
        name="exact-capture",
        summary="straight flight, closest approach, circle: closed form",
        control="exact",
        conserves=frozenset({"energy", "angular-momentum"}),
        symplectic=True,
        cost_rank=0,
    )

    pattern = ScenePattern(
        elements={Catch: ONE},
        bodies=ONE,
        only_points=True,
        irreversible="the hook would have to let go, and nothing says where",
    )

    def unfit(self, problem: Motion) -> str | None:
        """None: every free point and every hook is done."""
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position, velocity and force at the samples; the catch is an event."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        hook = scene.all(Catch)[0]
        mass = scene.bodies.mass[0]
        arm = scene.bodies.position[0] - single.anchor(hook)
        v = scene.bodies.velocity[0]
        speed2 = v @ v
        speed = np.sqrt(speed2)
        # Closest approach: d/dt |arm + v t|^2 = 0 at t = -arm.v/v^2.
        along = arm @ v
        late = 0.0
        if speed2 > 0 and abs(along) > ACROSS * np.linalg.norm(arm) * speed:
            late = -along / speed2
        nearest = arm + v * late
        distance = float(np.linalg.norm(nearest))
        holds = late >= 0 and 0 < distance <= hook.radius * REACH
        # Before the catch: the straight line. After it: a circle of this radius at this speed.
        if holds:
            since = (t - t[0]) - late
        else:
            since = np.full(len(t), -1.0)
        caught = since > 0
        flight = np.where(since > 0, late, t - t[0])
        angle = np.zeros((len(t), 1))
        if distance:
            angle = np.where(caught, speed / distance * since, 0.0)[:, None]
        cosine = np.cos(angle)
        sine = np.sin(angle)
        radius = distance or 1.0
        if speed2 > 0:
            quarter_turn = distance / speed
        else:
            quarter_turn = 0.0
        ahead = v * quarter_turn
        on_line = arm + v * flight[:, None]
        on_circle = nearest * cosine + ahead * sine
        along_circle = v * cosine - nearest * (speed / radius) * sine
        place = np.where(caught[:, None], on_circle, on_line)
        velocity = np.where(caught[:, None], along_circle, v)
        force = np.where(since >= 0, mass * speed2 / radius, 0.0)
        events: tuple[Event, ...] = ()
        if holds and t[0] + late <= t[-1]:
            events = (Event(float(t[0] + late), "catch", 0),)
        cost = Cost(seconds=perf_counter() - begun)
        position = (place + single.anchor(hook))[:, None]
        channels = {"rod_force": force[:, None]}
        found = Trajectory.of_points(
            t, position, velocity[:, None], channels=channels, events=events
        )
        return found, cost


METHOD = ExactCapture()
