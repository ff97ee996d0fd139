"""Requests: one run of a problem by one method, as JSON for a program, with a key for the store.

The problem is a question of some kind (core/problem_kinds.py, core/ensemble.py and
core/static_problems.py).
With a step h the samples are `stride` steps apart: t_(n+1) - t_n = stride h.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from refdem.core.ensemble import Ensemble, EnsembleDocument
from refdem.core.problem_kinds import (
    DENSE,
    PER_OCTAVE,
    Iteration,
    IterationDocument,
    Motion,
    Problem,
)
from refdem.core.reading import json_as
from refdem.core.static_problems import Identity, IdentityDocument, Solid, SolidDocument
from refdem.errors import EngineError, UsageError
from refdem.scene import Scene, SceneDocument, bodies_file
from refdem.scene.bodies_file import MOST_LISTED
from refdem.scene.scene import encoded

__all__ = [
    "DENSE",
    "PER_OCTAVE",
    "Ensemble",
    "Identity",
    "Iteration",
    "Motion",
    "Problem",
    "Request",
    "RequestDocument",
    "Solid",
]

Array = NDArray[np.float64]
CLOCK_ROUNDINGS = 8
"""Roundings allowed for a time start + count * step in single precision: five (three numbers, a
product and a sum), and three more.
"""
UNEVEN = 1e-3
"""Largest deviation of a sample from a whole number of steps, in steps: its time is rounded."""
WHOLE = 1e-9
"""Relative error of the quotient of sample interval and step, both rounded."""
MISCOUNTED = 0.01
"""Tolerance, in steps, within which the error of a clock counts as a whole number of steps."""
FORMAT = 1
"""The version of the format of a request; a request of another version is refused."""
FEW = 100
"""Largest number of bodies that are written as JSON to another process. More are written as columns
of numbers, which is faster.
"""
COUNT = "count `stride` steps from each sample to the next and never compare times"
"""Advice to a program whose steps miss the samples."""


def _iteration(document: IterationDocument) -> Iteration:
    return Iteration(document.map, np.array(document.start), document.n)


AnyDocument = IterationDocument | SolidDocument | IdentityDocument | EnsembleDocument
OTHERS: dict[type, Callable[[Any], Problem]] = {
    IterationDocument: _iteration,
    SolidDocument: Solid,
    IdentityDocument: Identity,
    EnsembleDocument: Ensemble.read,
}
"""The function that makes the problem from a document, by the type of the document; motions have a
document of their own.
"""


class RequestDocument(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The content of `request.json` for a motion."""

    format: int = FORMAT
    method: str
    step: Annotated[
        float | None,
        Meta(
            description=(
                "size of a step [s], positive also where times fall; null for a method without one"
            )
        ),
    ]
    stride: Annotated[
        int | None,
        Meta(
            description=(
                "steps from each sample to the next: the program counts them and never compares"
                " times, because a sum of steps is rounded; null for a method without a step"
            )
        ),
    ] = None
    tolerance: float | None
    times: Annotated[
        list[float],
        Meta(
            description=(
                "the samples [s], all rising or all falling; the scene is the state at the "
                "first; with a step they are evenly spaced, `stride` steps apart"
            )
        ),
    ]
    scene: SceneDocument
    threads: (
        Annotated[
            int,
            Meta(
                ge=1,
                description=(
                    "threads on which to run, 1 if it is not there; more are asked for only of a"
                    " method that claims `threads`"
                ),
            ),
        ]
        | msgspec.UnsetType
    ) = msgspec.UNSET
    sensitivities: (
        Annotated[
            list[str],
            Meta(
                description=(
                    "keys of numbers of the scene, such as scene.bodies.0.mass, by which the"
                    " states are to be differentiated; asked only of a method that"
                    " `differentiates`"
                )
            ),
        ]
        | msgspec.UnsetType
    ) = msgspec.UNSET


