"""Points of two sections of a point on a driven belt (1.125), by the Taylor series of `stick-slip`:
once a period of the drive, and where v = 0 with x > 0.

A passage lies between two neighbouring samples at which v has opposite signs. The zero of the chord
through both is the first guess of Newton's method. Where v = 0 the rate is v' = gamma cos(eta t) -
x, because the friction on a point at rest balances the steady pull of the belt.
"""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Motion, Request
from refdem.scene import Body, Scene
from refdem.scene.elements.force import Force
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.solvers.stick_slip import METHOD as STICK_SLIP

Array = NDArray[np.float64]
LAWS: dict[int, Literal["stribeck", "stribeck_linear"]] = {1: "stribeck_linear", 2: "stribeck"}
"""The law of friction by the power of the speed in its last term."""
PER_PERIOD = 512
"""Samples in a period of the drive, or of the spring if that is shorter: two passages between two
of them are not seen.
"""
MOST_PERIODS = 16
"""Length of the search for passages, in periods of the drive or, if longer, of the spring."""
STEPS = 8
"""Steps of Newton's method, each of which doubles the number of correct digits."""


def scene_of(friction: Array, power: Array, drive: Array, start: Array) -> Scene:
    """The scene of friction (a, mu0, mu1, lambda0, lambda1), of the power of the last term of mu,
    of drive (belt, gamma, eta) and start (x, v).
    """
    normal_force, mu0, mu1, lambda0, lambda1 = (float(x) for x in friction)
    belt, gamma, eta = (float(x) for x in drive)
    slider = Slider(
        a=0,
        normal_force=normal_force,
        belt_velocity=belt,
        law=LAWS[int(power[0])],
        mu0=mu0,
        mu1=mu1,
        lambda0=lambda0,
        lambda1=lambda1,
    )
    # The steady pull -a mu(belt) shifts the anchor of the unit spring.
    steady_pull = normal_force * slider.coefficient(belt)
    spring = Spring(a=0, stiffness=1.0, anchor_b=(-steady_pull, 0.0, 0.0))
    x, v = (float(value) for value in start)
    point = Body(mass=1.0, position=(x, 0.0, 0.0), velocity=(v, 0.0, 0.0))
    force = Force(a=0, amplitude=gamma, frequency=eta)
    return Scene.of([point], [spring, slider, force])


def states(scene: Scene, times: Array) -> tuple[Array, Array]:
    """Places [m] and velocities [m/s] (T,) at the times (T,) [s], of which the first is 0."""
    request = Request(problem=Motion(scene, times), method=STICK_SLIP.claims.name)
    trajectory, _ = STICK_SLIP.run(request)
    return trajectory.position[:, 0, 0], trajectory.velocity[:, 0, 0]


def strobe(friction: Array, power: Array, drive: Array, start: Array, n: Array) -> Array:
    """Place and velocity (2,) after n periods of the drive."""
    # t = 2 pi n/eta.
    times = np.array([0.0, 2 * np.pi * n[0] / drive[2]])
    x, v = states(scene_of(friction, power, drive, start), times)
    return np.array([x[1], v[1]])


def passage(friction: Array, power: Array, drive: Array, start: Array, n: Array) -> Array | None:
    """Time and place (2,) of the n-th passage of v = 0 with x > 0 after the start, in either
    direction.

    None if MOST_PERIODS periods contain fewer passages, as for a mass that the belt carries far.
    """
    scene = scene_of(friction, power, drive, start)
    eta = float(drive[2])
    # The frequency of the spring is 1.
    end = 2 * np.pi * MOST_PERIODS / min(1.0, eta)
    count = int(MOST_PERIODS * PER_PERIOD * max(eta, 1 / eta))
    times = np.linspace(0.0, end, count + 1)
    _, v = states(scene, times)
    is_positive = v > 0
    if v[0] == 0:
        # The start does not count as a passage.
        is_positive[0] = is_positive[1]
    found = 0
    for index in np.flatnonzero(is_positive[1:] != is_positive[:-1]):
        # The zero of the chord: t_k + (t_{k+1} - t_k) v_k/(v_k - v_{k+1}).
        share = v[index] / (v[index] - v[index + 1])
        time = times[index] + share * (times[index + 1] - times[index])
        time, place = passed(scene, drive, float(time))
        found += place > 0
        if found == int(n[0]):
            return np.array([time, place])
    return None


def passed(scene: Scene, drive: Array, time: float) -> tuple[float, float]:
    """Time and place at which v = 0, near `time`, by Newton's method."""
    _, gamma, eta = drive
    place = 0.0
    for _ in range(STEPS):
        x, v = states(scene, np.array([0.0, time]))
        place = float(x[1])
        # t <- t - v/v', with v' = gamma cos(eta t) - x.
        time -= float(v[1] / (gamma * np.cos(eta * time) - place))
    return time, place
