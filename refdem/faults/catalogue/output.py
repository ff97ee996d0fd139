"""Output and time level: what is written is not what was computed, or not when."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from refdem.core.problem import Request
from refdem.core.trajectory import STATE, Trajectory
from refdem.faults.change import digits, of_columns, of_parts, of_results
from refdem.faults.fault import Fault
from refdem.mechanics import vectors as vec

output = partial(Fault, kind="output", on=("oscillator",))
TRAJECTORY = ("run", "trajectory")


def _rate(run: Trajectory, name: str) -> Any:
    """d/dt of a column (T, N, ...), by differences between the samples."""
    return np.gradient(getattr(run, name), run.t, axis=0, edge_order=2)


def _lag(request: Request, run: Trajectory) -> Any:
    """A step h [s] for every row but the first, where it is 0; shaped for (T, N, 3)."""
    h = np.full(len(run.t), request.signed_step)[:, None, None]
    h[0] = 0.0
    return h


def _step_late(request: Request, run: Trajectory) -> Trajectory:
    """Every row but the first shows the state of one step before: x - h v, v - h v'."""
    h = _lag(request, run)
    position = run.position - h * run.velocity
    velocity = run.velocity - h * _rate(run, "velocity")
    return replace(run, position=position, velocity=velocity)


def _half_step_velocity(request: Request, run: Trajectory) -> Trajectory:
    """Velocities are those of half a step before."""
    velocity = run.velocity - _lag(request, run) / 2 * _rate(run, "velocity")
    return replace(run, velocity=velocity)


def _interpolated(request: Request, run: Trajectory) -> Trajectory:
    """Positions that are off by -h^2 a/8: the size of the error of linear interpolation between two
    steps in the middle of which the sample is.
    """
    error = request.signed_step**2 / 8 * _rate(run, "velocity")
    return replace(run, position=run.position - error)


def _sample_late(values: Any) -> Any:
    """A column whose rows after the first are the ones before."""
    return np.concatenate([values[:1], values[:-1]])


def _drawn_out(request: Request, run: Trajectory) -> Trajectory:
    """Times are too large by one part in a million."""
    return replace(run, t=run.t * (1 + 1e-6))


def _short(request: Request, run: Trajectory) -> Trajectory:
    """The trajectory without its last row."""
    columns: dict[str, Any] = {name: getattr(run, name)[:-1] for name in ("t", *STATE)}
    columns["channels"] = {name: values[:-1] for name, values in run.channels.items()}
    return replace(run, **columns)


def _not_a_number(request: Request, run: Trajectory) -> Trajectory:
    """The velocities of sample 5 are NaN."""
    velocity = run.velocity.copy()
    velocity[5] = np.nan
    return replace(run, velocity=velocity)


def _frozen_end(values: Any) -> Any:
    """A column whose rows after three quarters of the run repeat the row there."""
    last = 3 * len(values) // 4
    frozen = values.copy()
    frozen[last:] = values[last]
    return frozen


def _sorted_by_velocity(velocity: Any) -> Any:
    """Velocities (T, N, 3) in the order of their x component in each row."""
    order = np.argsort(velocity[..., :1], axis=1)
    return np.take_along_axis(velocity, order, axis=1)


def _momentum(request: Request, run: Trajectory) -> Trajectory:
    """Momenta are written in place of velocities."""
    mass = request.problem.scene.bodies.mass[:, None]
    return replace(run, velocity=run.velocity * mass)


def _from_file(request: Request) -> Request:
    """A start that moves has the velocities of a file with eight decimals."""
    scene = request.problem.scene
    velocity = scene.bodies.velocity
    if velocity[0, 0] == 0:
        return request
    return request.with_scene(scene.with_state(velocity=np.round(velocity, 8)))


def _touched(state: Any) -> Any:
    """Writing changes the last digits of a velocity."""
    state.v[0] = vec.times(1 + 1e-15, state.v[0])
    return state


