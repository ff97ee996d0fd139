"""The result of a run: states at times, events and channels, and the cost of computing them."""

from dataclasses import dataclass, field, replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.errors import EngineError

Array = NDArray[np.float64]

CHANNELS = {
    "rod_force": "N",
    "overlap": "m",
    "contact_force": "N",
    "dissipated_work": "J",
    "contacts": "1",
}
"""The closed list of channels and their units; each is (T,) or (T, number of elements that have
it).
"""


class Event(msgspec.Struct, frozen=True):
    """An event of a body at `time` [s]; `kind` is contact, release, stick, slip, stop (a stick that
    lasts for ever), catch or turn.
    """

    time: float
    kind: str
    body: int


class Cost(msgspec.Struct, frozen=True, kw_only=True):
    """Seconds in the engine's own loop, seconds of set-up, and number of steps (0 if none)."""

    seconds: float
    setup: float = 0.0
    steps: int = 0


@dataclass(frozen=True, eq=False, kw_only=True)
class Trajectory:
    """States of N bodies at T times: position, velocity (T, N, 3), attitude (T, N, 4), omega (T, N,
    3) in space axes.

    Attitude and omega of points are (1, 0, 0, 0) and 0. The answer to a problem without a scene has
    no bodies; it has arrays `values` (T, ...) by name at the requested samples t (T,).
    `derivatives`, by the keys of the numbers of the scene that were requested, are arrays
    (T, N, 13): the derivatives of position, velocity, attitude and omega by that number. Raises
    EngineError, with the name of the array, if a shape is wrong or a number is not finite.
    """

    t: Array
    position: Array
    velocity: Array
    attitude: Array
    omega: Array
    channels: dict[str, Array] = field(default_factory=dict)
    events: tuple[Event, ...] = ()
    values: dict[str, Array] = field(default_factory=dict)
    derivatives: dict[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Raises EngineError for a wrong shape, an unknown channel, or a number not finite."""
        if self.position.ndim != 3:
            raise EngineError(
                f"trajectory.position has shape {self.position.shape}; expected (T, N, 3)"
            )
        count = len(self.t)
        bodies = self.position.shape[1]
        shapes = {"t": (count,), "position": (count, bodies, 3), "velocity": (count, bodies, 3)}
        shapes |= {"attitude": (count, bodies, 4), "omega": (count, bodies, 3)}
        for name, shape in shapes.items():
            _refuse(name, getattr(self, name), shape)
        for name, values in self.channels.items():
            if name not in CHANNELS:
                raise EngineError(
                    f"trajectory.channels has {name!r}; expected one of {', '.join(CHANNELS)}"
                )
            _refuse(f"channels[{name}]", values, (count, *values.shape[1:]))
        for name, values in self.values.items():
            _refuse(f"values[{name}]", values, (count, *values.shape[1:]))
        for name, values in self.derivatives.items():
            _refuse(f"derivatives[{name}]", values, (count, bodies, 13))

    @classmethod
    def of_points(cls, t: Array, position: Array, velocity: Array, **more: Any) -> "Trajectory":
        """A trajectory of bodies that do not rotate: attitude (1, 0, 0, 0) and omega 0.

        `position` and `velocity` are (T, N, 3); `more` are channels, events or values.
        """
        count, bodies = position.shape[:2]
        attitude = np.zeros((count, bodies, 4))
        attitude[..., 0] = 1.0
        return cls(
            t=t,
            position=position,
            velocity=velocity,
            attitude=attitude,
            omega=np.zeros((count, bodies, 3)),
            **more,
        )

    @classmethod
    def of_values(cls, t: Array, values: dict[str, Array]) -> "Trajectory":
        """The answer to a question without a scene: arrays (T, ...) by name."""
        return replace(
            cls.of_points(t, np.zeros((len(t), 0, 3)), np.zeros((len(t), 0, 3))), values=values
        )

    def columns(self) -> dict[str, Array]:
        """All states and values by name."""
        return {name: getattr(self, name) for name in STATE} | self.values

    def end(self) -> dict[str, Array]:
        """The last state, column by column (N, ...)."""
        return {name: getattr(self, name)[-1] for name in STATE}

    def to_bytes(self) -> bytes:
        """MessagePack with raw float64 arrays; `from_bytes` reads it back to the last bit."""
        arrays = {name: _packed(getattr(self, name)) for name in ("t", *STATE)}
        channels = {name: _packed(values) for name, values in self.channels.items()}
        packed = {"arrays": arrays, "channels": channels, "events": self.events}
        if self.values:
            packed["values"] = {name: _packed(values) for name, values in self.values.items()}
        if self.derivatives:
            packed["derivatives"] = {name: _packed(of) for name, of in self.derivatives.items()}
        return msgspec.msgpack.encode(packed)

    @classmethod
    def from_bytes(cls, data: bytes | memoryview) -> "Trajectory":
        """The trajectory that `to_bytes` wrote."""
        packed = msgspec.msgpack.decode(data, type=_Packed)
        arrays = {name: _unpacked(*value) for name, value in packed.arrays.items()}
        channels = {name: _unpacked(*value) for name, value in packed.channels.items()}
        values = {name: _unpacked(*value) for name, value in packed.values.items()}
        derivatives = {name: _unpacked(*value) for name, value in packed.derivatives.items()}
        return cls(
            channels=channels,
            events=packed.events,
            values=values,
            derivatives=derivatives,
            **arrays,
        )


STATE = ("position", "velocity", "attitude", "omega")


class _Packed(msgspec.Struct):
    """The MessagePack form of a trajectory: each array as its shape and its bytes."""

    arrays: dict[str, tuple[list[int], bytes]]
    channels: dict[str, tuple[list[int], bytes]]
    events: tuple[Event, ...]
    values: dict[str, tuple[list[int], bytes]] = {}
    derivatives: dict[str, tuple[list[int], bytes]] = {}


def _packed(values: Array) -> tuple[list[int], bytes]:
    """Shape and bytes of an array; if all rows are one broadcast row, the bytes of that row only.

    Attitude and omega of bodies that do not rotate are such arrays.
    """
    rows = np.ascontiguousarray(different_rows(values), dtype="<f8")
    return list(values.shape), rows.tobytes()


def different_rows(values: Array) -> Array:
    """The rows of an array (T, ...); only the first (1, ...) if all are one broadcast row."""
    # NumPy gives a broadcast axis the stride 0.
    if values.ndim and values.strides[0] == 0:
        return values[:1]
    return values


def _unpacked(shape: list[int], data: bytes) -> Array:
    """The array that `_packed` wrote; a single row is broadcast to the shape."""
    numbers = np.frombuffer(data, dtype="<f8")
    if numbers.size == np.prod(shape):
        return numbers.reshape(shape)
    return np.broadcast_to(numbers.reshape(1, *shape[1:]), shape)


def _refuse(name: str, values: Array, shape: tuple[int, ...]) -> None:
    """Raises EngineError for a wrong shape or a number that is not finite."""
    if values.shape != shape or values.dtype != np.float64:
        raise EngineError(
            f"trajectory.{name} is {values.dtype} {values.shape}; expected float64 {shape}"
        )
    is_finite = np.isfinite(different_rows(values))
    if not is_finite.all():
        first = np.argwhere(~is_finite)[0]
        raise EngineError(
            f"trajectory.{name}{first.tolist()} is {values[tuple(first)]}; expected finite numbers"
        )
