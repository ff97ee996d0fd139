"""A free point that a hook catches at closest approach: a straight line, then a circle about the
hook.

r(t) = r0 + v t until t_c = -r0.v/v^2, where r.v = 0; then a circle of radius d = |r(t_c)| at the
same speed, if d is within the hook's radius.
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
"""Factor on the hook's radius: a mass that just reaches it is caught in any rotated frame."""
ACROSS = 1e-12
"""Relative radial velocity that is rounding: closest approach is at the start."""


class ExactCapture(SceneSolver):
    """Straight flight, or circular motion with the hook's force m v^2/d [N]."""

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
        """None: every free point and every hook are supported."""
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
        radial = arm @ v
        catch_time = 0.0
        if speed2 > 0 and abs(radial) > ACROSS * np.linalg.norm(arm) * speed:
            catch_time = -radial / speed2
        nearest = arm + v * catch_time
        distance = float(np.linalg.norm(nearest))
        is_caught = catch_time >= 0 and 0 < distance <= hook.radius * REACH
        # Before the catch: the straight line. After it: a circle of this radius at this speed.
        if is_caught:
            since = (t - t[0]) - catch_time
        else:
            since = np.full(len(t), -1.0)
        after_catch = since > 0
        flight_time = np.where(since > 0, catch_time, t - t[0])
        angle = np.zeros((len(t), 1))
        if distance:
            angle = np.where(after_catch, speed / distance * since, 0.0)[:, None]
        cosine = np.cos(angle)
        sine = np.sin(angle)
        radius = distance or 1.0
        if speed2 > 0:
            quarter_turn = distance / speed
        else:
            quarter_turn = 0.0
        # r = nearest cos(angle) + ahead sin(angle): `ahead` is where the point is after a quarter
        # turn, v d/|v|.
        quarter_turn_ahead = v * quarter_turn
        on_line = arm + v * flight_time[:, None]
        on_circle = nearest * cosine + quarter_turn_ahead * sine
        along_circle = v * cosine - nearest * (speed / radius) * sine
        offset = np.where(after_catch[:, None], on_circle, on_line)
        velocity = np.where(after_catch[:, None], along_circle, v)
        force = np.where(since >= 0, mass * speed2 / radius, 0.0)
        events: tuple[Event, ...] = ()
        if is_caught and t[0] + catch_time <= t[-1]:
            events = (Event(float(t[0] + catch_time), "catch", 0),)
        cost = Cost(seconds=perf_counter() - begun)
        position = (offset + single.anchor(hook))[:, None]
        channels = {"rod_force": force[:, None]}
        trajectory = Trajectory.of_points(
            t, position, velocity[:, None], channels=channels, events=events
        )
        return trajectory, cost


METHOD = ExactCapture()
