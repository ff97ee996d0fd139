"""Scenes for the steps of a program: does it count them from sample to sample, or does it compare
times?

A clock that is the sum of its steps is rounded. Where the step has few binary digits the sum is
exact, and `while t < until` works; where it has many, the sum falls short of some samples and
passes others, and such a program takes one step too many or too few.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.scene import Body, Scene
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.smoke.probes import INTERVAL

Array = NDArray[np.float64]

SAMPLES = 32
"""Intervals of a clock probe: enough of them for a clock that rounds to miscount."""
ROUND = (INTERVAL, 8)
"""An interval [s] whose eighth has one binary digit: every sum of such steps is exact."""
ROUNDED = ((float.fromhex("0x1.004028744fae7p-5"), 10), (float.fromhex("0x1.0040f2b9de168p-5"), 10))
"""Intervals [s] whose tenths have 52 binary digits.

Between them every clock that compares or divides times miscounts in at least one, forwards and
backwards, in double precision, and a summed clock in single precision too:
tests/smoke/test_clock_probes.py runs those clocks.
"""
GRAVITY = -9.75
"""Gravity along y [m/s^2], in the scene of a falling body."""
DELAY = 16
"""Number of intervals between time zero and the first sample."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ClockScene:
    """A scene, and the time (T,) [s] that a trajectory shows to have passed since its start."""

    name: str
    scene: Scene
    passed: Callable[[Trajectory], Array]


def times(interval: float, direction: float) -> Array:
    """Samples (SAMPLES + 1,) [s] from DELAY intervals on, rising for direction 1 and falling for
    -1.
    """
    number = DELAY + direction * np.arange(SAMPLES + 1)
    return np.asarray(interval * number, float)


def clock_request(
    scene: Scene, method: str, interval: float, stride: int, direction: float
) -> Request:
    """The request for the scene with `stride` steps of interval/stride [s] between samples."""
    motion = Motion(scene, times(interval, direction))
    return Request(problem=motion, method=method, step=interval / stride)


def clock_scenes() -> Iterator[ClockScene]:
    """Scenes whose state shows the time that has passed, those that most programs support first."""
    flying = Body(mass=2.0, position=(1.0, 0.0, 0.0), velocity=(-3.0, 0.0, 0.0))
    yield ClockScene(name="flight", scene=Scene.of([flying]), passed=_flown)
    thrown = Body(mass=2.0, velocity=(0.0, 1.0, 0.0))
    weight = UniformGravity(g=(0.0, GRAVITY, 0.0))
    yield ClockScene(name="fall", scene=Scene.of([thrown], [weight]), passed=_fallen)
    yield ClockScene(
        name="spring",
        scene=Scene.of([Body(mass=2.0, position=(1.0, 0.0, 0.0))], [Spring(a=0, stiffness=2.0)]),
        passed=_phase,
    )
    yield ClockScene(
        name="turn",
        scene=Scene.of([Body(mass=1.0, inertia=(1.0, 2.0, 2.5), omega=(0.0, 0.0, 1.0))]),
        passed=_turn,
    )


def _flown(run: Trajectory) -> Array:
    """Time (T,) [s] since the start by x = x0 - 3 t, from the position along x."""
    displacement = run.position[:, 0, 0] - run.position[0, 0, 0]
    return np.asarray(displacement / -3.0)


def _fallen(run: Trajectory) -> Array:
    """Time (T,) [s] since the start by v = v0 + g t, from the velocity along y."""
    velocity_change = run.velocity[:, 0, 1] - run.velocity[0, 0, 1]
    return np.asarray(velocity_change / GRAVITY)


def _phase(run: Trajectory) -> Array:
    """Time (T,) [s] since the start by x = cos t, v = -sin t, from the phase of both."""
    phase = np.unwrap(np.arctan2(-run.velocity[:, 0, 0], run.position[:, 0, 0]))
    return np.asarray(phase - phase[0])


def _turn(run: Trajectory) -> Array:
    """Time (T,) [s] since the start by q = (cos t/2, 0, 0, sin t/2), a turn about z at 1 rad/s."""
    attitude = run.attitude[:, 0]
    # A quaternion determines its angle up to 4 pi.
    principal = 2.0 * np.arctan2(attitude[:, 3], attitude[:, 0])
    angle = np.unwrap(principal, period=4 * np.pi)
    return np.asarray(angle - angle[0])
