"""What is asked of an engine: a motion, and the request for one run of it."""

import hashlib
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.errors import EngineError, UsageError
from refdem.scene import Scene, SceneDocument
from refdem.scene.scene import encoded

Array = NDArray[np.float64]
CLOCK_ROUNDINGS = 8
"""A time in single precision is a step, a number of steps and a start, each rounded, times and plus."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A scene, whose state holds at times[0], and the times (T,) [s] at which states are asked for; may run backwards."""

    scene: Scene
    times: Array

    def __post_init__(self) -> None:
        gaps = np.diff(self.times)
        if self.times.ndim != 1 or len(self.times) < 2 or not (np.all(gaps > 0) or np.all(gaps < 0)):
            raise UsageError(f"times has shape {self.times.shape}; expected (T,) with T >= 2, all rising or all falling")

    @property
    def interval(self) -> float:
        """Time [s] between samples, negative for a run backwards."""
        return float(self.times[1] - self.times[0])


class RequestDocument(msgspec.Struct, frozen=True, kw_only=True):
    """A request as `request.json` has it."""

    format: int = 1
    method: str
    step: float | None
    tolerance: float | None
    times: list[float]
    scene: SceneDocument


@dataclass(frozen=True, eq=False, kw_only=True)
class Request:
    """One run: problem, method, and its step [s] (size only) or tolerance; neither for exact methods."""

    problem: Motion
    method: str
    step: float | None = None
    tolerance: float | None = None
    repeat: int = 0

    def __post_init__(self) -> None:
        if self.step is not None and not 0 < self.step < float("inf"):
            raise UsageError(f"step is {self.step}; expected a finite number > 0")
        if self.tolerance is not None and not 0 < self.tolerance < 1:
            raise UsageError(f"tolerance is {self.tolerance}; expected a number between 0 and 1")

    @classmethod
    def from_json(cls, text: bytes) -> "Request":
        """Reads what `document` wrote as JSON; raises UsageError with the path of the first fault."""
        try:
            read = msgspec.json.decode(text, type=RequestDocument)
        except msgspec.MsgspecError as error:
            raise UsageError(f"request: {error}") from None
        problem = Motion(Scene.of(read.scene.bodies, read.scene.elements), np.array(read.times))
        return cls(problem=problem, method=read.method, step=read.step, tolerance=read.tolerance)

    def to_json(self) -> bytes:
        """The request as `request.json` has it; the same bytes for the same request."""
        return encoded(self.document())

    @property
    def signed_step(self) -> float:
        """The step [s] with the direction of time."""
        return float(np.copysign(self.step or 0.0, self.problem.interval))

    @property
    def stride(self) -> int:
        """Steps from sample to sample; raises UsageError if the step does not divide the sample interval."""
        if self.step is None:
            raise UsageError("stride: the method has no fixed step")
        exact = abs(self.problem.interval) / self.step
        if abs(exact - round(exact)) > 1e-9 * exact or round(exact) < 1:
            raise UsageError(f"step is {self.step} s; expected a whole fraction of the sample interval {abs(self.problem.interval)} s")
        return round(exact)

    def document(self) -> RequestDocument:
        """The request as JSON has it."""
        scene = self.problem.scene.document()
        return RequestDocument(method=self.method, step=self.step, tolerance=self.tolerance, times=self.problem.times.tolist(), scene=scene)

    def key(self, *fingerprints: str) -> str:
        """sha256 of the request, of which repetition it is, and of the fingerprints of engine and kernels."""
        digest = hashlib.sha256(self.to_json())
        for part in (str(self.repeat), *fingerprints):
            digest.update(b"\0" + part.encode())
        return digest.hexdigest()

    def with_scene(self, scene: Scene, times: Array | None = None) -> "Request":
        """The same request for another state, or other times."""
        return replace(self, problem=Motion(scene, self.problem.times if times is None else times))

    def refuse_misaligned(self, t: Array, round_off: float = 2.0**-53) -> None:
        """Raises EngineError unless the engine's own times `t` are the samples asked for, to the round-off of its precision."""
        times = self.problem.times
        if t.shape != times.shape:
            raise EngineError(f"trajectory.t has {len(t)} samples; expected {len(times)}")
        allowed = max(1e-12, CLOCK_ROUNDINGS * round_off) * max(abs(times[0]), abs(times[-1]), abs(self.problem.interval))
        worst: Any = np.argmax(np.abs(t - times))
        if abs(t[worst] - times[worst]) > allowed:
            raise EngineError(f"trajectory.t[{worst}] is {t[worst]:.17g} s; expected {times[worst]:.17g} s, the sample that was asked for")
