"""A free point that a hook catches at closest approach: a straight line, then a circle about the
hook, in closed form.

r(t) = r0 + v t until t_c = -r0.v/v^2, where r.v = 0; then a circle of radius d = |r(t_c)| at the
same speed, if d is within the hook's radius.
"""

from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.scene.elements.catch import Catch
from refdem.solvers import _single_point as single
from refdem.solvers._scene_pattern import ONE, ScenePattern, SceneSolver

Array = NDArray[np.float64]

HOOK_RADIUS_TOLERANCE = 1.0 + 1e-9
"""Factor on the hook's radius: a mass that just reaches it is caught in any rotated frame."""
RADIAL_TOLERANCE = 1e-12
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

    def unsupported_values(self, problem: Motion) -> str | None:
        """None: every free point and every hook are supported."""
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position, velocity and force at the samples; the catch is an event."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        hook = scene.all(Catch)[0]
        arm = scene.bodies.position[0] - single.anchor(hook)
        v = scene.bodies.velocity[0]
        speed2 = v @ v
        speed = np.sqrt(speed2)
        # Closest approach: d/dt |arm + v t|^2 = 0 at t = -arm.v/v^2.
        radial = arm @ v
        catch_time = 0.0
        if speed2 > 0 and abs(radial) > RADIAL_TOLERANCE * np.linalg.norm(arm) * speed:
            catch_time = -radial / speed2
        nearest = arm + v * catch_time
        distance = float(np.linalg.norm(nearest))
        is_caught = catch_time >= 0 and 0 < distance <= hook.radius * HOOK_RADIUS_TOLERANCE
        # Time since the catch; negative throughout if there is none.
        since = np.full(len(t), -1.0)
        if is_caught:
            since = (t - t[0]) - catch_time
        after_catch = (since > 0)[:, None]
        # r = arm + v t before the catch, and a circle at the same speed after it.
        flight_time = np.where(since > 0, catch_time, t - t[0])
        on_line = arm + v * flight_time[:, None]
        on_circle, along_circle = _circle(nearest, v, np.maximum(since, 0.0))
        offset = np.where(after_catch, on_circle, on_line)
        velocity = np.where(after_catch, along_circle, v)
        # F = m v^2/d on the circle of radius d. A point that hits the hook itself (d = 0) is not
        # caught; 1 then avoids a division by zero.
        radius = distance
        if radius == 0:
            radius = 1.0
        force = np.where(since >= 0, scene.bodies.mass[0] * speed2 / radius, 0.0)
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


def _circle(nearest: Array, v: Array, since: Array) -> tuple[Array, Array]:
    """Position and velocity (T, 3) on the circle about the hook, at times `since` >= 0 the catch.

    r = nearest cos(angle) + ahead sin(angle), where `ahead` = v d/|v| is the point's position after
    a quarter turn, d = |nearest| the radius and angle = |v| since/d.
    """
    speed = np.sqrt(v @ v)
    distance = float(np.linalg.norm(nearest))
    # r = nearest cos(angle) + ahead sin(angle), v = v0 cos(angle) - nearest rate sin(angle), with
    # rate = |v|/d and angle = rate since.
    angle = np.zeros((len(since), 1))
    rate = speed
    if distance > 0:
        rate = speed / distance
        angle = (rate * since)[:, None]
    ahead = v * 0.0
    if speed > 0:
        ahead = v * (distance / speed)
    cosine = np.cos(angle)
    sine = np.sin(angle)
    position = nearest * cosine + ahead * sine
    velocity = v * cosine - nearest * rate * sine
    return position, velocity


METHOD = ExactCapture()
