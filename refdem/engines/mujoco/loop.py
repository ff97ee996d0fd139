"""MuJoCo's own loop: `mj_step` called by the recorder, which copies the state out of mjData."""

import ctypes
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem import kernels
from refdem.core.problem import Request
from refdem.errors import EngineError

Array = NDArray[np.float64]


@cache
def _step_address() -> int:
    """Address of `mj_step` in the library that MuJoCo's Python package has loaded."""
    import mujoco

    libraries = sorted(Path(mujoco.__file__).parent.glob("*mujoco*.so*")) + sorted(
        Path(mujoco.__file__).parent.glob("*mujoco*.dylib")
    )
    library = next((path for path in libraries if path.name.startswith("libmujoco")), None)
    if library is None:
        raise EngineError(
            f"mujoco: no libmujoco beside {mujoco.__file__}; expected the library that the package"
            " comes with"
        )
    return ctypes.cast(ctypes.CDLL(str(library)).mj_step, ctypes.c_void_p).value or 0


def clock_address(data: Any) -> int:
    """Address of `data.time`, which stands before `data.energy` in the structure; raises
    EngineError if it does not.
    """
    address = data.energy.ctypes.data - ctypes.sizeof(ctypes.c_double)
    # A unique number is written through the attribute and read back at the address.
    probe = 0.1234567890123
    time = data.time
    data.time = probe
    value_at_address = ctypes.c_double.from_address(address).value
    data.time = time
    if value_at_address != probe:
        raise EngineError(
            "mujoco: mjData.time does not stand before mjData.energy as in 4.0.0; the adapter must"
            " be brought up to date"
        )
    return int(address)


def recorded(model: Any, data: Any, request: Request) -> tuple[Array, float]:
    """Rows (T, nq + nv + 1) of coordinates, velocities and the engine's clock, and the seconds in
    the loop.
    """
    recorder = kernels.load("recorder")
    ffi = recorder.ffi
    lib = recorder.lib
    sizes = [model.nq, model.nv, 1]
    rows = np.full((len(request.problem.times), sum(sizes)), np.nan)
    places = [data.qpos.ctypes.data, data.qvel.ctypes.data, clock_address(data)]
    source = ffi.new("void *[]", [ffi.cast("void *", place) for place in places])
    step, a, b = (
        ffi.cast("void *", address) for address in (_step_address(), model._address, data._address)
    )
    out = kernels.pointer("recorder", rows, output=True)
    began = perf_counter()
    lib.refdem_record(
        step, a, b, len(rows), request.stride, 3, source, ffi.new("int64_t[]", sizes), out
    )
    return rows, perf_counter() - began