FAULTS = (
    output(
        name="step-late",
        sentence="Every sample is one step late.",
        sees=("order", "state"),
        after=_step_late,
    ),
    output(
        name="sample-late",
        sentence="Every row is the previous one.",
        sees=("error", "x"),
        after=of_columns(position=_sample_late, velocity=_sample_late),
    ),
    output(
        name="position-late",
        sentence="Positions are written one row late, velocities are not.",
        on=("orbit",),
        sees=("error", "x"),
        after=of_columns(position=_sample_late),
    ),
    output(
        name="half-step-velocity",
        sentence="Velocities are those of half a step earlier (leapfrog).",
        sees=("error", "v"),
        after=_half_step_velocity,
    ),
    output(
        name="interpolated",
        sentence="Rows are interpolated between steps.",
        method="suzuki",
        sees=("error", "x"),
        levels=5,
        after=_interpolated,
    ),
    output(
        name="clock-off",
        sentence="The time column is too large by one part in 1e6.",
        sees=TRAJECTORY,
        after=_drawn_out,
    ),
    output(
        name="clock-added-up",
        sentence="The time column is summed in single precision.",
        sees=TRAJECTORY,
        inside=of_results(clock=lambda found: float(np.float32(found) + np.float32(1e-7))),
    ),
    output(name="row-missing", sentence="The last row is missing.", sees=TRAJECTORY, after=_short),
    output(
        name="not-a-number", sentence="One number is NaN.", sees=TRAJECTORY, after=_not_a_number
    ),
    output(
        name="output-changes-state",
        sentence="Writing output changes the trajectory (LAMMPS 1631).",
        sees=("determinism", "output-rate"),
        inside=of_parts(output=_touched),
    ),
    output(
        name="six-digits",
        sentence="Positions are written with six digits.",
        on=("swing",),
        sees=("constraint", "length"),
        after=of_columns(position=digits(6)),
    ),
    output(
        name="twelve-digits",
        sentence="Velocities are written with twelve digits.",
        on=("knock",),
        sees=("momentum", "total"),
        after=of_columns(velocity=digits(12)),
    ),
    output(
        name="attitude-six-digits",
        sentence="Attitudes are written with six digits.",
        on=("tumbler",),
        sees=("quaternion-norm", "norm"),
        after=of_columns(attitude=digits(6)),
    ),
    output(
        name="frozen-end",
        sentence="After three quarters of the run, the same row is repeated.",
        sees=("error", "x"),
        after=of_columns(position=_frozen_end),
    ),
    output(
        name="axes-swapped",
        sentence="y and z are exchanged in the output.",
        on=("orbit",),
        sees=("error", "y"),
        after=of_columns(position=lambda r: r[..., [0, 2, 1]]),
    ),
    output(
        name="mirrored",
        sentence="x has the wrong sign in the output.",
        on=("swing",),
        sees=("error", "theta"),
        after=of_columns(position=lambda r: r * [-1, 1, 1], velocity=lambda v: v * [-1, 1, 1]),
    ),
    output(
        name="velocity-column-of-position",
        sentence="Velocities are finite differences of positions.",
        sees=("error", "v"),
        after=lambda request, run: replace(run, velocity=_rate(run, "position")),
    ),
    output(
        name="largest-only",
        sentence="Speeds are written without their sign.",
        sees=("error", "v"),
        after=of_columns(velocity=np.abs),
    ),
    output(
        name="momentum-for-velocity",
        sentence="Momenta are written instead of velocities.",
        on=("knock",),
        sees=("momentum", "total"),
        after=_momentum,
    ),
    output(
        name="end-from-file",
        sentence=(
            "A run that continues another one starts from velocities rounded to eight decimals."
        ),
        sees=("reversal", "reversed"),
        before=_from_file,
    ),
    output(
        name="frames",
        sentence="Positions are relative to where the bodies started.",
        on=("orbit",),
        sees=("error", "x"),
        after=of_columns(position=lambda r: r - r[:1]),
    ),
    output(
        name="bodies-swapped",
        sentence="The rows of two bodies are exchanged.",
        on=("knock",),
        sees=("error", "r1.x"),
        after=of_columns(position=lambda r: r[:, ::-1], velocity=lambda v: v[:, ::-1]),
    ),
    output(
        name="body-twice",
        sentence="The row of the second body repeats that of the first.",
        on=("bounce",),
        sees=("momentum", "total"),
        after=of_columns(velocity=lambda v: v[:, [0, 0]]),
    ),
    output(
        name="sorted",
        sentence=("Bodies are sorted by velocity, so that their numbers change."),
        on=("knock",),
        sees=("error", "v2.x"),
        after=of_columns(velocity=_sorted_by_velocity),
    ),
)
