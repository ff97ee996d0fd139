"""A point on a spring and a slider, at rest or on a moving belt, with Coulomb's or Stribeck's law,
driven or not (kernels/stick_slip.c).

m x'' = -k x + f cos(w t + phase) + weight - N mu(|u|) Sgn(u), with the slip velocity u = x' - belt.
Where u = 0, Sgn(0) = [-1, 1] balances the other forces up to N mu(0).
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Event, Trajectory
from refdem.scene import Scene
from refdem.scene.elements.force import Force
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, Struct, samples_from_start
from refdem.solvers._scene_pattern import ANY, ONE, OPTIONAL, ScenePattern

Array = NDArray[np.float64]
FAMILY = "stick_slip"
MOST_EVENTS = 100_000
"""Rows of the table of events, enough for thousands of periods with a few events each."""
KINDS = {1: "stick", 2: "slip"}
"""Kinds of events by their numbers in the kernel."""
ASKEW = 1e-15
"""Largest relative component off the line: round-off of a scene that was rotated."""


class StickSlip(KernelSolver):
    """Taylor series of order 20 from event to event; a sticking point has exactly the velocity of
    the belt.
    """

    claims = Method(
        name="stick-slip",
        summary=(
            "Taylor series of order 20, stops as their zeros and releases between turning points of"
            " the pull, all to the last bits"
        ),
        control="exact",
        conserves=frozenset({"energy"}),
        cost_rank=6,
    )
    kernels = (FAMILY,)

    pattern = ScenePattern(
        elements={Spring: ONE, Slider: ONE, Force: OPTIONAL, UniformGravity: ANY},
        bodies=ONE,
        only_points=True,
        irreversible="a body that sticks may have come from anywhere",
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a linear spring of natural length 0 and a slider with static friction, all along
        one line, else the reason.
        """
        scene = problem.scene
        spring = scene.all(Spring)[0]
        slider = scene.all(Slider)[0]
        if spring.length or not single.is_linear(spring) or not spring.stiffness > 0:
            return "the spring is not linear from natural length 0"
        if not slider.coefficient(0.0) * slider.normal_force > 0:
            return "the slider does not hold"
        return _off_line(scene)

    def prepare(self, request: Request) -> KernelCall:
        """The law and the start along the line in the kernel's unit of time; arrays for events and
        for rows of x, v and work.
        """
        scene = request.problem.scene
        bodies = scene.bodies
        t = request.problem.times
        # x in metres, time t/unit, and so velocities v unit [m per unit].
        unit = law_time_unit(scene)
        axis = np.array(scene.all(Slider)[0].axis)
        x0 = float(axis @ (bodies.position[0] - single.anchor(scene.all(Spring)[0])))
        v0 = float(axis @ bodies.velocity[0]) * unit
        return KernelCall(
            function="refdem_stick_slip",
            inputs=(belt_law(scene, unit), x0, v0),
            clock=(*samples_from_start(t / unit), MOST_EVENTS),
            outputs=(np.empty((MOST_EVENTS, 2)), np.empty((len(t), 3))),
        )

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position, velocity, the work done against friction and drive, and the events stick and
        slip.
        """
        scene = request.problem.scene
        t = request.problem.times
        unit = law_time_unit(scene)
        axis = np.array(scene.all(Slider)[0].axis)
        # The kernel's status is the number of events that it has written.
        event_rows, rows = call.outputs
        events = []
        for time, kind in event_rows[:status]:
            if time > t[-1] / unit:
                continue
            word = KINDS[int(kind)]
            events.append(Event(time=float(time * unit), kind=word, body=0))
        position = single.anchor(scene.all(Spring)[0]) + rows[:, :1, None] * axis
        velocity = rows[:, 1:2, None] / unit * axis
        channels = {"dissipated_work": rows[:, 2].copy()}
        return Trajectory.of_points(t, position, velocity, channels=channels, events=tuple(events))


def law_time_unit(scene: Scene) -> float:
    """The kernel's unit of time [s], near the shortest of sqrt(m/k) and the drives'
    1/frequency.
    """
    stiffness = scene.all(Spring)[0].stiffness
    mass = float(scene.bodies.mass[0])
    frequencies = [force.frequency for force in scene.all(Force) if force.frequency > 0]
    return single.time_unit(
        [sqrt(mass / stiffness), *(1.0 / frequency for frequency in frequencies)]
    )


def belt_law(scene: Scene, unit: float = 1.0) -> Struct:
    """The scene as the kernel's struct, with positions from the spring's anchor and times in `unit`
    [s].

    A mass divided by unit^2 leaves the values of forces and work unchanged.
    """
    slider = scene.all(Slider)[0]
    spring = scene.all(Spring)[0]
    axis = np.array(slider.axis)
    mass = float(scene.bodies.mass[0])
    # Weight and drive act by their components along the slider's axis.
    weight = mass * float(axis @ single.gravity(scene))
    drive = next(iter(scene.all(Force)), Force(a=0, amplitude=0.0))
    of_motion = {
        "mass": mass / unit**2,
        "stiffness": spring.stiffness,
        "weight": weight,
        "normal_force": slider.normal_force,
        "belt": slider.belt_velocity * unit,
        "linear": slider.law == "stribeck_linear",
    }
    of_drive = {
        "amplitude": drive.amplitude * float(axis @ np.array(drive.axis)),
        "frequency": drive.frequency * unit,
        "phase": drive.phase,
    }
    return Struct(FAMILY, "refdem_belt", _friction(slider, unit) | of_motion | of_drive)


def _friction(slider: Slider, unit: float) -> dict[str, float]:
    """Coefficients of mu(v) = (mu0 - mu1)/(1 + lambda0 v) + mu1 + lambda1 v^2 (1.126), or of its
    form linear in v.

    Speeds are in metres per `unit` of time. Coulomb's law is the constant mu.
    """
    if slider.law == "coulomb":
        return {"mu0": slider.friction, "mu1": slider.friction, "lambda0": 0.0, "lambda1": 0.0}
    if slider.law == "stribeck_linear":
        power = 1
    else:
        power = 2
    return {
        "mu0": slider.mu0,
        "mu1": slider.mu1,
        "lambda0": slider.lambda0 / unit,
        "lambda1": slider.lambda1 / unit**power,
    }


def _off_line(scene: Scene) -> str | None:
    """None if position, velocity, gravity and force lie along the slider's axis through the
    spring's anchor, else the reason.
    """
    bodies = scene.bodies
    axis = np.array(scene.all(Slider)[0].axis)
    vectors = [
        bodies.position[0] - single.anchor(scene.all(Spring)[0]),
        bodies.velocity[0],
        single.gravity(scene),
    ]
    vectors += [np.array(force.axis) for force in scene.all(Force)]
    for vector in vectors:
        across = np.linalg.norm(vector - (vector @ axis) * axis)
        if across > ASKEW * np.linalg.norm(vector):
            return "the motion is not along the slider"
    return None


METHOD = StickSlip()
