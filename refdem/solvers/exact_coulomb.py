"""A body on a spring and a slider to the world along one line, in exact half cycles
(kernels/coulomb.c); it stops for ever.
"""

from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.kernels import load, pointer, prepared, timed
from refdem.scene import Scene
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.solvers import _single_point as single
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]


class ExactCoulomb(Solver):
    """Half cycles about the shifted centres; exactly at rest after the stop, which is an event."""

    claims = Method(
        name="exact-coulomb",
        summary="half cycles in closed form, turning points and times in double-double",
        control="exact",
        conserves=frozenset({"energy"}),
        cost_rank=0,
    )
    kernels = ("coulomb",)

    def unsupported(self, problem: Motion) -> str | None:
        """None for one point on a linear spring of natural length 0 and a slider, both to the
        world, moving along the slider.
        """
        scene = problem.scene
        reason = single.unsupported(scene, Spring, Slider)
        if reason:
            return reason
        spring = scene.all(Spring)[0]
        slider = scene.all(Slider)[0]
        if scene.bodies.fixed.any():
            return "spring and slider do not tie a body to the world"
        if spring.length or not single.is_linear(spring) or not spring.stiffness > 0:
            return "the spring is not linear from natural length 0"
        if not slider.friction * slider.normal_force > 0:
            return "the slider does not rub"
        if not slider.is_plain:
            return "the slider is on a belt, or its friction depends on the speed"
        if problem.interval < 0:
            return (
                "time runs backwards, and a body that friction brought to rest may have come from"
                " anywhere"
            )
        return _off_line(scene, np.array(slider.axis))

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Position, velocity and the work of friction at the samples."""
        begun = perf_counter()
        scene = request.problem.scene
        t = request.problem.times
        spring = scene.all(Spring)[0]
        slider = scene.all(Slider)[0]
        bodies = scene.bodies
        axis = np.array(slider.axis)
        anchor = single.anchor(spring)
        numbers = (
            float(bodies.mass[0]),
            spring.stiffness,
            slider.friction,
            slider.normal_force,
            float(axis @ single.gravity(scene)),
            float(axis @ (bodies.position[0] - anchor)),
            float(axis @ bodies.velocity[0]),
            float(t[0]),
        )
        out = np.empty((len(t), 3))
        stop = np.empty(1)
        stopped = pointer("coulomb", stop, output=True)
        rows = pointer("coulomb", out, output=True)
        samples = pointer("coulomb", t)
        lib = load("coulomb").lib
        motion = prepared("coulomb")
        lib.refdem_coulomb_prepare(*numbers, len(t), samples, stopped, rows, motion)
        started = perf_counter()
        seconds = timed(lib.refdem_coulomb_run, motion)
        cost = Cost(seconds=seconds, setup=started - begun)
        position = anchor + out[:, :1, None] * axis
        velocity = out[:, 1:2, None] * axis
        events: tuple[Event, ...] = ()
        if stop[0] <= t[-1]:
            events = (Event(time=float(stop[0]), kind="stop", body=0),)
        channels = {"dissipated_work": out[:, 2].copy()}
        found = Trajectory.of_points(t, position, velocity, channels=channels, events=events)
        return found, cost


def _off_line(scene: Scene, axis: Array) -> str | None:
    """None if place, velocity and gravity lie along the axis through the anchor."""
    bodies = scene.bodies
    vectors = (
        bodies.position[0] - single.anchor(scene.all(Spring)[0]),
        bodies.velocity[0],
        single.gravity(scene),
    )
    for vector in vectors:
        across = np.linalg.norm(vector - (vector @ axis) * axis)
        if across > 4e-16 * np.linalg.norm(vector):
            return "the motion is not along the slider"
    return None


METHOD = ExactCoulomb()
