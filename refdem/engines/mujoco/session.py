"""One run: the scene compiled, stepped in MuJoCo's own loop, and read in numpy."""

from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Request
from refdem.core.trajectory import STATE, Cost, Trajectory
from refdem.engines.mujoco import derivatives
from refdem.engines.mujoco.belts import press
from refdem.engines.mujoco.joints import Freedom
from refdem.engines.mujoco.loop import clock_address, recorded
from refdem.engines.mujoco.model import compiled
from refdem.engines.mujoco.passive import acting
from refdem.engines.mujoco.turning import Hinge
from refdem.errors import EngineError

Array = NDArray[np.float64]


def run(request: Request) -> tuple[Trajectory, Cost]:
    """Trajectory and cost of one request; raises EngineError for MuJoCo's warnings and numbers that
    are not finite.
    """
    import mujoco

    began = perf_counter()
    warnings: list[str] = []
    kept = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(warnings.append)  # otherwise it prints and writes MUJOCO_LOG.TXT
    try:
        model, freedoms = compiled(request)
        data = _started(mujoco, model, freedoms, request)
        places = [_columns(model, freedoms, number) for number in range(len(freedoms))]
        with acting(mujoco, request.problem.scene, places, data, clock_address(data)):
            mujoco.mj_step(
                model, _started(mujoco, model, freedoms, request)
            )  # raises errors here that would end the process in the loop
            setup = perf_counter() - began
            rows, seconds = recorded(model, data, request)
            tangents = None
            if request.sensitivities:
                tangents = derivatives.chained(mujoco, model, data, request, rows)
        _refuse_warnings(data, warnings)
        trajectory = _trajectory(mujoco, model, freedoms, rows)
        if tangents is not None:
            started = partial(_start, model)
            read = partial(_states, model, freedoms)
            slopes = derivatives.of_states(mujoco, model, request, rows, tangents, started, read)
            trajectory = replace(trajectory, derivatives=slopes)
    except (mujoco.FatalError, mujoco.UnexpectedError, ValueError) as error:
        raise EngineError(f"mujoco: {error}") from None
    finally:
        mujoco.set_mju_user_warning(kept)
    request.refuse_misaligned(trajectory.t)
    return trajectory, Cost(seconds=seconds, setup=setup, steps=request.stride * (len(rows) - 1))


def _started(mujoco: Any, model: Any, freedoms: list[Freedom], request: Request) -> Any:
    """MjData at the scene's state and the first time."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = _start(model, freedoms)
    data.time = float(request.problem.times[0])
    press(request.problem.scene, data)
    return data


def _start(model: Any, freedoms: list[Freedom]) -> tuple[Array, Array]:
    """All coordinates (nq,) and velocities (nv,) at the start."""
    all_q = np.zeros(model.nq)
    all_v = np.zeros(model.nv)
    for number, freedom in enumerate(freedoms):
        q, v = _columns(model, freedoms, number)
        # The body's own coordinates come last, after those of the bodies that it hangs from.
        own_q = q[len(q) - freedom.nq :]
        own_v = v[len(v) - freedom.nv :]
        all_q[own_q], all_v[own_v] = freedom.start()
    return all_q, all_v


def _refuse_warnings(data: Any, warnings: list[str]) -> None:
    """Raises EngineError if MuJoCo warned of anything."""
    if warnings or any(data.warning[n].number for n in range(len(data.warning))):
        raise EngineError(f"mujoco warned: {(warnings or ['see mjData.warning'])[0].strip()}")


def _trajectory(mujoco: Any, model: Any, freedoms: list[Freedom], rows: Array) -> Trajectory:
    """The recorded rows (T, nq + nv + 1) of coordinates, velocities and clock as a trajectory."""
    q = rows[:, : model.nq]
    v = rows[:, model.nq : -1]
    columns: Any = _states(model, freedoms, q, v)
    channels = {}
    if any(isinstance(freedom, Hinge) for freedom in freedoms):
        channels["rod_force"] = _rod_force(mujoco, model, q, v)
    return Trajectory(t=np.ascontiguousarray(rows[:, -1]), channels=channels, **columns)


def _states(model: Any, freedoms: list[Freedom], q: Array, v: Array) -> dict[str, Array]:
    """The states of all bodies by column (T, N, ...) from coordinates and velocities."""
    bodies = []
    for number, freedom in enumerate(freedoms):
        q_columns, v_columns = _columns(model, freedoms, number)
        bodies.append(freedom.read(q[:, q_columns], v[:, v_columns]))
    return {name: np.stack([getattr(body, name) for body in bodies], axis=1) for name in STATE}


def _columns(model: Any, freedoms: list[Freedom], number: int) -> tuple[list[int], list[int]]:
    """The indices in qpos, and those in qvel, of the joints that move body `number`: its own and
    those of the bodies from which it hangs.
    """
    q: list[int] = []
    v: list[int] = []
    for freedom in freedoms[number].lineage:
        # A body that is fixed has no joint.
        if not freedom.nq:
            continue
        # Two bodies may have equal joints, so the body itself is identified by its number.
        owner = number
        if freedom is not freedoms[number]:
            owner = freedoms.index(freedom)
        joint = int(model.body(f"body {owner}").jntadr[0])
        first_q = int(model.jnt_qposadr[joint])
        first_v = int(model.jnt_dofadr[joint])
        q += range(first_q, first_q + freedom.nq)
        v += range(first_v, first_v + freedom.nv)
    return q, v


def _rod_force(mujoco: Any, model: Any, q: Array, v: Array) -> Array:
    """Tension (T, number of rods) [N] that MuJoCo's force sensors show at the samples; (T,) for one
    rod.

    A step leaves sensors at its start, so that each sampled state is evaluated once more.
    """
    model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
    data = mujoco.MjData(model)
    sensor_data = np.empty((len(q), model.nsensordata))
    for row, (coordinates, velocities) in enumerate(zip(q, v, strict=True)):
        data.qpos[:] = coordinates
        data.qvel[:] = velocities
        mujoco.mj_forward(model, data)
        sensor_data[row] = data.sensordata
    tension = sensor_data[:, 1::3]
    if tension.shape[1] == 1:
        tension = tension[:, 0]
    return np.ascontiguousarray(tension)
