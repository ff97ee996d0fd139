"""One run of REBOUND: the compiled loop over its steps, and what it recorded as a trajectory."""

import warnings
from ctypes import addressof
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
import rebound
from numpy.typing import NDArray
from rebound.ode import ODE

from refdem import kernels
from refdem.core.problem import Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.rebound.fields import FAMILY, Fields, fields_of
from refdem.engines.rebound.methods import LEAPFROG_UNCUT
from refdem.engines.rebound.simulation import function_address, set_collisions, simulation_of
from refdem.errors import EngineError, UsageError
from refdem.mechanics.quaternion import rotated

Array = NDArray[np.float64]
FUNCTIONS = {
    # Field of the compiled loop's struct: function of librebound.
    "steps": "reb_simulation_steps",
    "integrate": "reb_simulation_integrate",
    "update": "reb_simulation_update_acceleration",
}
FINEST_TOLERANCE = 1e-15
"""Smallest tolerance. Smaller errors are below round-off: at 1e-16 bs rejects every step, however
small, without end.
"""
STEPPED = {"leapfrog", "leapfrog-8", "leapfrog-line", "whfast"}
"""Methods with steps of a fixed size: one step per sample unless a step is requested."""


def recorded(request: Request) -> tuple[Trajectory, Cost]:
    """Runs the request; raises EngineError if REBOUND gives up or reports an error."""
    if request.tolerance is not None and request.tolerance < FINEST_TOLERANCE:
        raise UsageError(
            f"rebound, {request.method}: tolerance is {request.tolerance:g}; expected >="
            f" {FINEST_TOLERANCE:g}, or no step is accepted"
        )
    began = perf_counter()
    fields = fields_of(request.problem.scene)
    sim, ode = simulation_of(request, fields)
    if request.method == LEAPFROG_UNCUT.name:
        return _uncut(request, fields, sim, began)
    times = np.ascontiguousarray(request.problem.times)
    stride = _steps_per_sample(request)
    engine = _engine(sim, ode)
    rows = np.full((len(times), _layout(request, fields).row_end), np.nan)
    started = perf_counter()
    failed = kernels.load(FAMILY).lib.refdem_rebound_record(
        engine,
        fields.struct,
        stride,
        len(times),
        kernels.pointer(FAMILY, times),
        kernels.pointer(FAMILY, rows, output=True),
    )
    ended = perf_counter()
    _refuse_failure(sim, request, failed)
    if request.method == "leapfrog-8":
        # Its inner steps move REBOUND's clock; the time is that of the whole steps.
        steps_per_sample = sim.steps_done // (len(times) - 1)
        rows[:, 0] = times[0] + np.arange(len(times)) * steps_per_sample * sim.dt
    cost = Cost(seconds=ended - started, setup=started - began, steps=int(sim.steps_done))
    return _trajectory(request, fields, rows), cost


def _steps_per_sample(request: Request) -> int:
    """The number of steps of the compiled loop from each sample to the next; 0 where REBOUND
    chooses its steps and integrates to the time of the sample.
    """
    if request.step:
        return request.stride
    if request.method in STEPPED:
        return 1
    return 0


class Layout(NamedTuple):
    """The columns of a row: t, then position and velocity of every body, then attitude and omega in
    body axes of every rotor, then the forces of the rods. Each ends where the next begins.
    """

    bodies_end: int
    rotors_end: int
    row_end: int


def _layout(request: Request, fields: Fields) -> Layout:
    """The columns of a row of the request."""
    bodies_end = 1 + 6 * len(request.problem.scene.bodies)
    rotors_end = bodies_end + 7 * len(fields.rotors)
    return Layout(bodies_end, rotors_end, row_end=rotors_end + fields.rods)


UNCUT = (5**0.5 - 1) / 2
"""Size of a step in units of the requested step, such that no step ends at a sample. The multiples
of the golden section (sqrt(5) - 1)/2 stay as far from integers as possible (Hurwitz 1891).
"""


