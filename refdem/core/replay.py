"""A replay: the frames of a motion that a page shows, for truth and for one run of each method.

Numbers are rounded to the resolution of a screen, 16 bits of the largest one of a grid. A run is
stored as its difference from truth, so that small errors have as many digits as large ones.
"""

import base64

import msgspec
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

STEPS = 32767
"""Steps of a grid from 0 to its scale, the largest number of 16 bits with a sign."""


class Grid(msgspec.Struct, frozen=True, kw_only=True):
    """Numbers (F, C) as multiples of scale/32767, 16 bits each in base64, little end first.

    Only columns with a number other than 0 are stored, one after the other; `columns` are their
    indices.
    """

    scale: float
    columns: tuple[int, ...]
    data: str

    @classmethod
    def of(cls, values: Array) -> "Grid":
        """The grid of an array (F, C) of finite numbers."""
        scale = float(np.max(np.abs(values), initial=0.0))
        if scale == 0:
            return cls(scale=0.0, columns=(), data="")
        steps = np.rint(values / scale * STEPS).astype("<i2")
        columns = np.flatnonzero(np.any(steps != 0, axis=0))
        data = np.ascontiguousarray(steps[:, columns].T).tobytes()
        return cls(
            scale=scale,
            columns=tuple(columns.tolist()),
            data=base64.b64encode(data).decode("ascii"),
        )

    def values(self, frames: int, count: int) -> Array:
        """The array (frames, count) that the grid stands for."""
        found = np.zeros((frames, count))
        steps = np.frombuffer(base64.b64decode(self.data), dtype="<i2")
        columns = steps.reshape(len(self.columns), frames)
        found[:, list(self.columns)] = columns.T * (self.scale / STEPS)
        return found


class DrawnBody(msgspec.Struct, frozen=True, kw_only=True):
    """A body at its start: a ball of `radius` [m], a convex body with `vertices` [m] in body axes,
    or a point if it has neither; a point that has an inertia is drawn as the box that has it.
    """

    position: Vector
    attitude: tuple[float, float, float, float]
    radius: float = 0.0
    vertices: tuple[Vector, ...] = ()
    faces: tuple[tuple[int, ...], ...] = ()
    is_inertia: bool = False


class DrawnLink(msgspec.Struct, frozen=True, kw_only=True):
    """A line from body `a` to body `b`, or to the world (-1); anchors [m] in their axes."""

    kind: str
    a: int
    b: int
    anchor_a: Vector
    anchor_b: Vector


class DrawnPlane(msgspec.Struct, frozen=True, kw_only=True):
    """A plane through `point` [m]."""

    point: Vector
    normal: Vector


class Track(msgspec.Struct, frozen=True, kw_only=True):
    """One run: its places less those of truth (F, 3 N) [m], and the rotation vectors (F, 3 N) [rad]
    from truth's attitudes to its own, in space axes.

    `largest` and `largest_turn` are the largest lengths of these over all samples, `contacts` the
    (frame, body) of each contact that the run reports; `level` is its step [s] or tolerance.
    """

    engine: str
    method: str
    control: str
    level: float
    place: Grid
    turn: Grid
    largest: float
    largest_turn: float
    contacts: tuple[tuple[int, int], ...] = ()


class Replay(msgspec.Struct, frozen=True, kw_only=True, tag="replay", tag_field="type"):
    """The replay of an instance: F frames of N bodies of truth, and a track for each method.

    `place` (F, 3 N) [m] and `turn` (F, 4 N) are the differences of the true positions and attitudes
    (w, x, y, z) from those at the start. Coordinates that a case compares, listed in `certified`,
    are those of truth. The others are those of the reference's method `anchor`, whose compared
    quantities all differ from truth by at most `anchor_error` of their scales. The rows of `view`
    are the unit vectors right, up and towards the reader.
    """

    label: str
    t: tuple[float, ...]
    bodies: tuple[DrawnBody, ...]
    links: tuple[DrawnLink, ...]
    planes: tuple[DrawnPlane, ...]
    touches: bool
    view: tuple[Vector, Vector, Vector]
    place: Grid
    turn: Grid
    certified: tuple[str, ...]
    anchor: str
    anchor_error: float
    contacts: tuple[tuple[int, int], ...]
    tracks: tuple[Track, ...]
