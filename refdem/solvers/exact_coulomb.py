"""A body on a linear spring with dry friction along one line, in exact half cycles
(kernels/coulomb.c).

m x'' = -k x - f sgn(x'), with the friction f = mu N. Each half cycle is harmonic about the centre
-+f/k, and the body stops for ever at a turning point with k |x| <= f. Gravity along the line shifts
the equilibrium from which x is measured here.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Event, Trajectory
from refdem.scene import Scene
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, samples_from_start
from refdem.solvers._scene_pattern import ANY, ONE, ScenePattern

Array = NDArray[np.float64]


class ExactCoulomb(KernelSolver):
    """Half cycles in closed form; exactly at rest after the stop, which is an event."""

    claims = Method(
        name="exact-coulomb",
        summary="half cycles in closed form, turning points and times in double-double",
        control="exact",
        conserves=frozenset({"energy"}),
        cost_rank=0,
    )
    kernels = ("coulomb",)

    pattern = ScenePattern(
        elements={Spring: ONE, Slider: ONE, UniformGravity: ANY},
        bodies=ONE,
        only_points=True,
        irreversible="a body that friction brought to rest may have come from anywhere",
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a linear spring of natural length 0 and a slider with friction, all along one
        line, else the reason.
        """
        scene = problem.scene
        spring = scene.all(Spring)[0]
        slider = scene.all(Slider)[0]
        if spring.length or not single.is_linear(spring) or not spring.stiffness > 0:
            return "the spring is not linear from natural length 0"
        if not slider.friction * slider.normal_force > 0:
            return "the slider does not rub"
        if not slider.is_plain:
            return "the slider is on a belt, or its friction depends on the speed"
        return _off_line(scene, np.array(slider.axis))

    def prepare(self, request: Request) -> KernelCall:
        """The law along the axis and the start; arrays for the stop time and for rows at the
        samples.
        """
        scene = request.problem.scene
        t = request.problem.times
        spring = scene.all(Spring)[0]
        slider = scene.all(Slider)[0]
        bodies = scene.bodies
        axis = np.array(slider.axis)
        law = (
            float(bodies.mass[0]),
            spring.stiffness,
            slider.friction,
            slider.normal_force,
            float(axis @ single.gravity(scene)),
        )
        x0 = float(axis @ (bodies.position[0] - single.anchor(spring)))
        v0 = float(axis @ bodies.velocity[0])
        return KernelCall(
            function="refdem_coulomb",
            inputs=(*law, x0, v0),
            clock=samples_from_start(t),
            outputs=(np.empty(1), np.empty((len(t), 3))),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position, velocity and work of friction at the samples; the stop is an event."""
        scene = request.problem.scene
        t = request.problem.times
        # A row: position from the anchor, velocity, work.
        stop, rows = call.outputs
        axis = np.array(scene.all(Slider)[0].axis)
        position = single.anchor(scene.all(Spring)[0]) + rows[:, :1, None] * axis
        velocity = rows[:, 1:2, None] * axis
        events: tuple[Event, ...] = ()
        if stop[0] <= t[-1]:
            events = (Event(time=float(stop[0]), kind="stop", body=0),)
        channels = {"dissipated_work": rows[:, 2].copy()}
        return Trajectory.of_points(t, position, velocity, channels=channels, events=events)


def _off_line(scene: Scene, axis: Array) -> str | None:
    """None if position, velocity and gravity lie along the axis through the anchor, else the
    reason.
    """
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
