"""Many starts of one scene, each in the closed form of a single motion (kernels coulomb,
linear_oscillator, oscillator, pendulum).
"""

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Ensemble, Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.kernels import load, pointer
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.solvers import _single_point as single
from refdem.solvers import exact_coulomb, exact_harmonic, exact_linear, exact_pendulum
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]
Flow = Callable[[Ensemble, Array, Array], None]
OFF = 1e-12
"""Relative distance of a start from the line or the rod of the first: round-off of a scene that was
rotated.
"""


class CarriedEnsemble(Solver):
    """Harmonic, damped, driven, dry-friction and pendulum flows.

    A linear flow is affine in its start, so three motions determine all (see `linear`).
    """

    claims = Method(
        name="carried-ensemble",
        summary="every start in closed form; linear flows by superposition",
        control="exact",
        backward=True,
        cost_rank=0,
    )
    answers = Ensemble
    kernels = ("coulomb", "linear_oscillator", "oscillator", "pendulum")

    def unsupported(self, problem: Ensemble) -> str | None:
        """None for starts of one point, on a line or a rod, whose motion has a closed form, else
        the reasons.
        """
        reasons = [solver.unsupported(problem.motion(0)) or "" for solver, _ in FLOWS]
        if all(reasons):
            return "; ".join(reasons)
        return _misfit(problem)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Trajectory with `position` [m] and `velocity` [m/s] (T, M, 1, 3) of M starts."""
        begun = perf_counter()
        problem = request.problem
        assert isinstance(problem, Ensemble)
        flow = next(flow for solver, flow in FLOWS if solver.unsupported(problem.motion(0)) is None)
        shape = (len(problem.times), len(problem.position), 1, 3)
        position = np.empty(shape)
        velocity = np.empty(shape)
        started = perf_counter()
        flow(problem, position, velocity)
        cost = Cost(seconds=perf_counter() - started, setup=started - begun)
        values = {"position": position, "velocity": velocity}
        return Trajectory.of_values(problem.times, values), cost


def linear(problem: Ensemble, position: Array, velocity: Array) -> None:
    """Fills positions and velocities of a linear flow by superposition.

    The state at time t is affine in the initial one, s(t) = rest(t) + x0 by_place(t) + v0
    by_rate(t): rest is the motion from rest at the origin, the others follow from one motion with a
    displacement and one with an initial velocity.
    """
    origin, axis = _frame(problem)
    solver = next(
        solver for solver, _ in FLOWS[:2] if solver.unsupported(problem.motion(0)) is None
    )
    # r = origin + x axis, v = x' axis.
    x0 = (problem.position[:, 0] - origin) @ axis
    v0 = problem.velocity[:, 0] @ axis
    # Amplitude of the unit motions, of the size of the starts, so that the differences from `rest`
    # do not cancel.
    unit = max(float(np.abs(x0).max()), float(np.abs(v0).max()))

    def state(x: float, v: float) -> Array:
        return _one_motion(solver, problem, origin + x * axis, v * axis, axis, origin)

    rest = state(0.0, 0.0)
    with_displacement = state(unit, 0.0)
    with_velocity = state(0.0, unit)
    by_place = (with_displacement - rest) / unit
    by_rate = (with_velocity - rest) / unit
    # s(t) = rest(t) + x0 by_place(t) + v0 by_rate(t).
    from_place = by_place[:, None] * x0[None, :, None]
    from_rate = by_rate[:, None] * v0[None, :, None]
    states = rest[:, None] + from_place + from_rate
    position[:, :, 0] = origin + states[..., :1] * axis
    velocity[:, :, 0] = states[..., 1:] * axis


def _one_motion(
    solver: Solver, problem: Ensemble, place: Array, rate: Array, axis: Array, origin: Array
) -> Array:
    """Position and velocity (T, 2) along the axis of the motion from one start."""
    scene = problem.scene.with_state(position=place[None], velocity=rate[None])
    run, _ = solver.run(Request(problem=Motion(scene, problem.times), method=solver.claims.name))
    x = (run.position[:, 0] - origin) @ axis
    v = run.velocity[:, 0] @ axis
    return np.stack((x, v), axis=-1)


def coulomb(problem: Ensemble, position: Array, velocity: Array) -> None:
    """Fills positions and velocities under dry friction, start by start, in exact half cycles."""
    scene = problem.scene
    t = problem.times
    spring = scene.all(Spring)[0]
    slider = scene.all(Slider)[0]
    axis = np.array(slider.axis)
    origin = single.anchor(spring)
    x0 = (problem.position[:, 0] - origin) @ axis
    v0 = problem.velocity[:, 0] @ axis
    law = (
        float(scene.bodies.mass[0]),
        spring.stiffness,
        slider.friction,
        slider.normal_force,
        float(axis @ single.gravity(scene)),
    )
    # r = anchor + x axis and v = x' axis; a row has x, x' and the work of friction.
    rows = np.empty((len(x0), len(t), 3))
    stop = np.empty(1)
    kernel = load("coulomb").lib.refdem_coulomb
    output_pointer = pointer("coulomb", rows, output=True)
    samples = pointer("coulomb", t)
    stopped = pointer("coulomb", stop, output=True)
    start = float(t[0])
    count = len(t)
    for member, (x, v) in enumerate(zip(x0.tolist(), v0.tolist(), strict=True)):
        # Each member has 3 T numbers.
        kernel(*law, x, v, start, count, samples, stopped, output_pointer + 3 * count * member)
    position[:, :, 0] = origin + rows[..., :1].transpose(1, 0, 2) * axis
    velocity[:, :, 0] = rows[..., 1:2].transpose(1, 0, 2) * axis


def pendulum(problem: Ensemble, position: Array, velocity: Array) -> None:
    """Fills positions and velocities of pendulums, start by start, by Jacobi functions."""
    scene = problem.scene
    t = problem.times
    rod = scene.all(Rod)[0]
    count = len(problem.times)
    members = len(problem.position)
    starts = [
        np.ascontiguousarray(column.reshape(-1)) for column in (problem.position, problem.velocity)
    ]
    fixed = [pointer("pendulum", column) for column in (single.gravity(scene), single.anchor(rod))]
    outputs = [
        np.empty((members, count, 3)),
        np.empty((members, count, 3)),
        np.empty((members, count)),
    ]
    x, v, force = (pointer("pendulum", column, output=True) for column in outputs)
    r, u = (pointer("pendulum", column) for column in starts)
    samples = pointer("pendulum", t)
    kernel = load("pendulum").lib.refdem_pendulum
    mass = float(scene.bodies.mass[0])
    start = float(t[0])
    # Pointers count in doubles: a member has 3 of its start's position and velocity, 3 T of the
    # positions and of the velocities, and T forces.
    for member in range(members):
        first_number = 3 * member
        first_row = 3 * count * member
        kernel(
            mass,
            rod.length,
            *fixed,
            r + first_number,
            u + first_number,
            start,
            count,
            samples,
            x + first_row,
            v + first_row,
            force + count * member,
        )
    position[:, :, 0] = outputs[0].transpose(1, 0, 2)
    velocity[:, :, 0] = outputs[1].transpose(1, 0, 2)


FLOWS: tuple[tuple[Any, Flow], ...] = (
    (exact_harmonic.METHOD, linear),
    (exact_linear.METHOD, linear),
    (exact_coulomb.METHOD, coulomb),
    (exact_pendulum.METHOD, pendulum),
)
"""Methods with a closed form, each with the function that fills an ensemble. The first method that
supports the scene is used.
"""


def _frame(problem: Ensemble) -> tuple[Array, Array]:
    """The spring's anchor (3,) [m] and the line of motion (3,): the direction of the largest
    displacement or velocity.
    """
    origin = single.anchor(problem.scene.all(Spring)[0])
    arms = np.concatenate((problem.position[:, 0] - origin, problem.velocity[:, 0]))
    farthest = arms[np.argmax(np.linalg.norm(arms, axis=1))]
    length = np.linalg.norm(farthest)
    if length == 0:
        # All starts rest at the anchor, and stay there.
        return origin, farthest
    return origin, farthest / length


def _misfit(problem: Ensemble) -> str | None:
    """None if every start lies on the line, or on the rod, of the first, else the reason."""
    if problem.scene.all(Rod):
        solver: Solver = exact_pendulum.METHOD
        for member in _doubtful_starts(problem):
            if solver.unsupported(problem.motion(member)):
                return f"start {member} does not swing in the plane on its rod"
        return None
    if any(spring.length for spring in problem.scene.all(Spring)):
        return "the spring has a length: the starts may lie on both sides of its anchor"
    origin, axis = _frame(problem)
    arms = np.concatenate((problem.position[:, 0] - origin, problem.velocity[:, 0]))
    # The distance from the line: |a - (a . axis) axis|, of displacements and of velocities.
    off_line = np.linalg.norm(arms - (arms @ axis)[:, None] * axis, axis=1)
    # Dry friction acts along the slider's axis only.
    slider = next(iter(problem.scene.all(Slider)), None)
    if slider is not None and abs(abs(float(axis @ np.array(slider.axis))) - 1) > OFF:
        return "the starts do not lie on the slider's line"
    longest = np.linalg.norm(arms, axis=1).max()
    if off_line.max() > OFF * longest:
        return "the starts do not lie on one line"
    return None


def _doubtful_starts(problem: Ensemble) -> list[int]:
    """Indices of the starts that are off the rod or out of the plane by a coarse test; only these
    are tested one by one.
    """
    rod = problem.scene.all(Rod)[0]
    arm = problem.position[:, 0] - single.anchor(rod)
    velocity = problem.velocity[:, 0]
    down = single.gravity(problem.scene)
    speed = np.linalg.norm(velocity, axis=1)
    weight = float(np.linalg.norm(down))
    # | |arm| - l | > 0, or arm . v != 0 (the rod would stretch), or (arm x g) . v != 0 (the motion
    # leaves the vertical plane).
    wrong_length = np.abs(np.linalg.norm(arm, axis=1) - rod.length) > 1e-9 * rod.length
    stretching = np.abs(np.sum(arm * velocity, axis=1)) > OFF * rod.length * speed
    out_of_plane = np.abs(np.sum(np.cross(arm, down) * velocity, axis=1))
    leaves_plane = out_of_plane > OFF * rod.length * weight * speed
    return [int(member) for member in np.flatnonzero(wrong_length | stretching | leaves_plane)]


METHOD = CarriedEnsemble()
