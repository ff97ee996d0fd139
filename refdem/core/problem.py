"""What is asked of an engine: a question of some kind, and the request for one run of it."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.ensemble import Ensemble, EnsembleDocument
from refdem.core.question import DENSE, PER_OCTAVE, Iteration, IterationDocument, Motion, Problem
from refdem.core.statics import Identity, IdentityDocument, Solid, SolidDocument
from refdem.errors import EngineError, UsageError
from refdem.scene import Scene, SceneDocument, bodies_file
from refdem.scene.scene import encoded

__all__ = ["DENSE", "PER_OCTAVE", "Ensemble", "Identity", "Iteration", "Motion", "Problem", "Request", "RequestDocument", "Solid"]

Array = NDArray[np.float64]
CLOCK_ROUNDINGS = 8
"""A time in single precision is a step, a number of steps and a start, each rounded, times and plus."""


def _iteration(read: IterationDocument) -> Iteration:
    return Iteration(read.map, np.array(read.start), read.n)


AnyDocument = IterationDocument | SolidDocument | IdentityDocument | EnsembleDocument
OTHERS: dict[type, Callable[[Any], Problem]] = {
    IterationDocument: _iteration,
    SolidDocument: Solid,
    IdentityDocument: Identity,
    EnsembleDocument: Ensemble.read,
}
"""How each document of a question that is no motion is read back."""


class RequestDocument(msgspec.Struct, frozen=True, kw_only=True):
    """A request as `request.json` has it."""

    format: int = 1
    method: str
    step: float | None
    tolerance: float | None
    times: list[float]
    scene: SceneDocument


class OtherRequestDocument(msgspec.Struct, frozen=True, kw_only=True):
    """A request for anything but a motion; step and tolerance only where the method has one."""

    format: int = 1
    method: str
    problem: AnyDocument
    step: float | msgspec.UnsetType = msgspec.UNSET
    tolerance: float | msgspec.UnsetType = msgspec.UNSET


class _Kind(msgspec.Struct):
    problem: msgspec.Raw = msgspec.Raw()


@dataclass(frozen=True, eq=False, kw_only=True)
class Request:
    """One run: problem, method, and its step [s] (size only) or tolerance; neither for exact methods."""

    problem: Problem
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
    def from_json(cls, text: bytes, file: bytes | None = None) -> "Request":
        """Reads what `document` wrote as JSON, and the bodies' file if it names one; raises UsageError with the path of the first fault."""
        try:
            if bytes(msgspec.json.decode(text, type=_Kind).problem):
                other = msgspec.json.decode(text, type=OtherRequestDocument)
                control = {name: value for name in ("step", "tolerance") if (value := getattr(other, name)) is not msgspec.UNSET}
                return cls(problem=OTHERS[type(other.problem)](other.problem), method=other.method, **control)
            read = msgspec.json.decode(text, type=RequestDocument)
        except msgspec.MsgspecError as error:
            raise UsageError(f"request: {error}") from None
        problem = Motion(Scene.of_document(read.scene, file), np.array(read.times))
        return cls(problem=problem, method=read.method, step=read.step, tolerance=read.tolerance)

    def to_json(self) -> bytes:
        """The request as `request.json` has it; the same bytes for the same request."""
        return encoded(self.document())

    @property
    def bodies_file(self) -> bytes | None:
        """The file `bodies.npz` that goes with the JSON of a motion of too many bodies to be listed there."""
        has_one = isinstance(self.problem, Motion) and self.problem.scene.has_bodies_file
        return bodies_file.packed(self.problem.scene.bodies) if has_one else None

    def packed(self) -> bytes:
        """The request for another process: its JSON; where there are too many bodies for that, JSON and their file."""
        file = self.bodies_file
        return self.to_json() if file is None else msgspec.msgpack.encode((self.to_json(), file))

    @classmethod
    def unpacked(cls, data: bytes) -> "Request":
        """The request that `packed` wrote."""
        return cls.from_json(*((data,) if data.startswith(b"{") else msgspec.msgpack.decode(data, type=tuple[bytes, bytes])))

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

    def document(self) -> RequestDocument | OtherRequestDocument:
        """The request as JSON has it."""
        if not isinstance(self.problem, Motion):
            control = {name: value for name in ("step", "tolerance") if (value := getattr(self, name)) is not None}
            return OtherRequestDocument(method=self.method, problem=self.problem.document(), **control)
        scene = self.problem.document()
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
        """Raises EngineError unless the engine's own times `t` are the samples asked for, to the round-off of its precision.

        A clock may be the sum of its steps, which rounds as often.
        """
        times = self.problem.times
        if t.shape != times.shape:
            raise EngineError(f"trajectory.t has {len(t)} samples; expected {len(times)}")
        steps = 0 if self.step is None else self.stride * (len(times) - 1)
        allowed = max(1e-12, CLOCK_ROUNDINGS * round_off, steps * 2.0**-53) * max(abs(times[0]), abs(times[-1]), abs(self.problem.interval))
        worst: Any = np.argmax(np.abs(t - times))
        if abs(t[worst] - times[worst]) > allowed:
            raise EngineError(f"trajectory.t[{worst}] is {t[worst]:.17g} s; expected {times[worst]:.17g} s, the sample that was asked for")
