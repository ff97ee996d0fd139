"""A block on a floor that oscillates on a linear spring against Coulomb friction, in exact half
cycles (kernels/coulomb.c).

m x'' = -k x - mu N sgn(x'), with N the weight that presses the block on the floor.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Event, Trajectory
from refdem.scene import Polyhedron, Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.scene.shapes import extent
from refdem.solvers import _balance
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, samples_from_start
from refdem.solvers._scene_pattern import ANY, ONE, ScenePattern

Array = NDArray[np.float64]


class ExactBlock(KernelSolver):
    """Half cycles in closed form; exactly at rest after the stop, which is an event."""

    claims = Method(
        name="exact-block",
        summary="half cycles of a block on a level floor in closed form, in double-double",
        control="exact",
        complete_state=False,
        cost_rank=1,
    )
    kernels = ("coulomb",)

    pattern = ScenePattern(
        elements={Contact: ONE, Plane: ONE, Spring: ONE, UniformGravity: ANY},
        bodies=ONE,
        shape=Polyhedron,
        law="rigid",
        may_spin=False,
        irreversible="a body that friction brought to rest may have come from anywhere",
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a block on a level plane with a linear spring at its centre along its motion,
        which friction does not tip over, else the reason.
        """
        scene = problem.scene
        spring = scene.all(Spring)[0]
        if spring.length or not single.is_linear(spring) or not spring.stiffness > 0:
            return "the spring is not linear from natural length 0"
        if any(spring.anchor_a):
            return "the spring does not pull at the block's centre"
        if not scene.all(Contact)[0].friction > 0:
            return "the floor does not rub"
        load = _balance.pressed(scene)
        if isinstance(load, str):
            return load
        return _off_line(scene, load) or _balance.overturning(scene, load, line_of(scene, load))

    def prepare(self, request: Request) -> KernelCall:
        """The law along the line and the start; arrays for the stop time and for rows at the
        samples.
        """
        scene = request.problem.scene
        t = request.problem.times
        spring = scene.all(Spring)[0]
        bodies = scene.bodies
        load = _balance.pressed(scene)
        assert not isinstance(load, str)
        line = line_of(scene, load)
        mass = float(bodies.mass[0])
        weight = mass * load.pressing
        # Nothing but spring and friction acts along the line.
        law = (mass, spring.stiffness, scene.all(Contact)[0].friction, weight, 0.0)
        x0 = float(line @ _stretch(scene))
        v0 = float(line @ bodies.velocity[0])
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
        load = _balance.pressed(scene)
        assert not isinstance(load, str)
        line = line_of(scene, load)
        # r = foot + x line. `foot` has the part of the initial position off the line, which stays.
        start = scene.bodies.position[0]
        foot = start - float(line @ _stretch(scene)) * line
        position = foot + rows[:, :1, None] * line
        velocity = rows[:, 1:2, None] * line
        events: tuple[Event, ...] = ()
        if stop[0] <= t[-1]:
            events = (Event(time=float(stop[0]), kind="stop", body=0),)
        turning = {
            "attitude": np.repeat(scene.bodies.attitude[None], len(t), axis=0),
            "omega": np.zeros_like(velocity),
        }
        return Trajectory(
            t=t,
            position=position,
            velocity=velocity,
            channels={"dissipated_work": rows[:, 2].copy()},
            events=events,
            **turning,
        )


def line_of(scene: Scene, load: _balance.Load) -> Array:
    """The unit direction (3,) of the motion in the plane: from the anchor to the block, or of its
    velocity if it starts at the anchor.
    """
    direction = _in_plane(_stretch(scene), load)
    if not np.any(direction):
        direction = _in_plane(scene.bodies.velocity[0], load)
    # Scaled by the largest component first: the squares of very small numbers underflow.
    scaled = direction / (np.abs(direction).max() or 1.0)
    length = np.linalg.norm(scaled) or 1.0
    line: Array = scaled / length
    return line


def _stretch(scene: Scene) -> Array:
    """The vector (3,) [m] from the spring's anchor to the block's centre."""
    stretch: Array = scene.bodies.position[0] - single.anchor(scene.all(Spring)[0])
    return stretch


def _in_plane(vector: Array, load: _balance.Load) -> Array:
    """The part of a vector (3,) along the plane."""
    part: Array = vector - (vector @ load.normal) * load.normal
    return part


def _off_line(scene: Scene, load: _balance.Load) -> str | None:
    """None if the plane is level, and the block moves along the plane on the line through the
    anchor, else the reason.
    """
    line = line_of(scene, load)
    stretch = _stretch(scene)
    velocity = scene.bodies.velocity[0]
    if not np.any(line):
        return "nothing moves"
    if load.steepness > _balance.SLACK:
        return "the plane is not level"
    # The height of the block has the rounding of its own size.
    size = np.linalg.norm(stretch) + extent(scene.bodies.shape[0])
    if abs(stretch @ load.normal) > _balance.SLACK * size:
        return "the spring does not pull along the plane"
    across = np.linalg.norm(velocity - (velocity @ line) * line)
    if across > _balance.SLACK * np.linalg.norm(velocity):
        return "the motion is not along the spring"
    return None


METHOD = ExactBlock()