def _uncut(
    request: Request, fields: Fields, sim: rebound.Simulation, began: float
) -> tuple[Trajectory, Cost]:
    """Makes steps of constant size; a copy of the simulation reaches each sample by one shorter
    step.

    Sampling therefore does not change the steps, nor the collisions at their ends.
    """
    times = request.problem.times
    step = UNCUT * request.signed_step
    sim.dt = step
    rows = [_row(sim, float(times[0]))]
    started = perf_counter()
    steps_done = 0
    for time in times[1:]:
        elapsed = float(time - times[0])
        steps_before = int(elapsed / step)
        sim.steps(steps_before - steps_done)
        steps_done = steps_before
        copy = _copy(sim, request)
        copy.dt = elapsed - steps_before * step
        copy.steps(1)
        _refuse_failure(copy, request, failed=0)
        rows.append(_row(copy, float(time)))
    ended = perf_counter()
    _refuse_failure(sim, request, failed=0)
    steps = steps_done + len(times) - 1
    cost = Cost(seconds=ended - started, setup=started - began, steps=steps)
    return _trajectory(request, fields, np.array(rows)), cost


def _copy(sim: rebound.Simulation, request: Request) -> rebound.Simulation:
    """A copy of the simulation with its collisions: REBOUND copies no pointers to functions, which
    it warns of.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        copy = sim.copy()
    set_collisions(copy, request.problem.scene, request.method)
    return copy


def _row(sim: rebound.Simulation, time: float) -> list[float]:
    """The row of `recorded` at a sample, of particles that do not turn."""
    row = [time]
    for body in sim.particles:
        row += [body.x, body.y, body.z, body.vx, body.vy, body.vz]
    return row


def _engine(sim: rebound.Simulation, ode: ODE | None) -> Any:
    """What the compiled loop needs of REBOUND: the addresses of the simulation, its clock, the
    functions that step it, and the values of the further equations.
    """
    ffi = kernels.load(FAMILY).ffi
    engine = ffi.new("refdem_rebound_engine *")
    engine.simulation = ffi.cast("void *", addressof(sim))
    for field, function in FUNCTIONS.items():
        function_type = ffi.typeof(getattr(engine, field))
        setattr(engine, field, ffi.cast(function_type, function_address(function)))
    engine.clock = ffi.cast("double *", addressof(sim) + rebound.Simulation.t.offset)
    if ode is not None:
        engine.equations = ffi.cast("double **", addressof(ode) + ODE.y.offset)
    return engine


def _refuse_failure(sim: rebound.Simulation, request: Request, failed: int) -> None:
    """Raises EngineError with REBOUND's message. Its warnings are not passed on, as the checks
    detect their consequences.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            sim.process_messages()
    except RuntimeError as error:
        raise EngineError(f"rebound, {request.method}: {error}") from None
    if failed:
        where = f"with status {sim._status} before sample {failed - 1}, at t = {sim.t} s"
        raise EngineError(f"rebound, {request.method}: stopped {where}")


def _trajectory(request: Request, fields: Fields, rows: Array) -> Trajectory:
    """The trajectory in the rows (T, ...) of samples; attitudes are divided by their length."""
    bodies = request.problem.scene.bodies
    layout = _layout(request, fields)
    shape = (len(rows), len(bodies))
    state = rows[:, 1 : layout.bodies_end].reshape(*shape, 6)
    attitude = np.empty((*shape, 4))
    attitude[:] = bodies.attitude
    omega = np.zeros((*shape, 3))
    if fields.rotors:
        turned = rows[:, layout.bodies_end : layout.rotors_end].reshape(len(rows), -1, 7)
        unit = turned[..., :4] / np.linalg.norm(turned[..., :4], axis=-1, keepdims=True)
        attitude[:, fields.rotors] = unit
        # The rows have omega in body axes.
        omega[:, fields.rotors] = rotated(unit, turned[..., 4:])
    channels = {}
    if fields.rods:
        channels["rod_force"] = rows[:, layout.rotors_end :].copy()
    return Trajectory(
        t=np.ascontiguousarray(rows[:, 0]),
        position=np.ascontiguousarray(state[..., :3]),
        velocity=np.ascontiguousarray(state[..., 3:]),
        attitude=attitude,
        omega=omega,
        channels=channels,
    )
