"""A pendulum and a counterweight on a string over a wheel, in a plane with gravity
(kernels/string_wheel.c).

r is the free length of string on the pendulum's side, theta its angle from the vertical, R the
wheel's radius. With unit vectors `along` the free string and `across` it, the pendulum is at centre
+ R across + r along, with velocity u along + r theta' across, where u = r' - R theta' is the speed
of the string. With the masses m of the pendulum and M of the counterweight and the wheel's moment
of inertia J (Lagrange's equations)

    (M + m + J/R^2) u' = m r theta'^2 - M g + m g cos(theta),
    r theta'' = -(2 u theta' + R theta'^2 + g sin(theta)).
"""

import numpy as np

from refdem.core.engine import Method
from refdem.core.problem import Motion, Problem, Request
from refdem.core.trajectory import Trajectory
from refdem.scene import Scene
from refdem.scene.elements.string_over_wheel import StringOverWheel
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._kernel_solver import KernelCall, KernelSolver, samples
from refdem.solvers._line_trial import lowest_between
from refdem.solvers._scene_pattern import ANY, ONE, TWO, ScenePattern
from refdem.solvers._single_point import Array

FITS = 1e-9
"""Relative error of the string's fit at the start that counts as rounding."""


class StringWheel(KernelSolver):
    """r and theta by Taylor series; the counterweight moves by the same length as the string."""

    claims = Method(
        name="string-wheel",
        summary=(
            "pendulum, wheel and mass in length and angle: Taylor series of order 20, steps to"
            " round-off"
        ),
        control="exact",
        conserves=frozenset({"energy", "constraint"}),
        reversible=True,
        symplectic=True,
        backward=True,
        cost_rank=2,
    )
    kernels = ("string_wheel",)

    pattern = ScenePattern(
        elements={StringOverWheel: ONE, UniformGravity: ANY},
        bodies=TWO,
        only_points=True,
        in_plane=True,
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for two points in gravity that fit the string, else the reason."""
        if not single.gravity(problem.scene).any():
            return "nothing pulls the string taut: there is no gravity"
        return _misfit(problem.scene)

    def unsupported_times(self, problem: Motion) -> str | None:
        """None if the pendulum stays off the wheel, else when it is drawn onto it: the scene has no
        law for what follows.
        """
        t = problem.times
        call = _call(problem)
        status = call.made(self.kernels[0])
        if status:
            return _drawn_onto_wheel(t[status - 1])
        r, _, u, rate = call.outputs[0].T
        if rate.any():
            # The pendulum swings: its rate would diverge at the wheel, where the kernel stops.
            return None
        # A pendulum that hangs straight down may pass the wheel and return between two samples. Its
        # length is then a parabola in time, which the cubics reproduce exactly.
        past = np.flatnonzero(lowest_between(t, r, u) <= 0.0)
        if past.size:
            return _drawn_onto_wheel(t[past[0] + 1])
        return None

    def prepare(self, request: Request) -> KernelCall:
        """Masses, wheel and gravity; rows for r, theta, u and theta'."""
        return _call(request.problem)

    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """Position and velocity at the samples."""
        scene = request.problem.scene
        t = request.problem.times
        (states,) = call.outputs
        position, velocity = _positions_and_velocities(scene, *_frame(scene), states)
        return Trajectory.of_points(t, position, velocity)


def _call(problem: Problem) -> KernelCall:
    """The kernel's call for a motion; its status is 0, or the sample (from 1) before which the
    pendulum meets the wheel.
    """
    scene = problem.scene
    t = problem.times
    string, down, sideways = _frame(scene)
    states = np.empty((len(t), 4))
    states[0] = _start(scene, string, down, sideways)
    pendulum, counter = scene.bodies.mass[[string.a, string.b]]
    gravity = float(np.linalg.norm(single.gravity(scene)))
    return KernelCall(
        function="refdem_string_wheel",
        inputs=(pendulum, counter, string.drag, string.radius, gravity),
        clock=samples(t),
        outputs=(states,),
    )


def _drawn_onto_wheel(t: float) -> str:
    """The reason for a pendulum that meets its wheel before the time t [s]."""
    return f"contact with the wheel: the pendulum is drawn onto it before t = {t:.6g} s"


def _frame(scene: Scene) -> tuple[StringOverWheel, Array, Array]:
    """The string, the unit vector `down` of gravity, and the unit vector `sideways` across it on
    the pendulum's side.
    """
    string = scene.all(StringOverWheel)[0]
    gravity = single.gravity(scene)
    down = gravity / np.linalg.norm(gravity)
    sideways = np.array([-down[1], down[0], 0.0])
    # The pendulum is on the side opposite to the counterweight. Without a radius there are no
    # sides.
    side = (scene.bodies.position[string.b] - np.array(string.centre)) @ sideways
    if string.radius > 0 and side > 0:
        sideways = -sideways
    return string, down, sideways


def _start(scene: Scene, string: StringOverWheel, down: Array, sideways: Array) -> Array:
    """r, theta, u and theta' at the start (4,).

    With complex numbers y + i x (x along `sideways`, y along `down`) the pendulum is at (r + i R)
    exp(i theta), so r^2 = x^2 + y^2 - R^2, and theta is the argument of (y + i x)(r - i R).
    """
    arm = scene.bodies.position[string.a] - np.array(string.centre)
    velocity = scene.bodies.velocity[string.a]
    x = arm @ sideways
    y = arm @ down
    radius = string.radius
    r = np.sqrt(max(x * x + y * y - radius**2, 0.0))
    # theta is the argument of (y + i x)(r - i R) = (y r + x R) + i (x r - y R).
    theta = np.arctan2(x * r - y * radius, y * r + x * radius)
    along = np.sin(theta) * sideways + np.cos(theta) * down
    across = np.cos(theta) * sideways - np.sin(theta) * down
    # v = u along + r theta' across.
    if r > 0:
        rate = velocity @ across / r
    else:
        rate = 0.0
    return np.array([r, theta, velocity @ along, rate])


def _misfit(scene: Scene) -> str | None:
    """None if the counterweight hangs vertically from its side of the wheel, the pendulum is off
    the wheel, and the string does not stretch, else the reason.
    """
    string, down, sideways = _frame(scene)
    arm = scene.bodies.position[string.b] - np.array(string.centre)
    velocity = scene.bodies.velocity[string.b]
    r, _, u, _ = _start(scene, string, down, sideways)
    extent = r + string.radius + np.linalg.norm(arm)
    speed = np.linalg.norm(scene.bodies.velocity, axis=1).max()
    if not r > 0:
        return "the pendulum starts on the wheel"
    # The counterweight hangs at -R along `sideways`.
    if (
        abs(arm @ sideways + string.radius) > FITS * extent
        or abs(velocity @ sideways) > FITS * speed
    ):
        return "the mass does not hang straight down from the wheel"
    # The string is inextensible: the counterweight rises at the speed u of the string.
    if abs(velocity @ down + u) > FITS * speed:
        return "the string starts with a speed that its ends do not share"
    return None


def _positions_and_velocities(
    scene: Scene, string: StringOverWheel, down: Array, sideways: Array, states: Array
) -> tuple[Array, Array]:
    """Position and velocity (T, 2, 3) from rows r, theta, u, theta'; row 0 is the given start."""
    r, theta, u, rate = (column[:, None] for column in states.T)
    along = np.sin(theta) * sideways + np.cos(theta) * down
    across = np.cos(theta) * sideways - np.sin(theta) * down
    position = np.empty((len(states), 2, 3))
    velocity = np.empty((len(states), 2, 3))
    position[:, string.a] = np.array(string.centre) + string.radius * across + r * along
    velocity[:, string.a] = u * along + r * rate * across
    # Length drawn over the wheel: the integral of u, (r - r0) - R (theta - theta0).
    drawn = (r - r[0]) - string.radius * (theta - theta[0])
    position[:, string.b] = scene.bodies.position[string.b] - drawn * down
    velocity[:, string.b] = -u * down
    position[0] = scene.bodies.position
    velocity[0] = scene.bodies.velocity
    return position, velocity


METHOD = StringWheel()
