"""Base of the methods that answer by one call of a C kernel.

A solver describes the call (`prepare`: inputs, clock, output arrays) and reads the filled arrays
(`finish`). This module turns arrays into C pointers, makes the call and measures its cost.
"""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Motion, Problem, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.kernels import load, pointer, prepared, repeats, timed
from refdem.solvers._scene_pattern import SceneSolver
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]


class Struct:
    """A C struct of a kernel, with the arrays that its fields point to, which live as long as it
    does.
    """

    def __init__(self, family: str, name: str, fields: Mapping[str, Any]) -> None:
        self.arrays = {
            field: np.ascontiguousarray(value)
            for field, value in fields.items()
            if isinstance(value, np.ndarray)
        }
        addresses = {field: _input(family, array) for field, array in self.arrays.items()}
        self.address = load(family).ffi.new(f"{name} *", {**fields, **addresses})


@dataclass(frozen=True, eq=False, kw_only=True)
class KernelCall:
    """One call of a kernel. Its arguments are `inputs`, `clock` and `outputs`, in this order.

    Arrays in `inputs` and `clock` are read, those in `outputs` are written in place; an empty array
    and None become NULL. `steps` is the number of time steps that the call takes, 0 for a method
    without steps.
    """

    function: str
    inputs: tuple[Any, ...]
    clock: tuple[Any, ...]
    outputs: tuple[Any, ...]
    steps: int = 0

    def arguments(self, family: str) -> list[Any]:
        """The arguments as C values and pointers."""
        inputs = [_input(family, value) for value in (*self.inputs, *self.clock)]
        written = [_output(family, array) for array in self.outputs]
        return inputs + written

    def made(self, family: str) -> int:
        """Makes the call once and returns the kernel's status."""
        function = getattr(load(family).lib, self.function)
        return int(function(*self.arguments(family)))

    def answered(self, family: str) -> tuple[float, int]:
        """Makes the call and returns its time [s] and the kernel's status; inside `repeated` it is
        called several times.

        A kernel with a function NAME_prepare is called in two parts, and only the second, NAME_run,
        is timed.
        """
        lib = load(family).lib
        arguments = self.arguments(family)
        prepare = getattr(lib, f"{self.function}_prepare", None)
        if prepare is None:
            return timed(getattr(lib, self.function), *arguments)
        state = prepared(family)
        prepare(*arguments, state)
        return timed(getattr(lib, f"{self.function}_run"), state)


class KernelRun(Solver):
    """A method that answers by one call of the first of its kernels."""

    @abstractmethod
    def prepare(self, request: Request) -> KernelCall:
        """The call of the kernel, with its output arrays allocated."""

    @abstractmethod
    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """The trajectory in the filled arrays of the call.

        Raises EngineError or UnsupportedError if `status`, the kernel's return value, says that it
        stopped early.
        """

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Prepares, calls and finishes. The cost is the time of the call; all before it is
        set-up.
        """
        begun = perf_counter()
        call = self.prepare(request)
        seconds, status = call.answered(self.kernels[0])
        setup = perf_counter() - begun - repeats() * seconds
        trajectory = self.finish(request, call, status)
        return trajectory, Cost(seconds=seconds, setup=setup, steps=call.steps)


class KernelSolver(SceneSolver, KernelRun):
    """A method for scenes of one pattern that answers by one call of a kernel."""

    def unsupported(self, problem: Motion) -> str | None:
        """None if the scene has the pattern, fits the method, and the motion reaches its last
        sample; else the reason.
        """
        return super().unsupported(problem) or self.unsupported_times(problem)

    def unsupported_times(self, problem: Motion) -> str | None:
        """None if the motion continues to its last sample, else what ends it.

        Called only for scenes that match the pattern and its values. Some motions end at a point
        beyond which the scene has no law. A trial run detects this. The trial is made here, because
        the reference may refuse a problem before a run, but not during one.
        """
        return None


class Elapsed:
    """Time since the start, counted upwards in either direction of time.

    For kernels that run forward only: a motion backward in time is the forward motion with
    velocities reversed. `sense` is +1 or -1, `since` (T,) [s] the elapsed time at the samples.
    """

    def __init__(self, problem: Problem) -> None:
        self.start = float(problem.times[0])
        self.sense = float(np.sign(problem.interval))
        self.since: Array = self.sense * (problem.times - problem.times[0])

    def events(self, times_by_kind: Mapping[str, float]) -> tuple[Event, ...]:
        """Events of body 0 from their elapsed times [s] by kind; those before the start or after
        the last sample are left out.
        """
        return tuple(
            Event(time=float(self.start + self.sense * elapsed), kind=kind, body=0)
            for kind, elapsed in times_by_kind.items()
            if 0 < elapsed <= self.since[-1]
        )


def samples(t: Array) -> tuple[int, Array]:
    """Clock arguments of a kernel that takes sample times: their number, and the times [s]."""
    return len(t), np.ascontiguousarray(t)


def samples_from_start(t: Array) -> tuple[float, int, Array]:
    """Clock arguments of a kernel that also takes the start [s]: start, number of samples, times
    [s].
    """
    return float(t[0]), len(t), np.ascontiguousarray(t)


def steps_to_samples(request: Request) -> tuple[float, int, int]:
    """Clock arguments of a kernel with fixed steps: signed step [s], number of samples, steps per
    sample.
    """
    return request.signed_step, len(request.problem.times), request.stride


def steps_of(request: Request) -> int:
    """Number of steps from the first sample to the last."""
    return request.stride * (len(request.problem.times) - 1)


def turning_states(bodies: Any, columns: Mapping[str, Array]) -> dict[str, Any]:
    """Columns (T, n) of the one body as those of a trajectory, (T, 1, n).

    Row 0 becomes the exact initial state, which the kernel may have rounded.
    """
    rows = {}
    for name, values in columns.items():
        values[0] = getattr(bodies, name)[0]
        rows[name] = np.ascontiguousarray(values[:, None])
    return rows


def _input(family: str, value: Any) -> Any:
    """The C value of an argument: a number itself, a struct's address, an array's pointer, NULL for
    None.
    """
    ffi = load(family).ffi
    if isinstance(value, Struct):
        return value.address
    if value is None:
        return ffi.NULL
    if not isinstance(value, np.ndarray):
        return value
    if value.size == 0:
        return ffi.NULL
    if value.dtype == np.int64:
        return ffi.from_buffer("int64_t[]", value)
    # cffi keeps a contiguous copy alive as long as its pointer.
    return pointer(family, np.ascontiguousarray(value))


def _output(family: str, array: Any) -> Any:
    """A pointer to an array that the kernel writes; NULL for None."""
    ffi = load(family).ffi
    if array is None:
        return ffi.NULL
    if array.dtype == np.int64:
        return ffi.from_buffer("int64_t[]", array, require_writable=True)
    if array.dtype == np.uint8:
        return ffi.from_buffer("uint8_t[]", array, require_writable=True)
    return pointer(family, array, output=True)