class OtherRequestDocument(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A request for anything but a motion; step and tolerance only where the method has one."""

    format: int = FORMAT
    method: str
    problem: AnyDocument
    step: float | msgspec.UnsetType = msgspec.UNSET
    tolerance: float | msgspec.UnsetType = msgspec.UNSET


class _Kind(msgspec.Struct):
    """The field that distinguishes the two kinds of request documents: that of a motion has no
    `problem`.
    """

    problem: msgspec.Raw = msgspec.Raw()


def _refuse_format(version: int) -> None:
    """Raises UsageError for a request that another version of refdem wrote."""
    if version != FORMAT:
        raise UsageError(f"request: format is {version}; expected {FORMAT}")


@dataclass(frozen=True, eq=False, kw_only=True)
class Request:
    """One run: a problem, the name of the method, and its step [s] (size only) or tolerance.

    Exact methods have neither. `repeat` numbers requests that are otherwise equal. `threads` is set
    for methods that claim the same bits for any number of threads. `sensitivities` are keys of
    numbers of the scene by which the states are to be differentiated.
    """

    problem: Problem
    method: str
    step: float | None = None
    tolerance: float | None = None
    repeat: int = 0
    threads: int = 1
    sensitivities: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.threads < 1:
            raise UsageError(f"threads is {self.threads}; expected a whole number of at least 1")
        if self.step is not None and not 0 < self.step < float("inf"):
            raise UsageError(f"step is {self.step}; expected a finite number > 0")
        if self.tolerance is not None and not 0 < self.tolerance < 1:
            raise UsageError(f"tolerance is {self.tolerance}; expected a number between 0 and 1")

    @classmethod
    def from_json(cls, text: bytes, file: bytes | None = None) -> "Request":
        """The request in a JSON text, with the bytes of the bodies' file if it names one.

        Raises UsageError with the path of the first fault.
        """
        # Only the document of a question other than a motion has a `problem`.
        if bytes(json_as(_Kind, text, "request").problem):
            other = json_as(OtherRequestDocument, text, "request")
            _refuse_format(other.format)
            control = {
                name: value
                for name in ("step", "tolerance")
                if (value := getattr(other, name)) is not msgspec.UNSET
            }
            return cls(
                problem=OTHERS[type(other.problem)](other.problem),
                method=other.method,
                **control,
            )
        document = json_as(RequestDocument, text, "request")
        _refuse_format(document.format)
        problem = Motion(Scene.of_document(document.scene, file), np.array(document.times))
        request = cls(
            problem=problem,
            method=document.method,
            step=document.step,
            tolerance=document.tolerance,
            threads=document.threads or 1,
            sensitivities=tuple(document.sensitivities or ()),
        )
        if document.stride is not None and document.stride != request._stated_stride:
            raise UsageError(
                f"request: stride is {document.stride}; expected {request._stated_stride}, as step"
                " and times say"
            )
        return request

    def to_json(self) -> bytes:
        """The content of `request.json`; equal requests give the same bytes."""
        return encoded(self.document())

    @property
    def bodies_file(self) -> bytes | None:
        """The content of `bodies.npz`, for a motion with too many bodies to be listed in the JSON;
        else None.
        """
        has_one = isinstance(self.problem, Motion) and self.problem.scene.has_bodies_file
        if has_one:
            return bodies_file.packed(self.problem.scene.bodies)
        return None

    def packed(self) -> bytes:
        """The request for another process: its JSON, or for more than FEW bodies the MessagePack of
        JSON and `bodies.npz`.
        """
        text = encoded(self.document(FEW))
        if not isinstance(self.problem, Motion) or len(self.problem.scene.bodies) <= FEW:
            return text
        return msgspec.msgpack.encode((text, bodies_file.packed(self.problem.scene.bodies)))

    @classmethod
    def unpacked(cls, data: bytes) -> "Request":
        """The request that `packed` wrote."""
        if data.startswith(b"{"):
            return cls.from_json(data)
        text, file = msgspec.msgpack.decode(data, type=tuple[bytes, bytes])
        return cls.from_json(text, file)

    @property
    def signed_step(self) -> float:
        """The step [s] with the direction of time."""
        return float(np.copysign(self.step or 0.0, self.problem.interval))

    @property
    def stride(self) -> int:
        """Number of steps from each sample to the next: sample interval / step.

        Raises UsageError if the method has no step, or if one stride does not fit every interval.
        """
        if self.step is None:
            raise UsageError("stride: the method has no fixed step")
        quotient = abs(self.problem.interval) / self.step
        # Beyond 2^53 no program counts its steps, and the quotient of two doubles may be infinite.
        is_countable = quotient < 2.0**53
        if is_countable:
            stride = round(quotient)
        else:
            stride = 0
        if stride < 1 or abs(quotient - stride) > WHOLE * quotient:
            raise UsageError(
                f"step is {self.step} s; expected a whole fraction of the sample interval"
                f" {abs(self.problem.interval)} s"
            )
        self._refuse_uneven()
        return stride

    @property
    def _stated_stride(self) -> int | None:
        """The `stride` of the document: steps from each sample to the next, None for a method
        without a step.
        """
        if self.step is None:
            return None
        return self.stride

    def _refuse_uneven(self) -> None:
        """Raises UsageError unless the samples are evenly spaced: t_n = t_0 + n (t_1 - t_0)."""
        times = self.problem.times
        even = times[0] + np.arange(len(times)) * self.problem.interval
        deviation = np.abs(times - even)
        worst = int(np.argmax(deviation))
        # Each time t_n is rounded once, and t_0 + n (t_1 - t_0) contains n times the roundings of
        # t_0 and t_1:  |t_n - t_0 - n (t_1 - t_0)| <= 4 u T max|t| + UNEVEN h,  T samples.
        rounding = 4 * 2.0**-53 * len(times) * float(np.max(np.abs(times)))
        if deviation[worst] > UNEVEN * (self.step or 0.0) + rounding:
            raise UsageError(
                f"times[{worst}] is {times[worst]:.17g} s; expected {even[worst]:.17g} s: "
                "a method with a fixed step needs evenly spaced samples"
            )

    def document(self, most_listed: int = MOST_LISTED) -> RequestDocument | OtherRequestDocument:
        """The document of the request; if a motion has more bodies than `most_listed`, it refers to
        `bodies.npz` instead of listing them.
        """
        if not isinstance(self.problem, Motion):
            control = {
                name: value
                for name in ("step", "tolerance")
                if (value := getattr(self, name)) is not None
            }
            return OtherRequestDocument(
                method=self.method, problem=self.problem.document(), **control
            )
        threads: int | msgspec.UnsetType = msgspec.UNSET
        if self.threads > 1:
            threads = self.threads
        sensitivities: list[str] | msgspec.UnsetType = msgspec.UNSET
        if self.sensitivities:
            sensitivities = list(self.sensitivities)
        return RequestDocument(
            method=self.method,
            step=self.step,
            stride=self._stated_stride,
            tolerance=self.tolerance,
            times=self.problem.times.tolist(),
            scene=self.problem.scene.document(most_listed),
            threads=threads,
            sensitivities=sensitivities,
        )

    def key(self, *fingerprints: str) -> str:
        """The sha256 of the request, the number of its repetition, and the fingerprints of engine
        and kernels.
        """
        digest = hashlib.sha256(encoded(self.document(FEW)))
        for part in (str(self.repeat), *fingerprints):
            digest.update(b"\0" + part.encode())
        return digest.hexdigest()

    def with_scene(self, scene: Scene, times: Array | None = None) -> "Request":
        """The same request for another state, or other times."""
        if times is None:
            times = self.problem.times
        return replace(self, problem=Motion(scene, times))

    def refuse_misaligned(self, t: Array, round_off: float = 2.0**-53) -> None:
        """Raises EngineError unless the engine's times `t` (T,) [s] are the requested samples.

        They may differ by the round-off of its precision, `round_off`, and by that of a clock which
        adds up its steps: one rounding a step.
        """
        times = self.problem.times
        if t.shape != times.shape:
            raise EngineError(f"trajectory.t has {len(t)} samples; expected {len(times)}")
        if self.step is None:
            steps = 0
        else:
            steps = self.stride * (len(times) - 1)
        # |t - t_requested| <= max(1e-12, CLOCK_ROUNDINGS u, n 2^-53) max|t|, for n steps.
        relative = max(1e-12, CLOCK_ROUNDINGS * round_off, steps * 2.0**-53)
        largest_time = max(abs(times[0]), abs(times[-1]), abs(self.problem.interval))
        allowed = relative * largest_time
        lag = t - times
        worst: Any = np.argmax(np.abs(lag))
        if abs(lag[worst]) > allowed:
            hint = self.miscounted(float(lag[worst] - lag[0]))
            raise EngineError(
                f"trajectory.t[{worst}] is {t[worst]:.17g} s; expected {times[worst]:.17g} s, "
                f"the sample that was asked for{hint}"
            )

    def miscounted(self, lag: float) -> str:
        """The end of a sentence about a run whose clock is ahead by `lag` [s] of the sample.

        It states how many steps too many or too few the program took, if `lag` is a whole number of
        steps to within MISCOUNTED, and is empty otherwise.
        """
        if self.step is None:
            return ""
        # Positive where the program took too many steps, whatever the direction of time.
        quotient = lag / self.signed_step
        extra = round(quotient)
        if extra == 0 or abs(quotient - extra) > MISCOUNTED:
            return ""
        if abs(extra) == 1:
            steps = "1 step"
        else:
            steps = f"{abs(extra)} steps"
        if extra > 0:
            excess = "too many"
        else:
            excess = "too few"
        return f"; the program took {steps} {excess} on the way: {COUNT}"
