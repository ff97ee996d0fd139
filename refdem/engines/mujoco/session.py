"""One run: the scene compiled, stepped in MuJoCo's own loop, and read in numpy."""

from itertools import accumulate, pairwise
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.mujoco.joints import Freedom
from refdem.engines.mujoco.loop import recorded
from refdem.engines.mujoco.model import compiled
from refdem.engines.mujoco.turning import Hinge
from refdem.errors import EngineError

Array = NDArray[np.float64]


def run(request: Request) -> tuple[Trajectory, Cost]:
    """Trajectory and cost of one request; raises EngineError for MuJoCo's warnings and numbers that are not finite."""
    import mujoco

    began = perf_counter()
    warnings: list[str] = []
    kept = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(warnings.append)  # else it prints, and writes MUJOCO_LOG.TXT
    try:
        model, freedoms = compiled(request)
        data = _started(mujoco, model, freedoms, request)
        mujoco.mj_step(model, _started(mujoco, model, freedoms, request))  # raises here what would end the process in the loop
        setup = perf_counter() - began
        rows, seconds = recorded(model, data, request)
        _refuse_warnings(data, warnings)
        trajectory = _trajectory(mujoco, model, freedoms, rows)
    except (mujoco.FatalError, mujoco.UnexpectedError, ValueError) as error:
        raise EngineError(f"mujoco: {error}") from None
    finally:
        mujoco.set_mju_user_warning(kept)
    request.refuse_misaligned(trajectory.t)
    return trajectory, Cost(seconds=seconds, setup=setup, steps=request.stride * (len(rows) - 1))


def _started(mujoco: Any, model: Any, freedoms: list[Freedom], request: Request) -> Any:
    """MjData at the scene's state and the first time."""
    data = mujoco.MjData(model)
    starts = [freedom.start() for freedom in freedoms]
    data.qpos[:] = np.concatenate([q for q, _ in starts])
    data.qvel[:] = np.concatenate([v for _, v in starts])
    data.time = float(request.problem.times[0])
    return data


def _refuse_warnings(data: Any, warnings: list[str]) -> None:
    """Raises EngineError if MuJoCo warned of anything."""
    if warnings or any(data.warning[n].number for n in range(len(data.warning))):
        raise EngineError(f"mujoco warned: {(warnings or ['see mjData.warning'])[0].strip()}")


def _trajectory(mujoco: Any, model: Any, freedoms: list[Freedom], rows: Array) -> Trajectory:
    """The recorded rows in the scene's terms."""
    q, v = rows[:, : model.nq], rows[:, model.nq : -1]
    cuts_q = list(pairwise(accumulate((f.nq for f in freedoms), initial=0)))
    cuts_v = list(pairwise(accumulate((f.nv for f in freedoms), initial=0)))
    read = [f.read(q[:, slice(*a)], v[:, slice(*b)]) for f, a, b in zip(freedoms, cuts_q, cuts_v, strict=True)]
    columns: Any = {
        name: np.stack([getattr(body, name) for body in read], axis=1) for name in ("position", "velocity", "attitude", "omega")
    }
    channels = {"rod_force": _rod_force(mujoco, model, q, v)} if any(isinstance(f, Hinge) for f in freedoms) else {}
    return Trajectory(t=np.ascontiguousarray(rows[:, -1]), channels=channels, **columns)


def _rod_force(mujoco: Any, model: Any, q: Array, v: Array) -> Array:
    """Tension (T, number of rods) [N] that MuJoCo's force sensors show at the samples; (T,) for one rod.

    A step leaves sensors at its start, so that each sampled state is evaluated once more.
    """
    model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
    data = mujoco.MjData(model)
    felt = np.empty((len(q), model.nsensordata))
    for row, (coordinates, velocities) in enumerate(zip(q, v, strict=True)):
        data.qpos[:], data.qvel[:] = coordinates, velocities
        mujoco.mj_forward(model, data)
        felt[row] = data.sensordata
    tension = felt[:, 1::3]
    return np.ascontiguousarray(tension[:, 0] if tension.shape[1] == 1 else tension)
