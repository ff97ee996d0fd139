"""One run of Chipmunk: the compiled loop over its step, and what it recorded as a trajectory."""

from time import perf_counter
from typing import Any

import numpy as np
import pymunk
from numpy.typing import NDArray
from pymunk._chipmunk_cffi import ffi as engine_ffi
from pymunk._chipmunk_cffi import lib as engine_lib

from refdem import kernels
from refdem.core.problem import Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.pymunk.callbacks import FAMILY, acting, number_of, set_functions
from refdem.engines.pymunk.space import angle_of, space_of
from refdem.errors import EngineError

Array = NDArray[np.float64]
ANGLE = 4
"""Column of the rows of a run, x, y, vx, vy, angle, omega, that has the angle [rad]."""
OMEGA = 5
"""Column that has the angular velocity [rad/s]."""
FUNCTIONS = {
    "step": "cpSpaceStep",
    "position": "cpBodyGetPosition",
    "velocity": "cpBodyGetVelocity",
}
"""Chipmunk's functions that the loop calls, by the names of the compiled struct."""
TURNING = {"angle": "cpBodyGetAngle", "omega": "cpBodyGetAngularVelocity"}
"""The functions that it also calls in scenes in which some body can rotate."""


def recorded(request: Request) -> tuple[Trajectory, Cost]:
    """Runs the request; raises EngineError if Chipmunk was not built with doubles, or if it made a
    wrong number of steps.
    """
    began = perf_counter()
    if engine_ffi.sizeof("cpFloat") != 8 or engine_ffi.sizeof("cpVect") != 16:
        raise EngineError(f"pymunk: cpFloat has {engine_ffi.sizeof('cpFloat')} bytes; expected 8")
    scene = request.problem.scene
    columns = scene.bodies
    start = request.problem.times[0]
    step = request.signed_step
    is_as_shipped = request.method.endswith("-as-shipped")
    space, bodies, laws = space_of(scene, is_tuned=not is_as_shipped)
    ffi = kernels.load(FAMILY).ffi
    lib = kernels.load(FAMILY).lib
    can_turn = (columns.inertia[:, 2] > 0) & ~columns.fixed
    engine = _engine(ffi, space, turns=bool(can_turn.any()))
    handles = ffi.new("void *[]", [_address(ffi, body._body) for body in bodies])
    samples = len(request.problem.times)
    stride = request.stride
    rows = np.full((samples, len(bodies), 6), np.nan)
    # Where no body can rotate, the loop does not write these columns.
    rows[..., ANGLE] = angle_of(columns.attitude)
    rows[..., OMEGA] = 0.0
    out = kernels.pointer(FAMILY, rows, output=True)
    with acting(space, laws, float(start), step):
        started = perf_counter()
        lib.refdem_chipmunk_record(engine, len(bodies), handles, step, samples, stride, out)
        ended = perf_counter()
    steps = int(engine_lib.cpSpaceGetTimestamp(space._space))
    if steps != (samples - 1) * stride:
        raise EngineError(
            f"pymunk: the engine counted {steps} steps; expected {(samples - 1) * stride}"
        )
    t = start + np.arange(samples) * stride * step
    cost = Cost(seconds=ended - started, setup=started - began, steps=steps)
    return _trajectory(request, t, rows), cost


def _engine(ffi: Any, space: pymunk.Space, *, turns: bool) -> Any:
    """Addresses for the compiled loop; angles are not read where nothing can turn."""
    engine = ffi.new("refdem_chipmunk_engine *", {"space": _address(ffi, space._space)})
    functions = dict(FUNCTIONS)
    if turns:
        functions |= TURNING
    set_functions(engine, functions)
    return engine


def _address(ffi: Any, pointer: Any) -> Any:
    """The same address for the loop's own interface."""
    return ffi.cast("void *", number_of(pointer))


def _trajectory(request: Request, t: Array, rows: Array) -> Trajectory:
    """Rows (T, N, 6) of x, y, vx, vy, angle, omega in three dimensions."""
    bodies = request.problem.scene.bodies
    vectors = (*rows.shape[:2], 3)
    position = np.zeros(vectors)
    velocity = np.zeros(vectors)
    omega = np.zeros(vectors)
    position[..., :2] = rows[..., 0:2]
    velocity[..., :2] = rows[..., 2:4]
    omega[..., 2] = rows[..., OMEGA]
    attitude = np.zeros((*rows.shape[:2], 4))
    # Rotation about z by the angle alpha: q = (cos(alpha/2), 0, 0, sin(alpha/2)).
    half_angle = rows[..., ANGLE] / 2
    attitude[..., 0] = np.cos(half_angle)
    attitude[..., 3] = np.sin(half_angle)
    # A body that never rotated keeps its attitude, which need not be a rotation about z.
    keeps_angle = (rows[..., ANGLE] == angle_of(bodies.attitude)).all(axis=0)
    still = ~bodies.omega.any(axis=1) & keeps_angle
    attitude[:, still] = bodies.attitude[still]
    return Trajectory(t=t, position=position, velocity=velocity, attitude=attitude, omega=omega)
