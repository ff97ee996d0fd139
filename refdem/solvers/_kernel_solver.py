"""A method that is one call of a kernel: what is alike in all of them is here, once.

A solver says what the kernel is told and where it writes (`prepare`), and what that means as a
trajectory (`finish`). Buffers become pointers, both clocks run, and the cost is made, in `run`.
"""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Problem, Request
from refdem.core.trajectory import Cost, Event, Trajectory
from refdem.kernels import load, pointer, prepared, repeats, timed
from refdem.solvers._scene_pattern import SceneSolver
from refdem.solvers.solver import Solver

Array = NDArray[np.float64]


class Struct:
    """A struct of a kernel's, and the arrays that it points to: they live as long as it does."""

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
    """One call of a kernel: `inputs`, `clock` and `outputs` are its arguments, in this order.

    Arrays of inputs and clock are read, those of outputs are written in place; an array without
    elements, and None, are NULL. `steps` are the steps that it takes, 0 for a method without.
    """

    function: str
    inputs: tuple[Any, ...]
    clock: tuple[Any, ...]
    outputs: tuple[Any, ...]
    steps: int = 0

    def arguments(self, family: str) -> list[Any]:
        """The arguments as the function takes them."""
        told = [_input(family, value) for value in (*self.inputs, *self.clock)]
        written = [_output(family, array) for array in self.outputs]
        return told + written

    def made(self, family: str) -> int:
        """Calls once; returns what the kernel returned."""
        function = getattr(load(family).lib, self.function)
        return int(function(*self.arguments(family)))

    def answered(self, family: str) -> tuple[float, int]:
        """Seconds of one call, and what the kernel returned; within `repeated` it calls more often.

        Where the kernel makes something of the start before it is asked for samples, the call has
        two parts, and the first is set-up.
        """
        lib = load(family).lib
        arguments = self.arguments(family)
        prepare = getattr(lib, f"{self.function}_prepare", None)
        if prepare is None:
            return timed(getattr(lib, self.function), *arguments)
        motion = prepared(family)
        prepare(*arguments, motion)
        return timed(getattr(lib, f"{self.function}_run"), motion)


class KernelRun(Solver):
    """A method that answers by one call of the first of its kernels."""

    @abstractmethod
    def prepare(self, request: Request) -> KernelCall:
        """What the kernel is told, and the arrays that it fills."""

    @abstractmethod
    def finish(self, request: Request, call: KernelCall, status: int) -> Trajectory:
        """The trajectory that the filled arrays say; raises EngineError or UnsupportedError where
        `status`, what the kernel returned, says that it did not come to the end.
        """

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Prepares, calls, finishes; the cost is that of the call, and of all before it."""
        begun = perf_counter()
        call = self.prepare(request)
        seconds, status = call.answered(self.kernels[0])
        setup = perf_counter() - begun - repeats() * seconds
        found = self.finish(request, call, status)
        return found, Cost(seconds=seconds, setup=setup, steps=call.steps)


class KernelSolver(SceneSolver, KernelRun):
    """A method for scenes of one pattern that answers by one call of a kernel."""


class Elapsed:
    """Time since the start, counted upwards in whichever direction the samples go.

    For kernels that run forward only: a motion backwards is one with flipped velocities.
    """

    def __init__(self, problem: Problem) -> None:
        self.start = float(problem.times[0])
        self.sense = float(np.sign(problem.interval))
        self.since: Array = self.sense * (problem.times - problem.times[0])

    def events(self, told: Mapping[str, float]) -> tuple[Event, ...]:
        """Events of body 0 by their kind, from when they are after the start [s]; those that no
        sample comes to, and those before the start, are left out.
        """
        return tuple(
            Event(time=float(self.start + self.sense * when), kind=kind, body=0)
            for kind, when in told.items()
            if 0 < when <= self.since[-1]
        )


def samples(t: Array) -> tuple[int, Array]:
    """The clock of a kernel that is told the samples: how many, and when [s]."""
    return len(t), np.ascontiguousarray(t)


def samples_from_start(t: Array) -> tuple[float, int, Array]:
    """The clock of a kernel that is told its start [s] besides."""
    return float(t[0]), len(t), np.ascontiguousarray(t)


def steps_to_samples(request: Request) -> tuple[float, int, int]:
    """The clock of a kernel that steps: signed step [s], number of samples, steps a sample."""
    return request.signed_step, len(request.problem.times), request.stride


def steps_of(request: Request) -> int:
    """Steps from the first sample to the last."""
    return request.stride * (len(request.problem.times) - 1)


def turning_states(bodies: Any, columns: Mapping[str, Array]) -> dict[str, Any]:
    """Columns (T, n) of one body as those of a trajectory, (T, 1, n).

    The first row is the start as it came, not as it is rounded on its way through the kernel.
    """
    rows = {}
    for name, values in columns.items():
        values[0] = getattr(bodies, name)[0]
        rows[name] = np.ascontiguousarray(values[:, None])
    return rows


def _input(family: str, value: Any) -> Any:
    """A number as it is; of a struct its address; of an array a pointer."""
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
    """A pointer to what the kernel writes."""
    ffi = load(family).ffi
    if array is None:
        return ffi.NULL
    if array.dtype == np.int64:
        return ffi.from_buffer("int64_t[]", array, require_writable=True)
    if array.dtype == np.uint8:
        return ffi.from_buffer("uint8_t[]", array, require_writable=True)
    return pointer(family, array, output=True)
