"""Maps that an iteration applies again and again, described by their numbers and without code.

An engine implements the map by its name (`kind`) and reads its numbers from the request.
"""

from typing import ClassVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.errors import UsageError

Array = NDArray[np.float64]


class Map(msgspec.Struct, frozen=True, kw_only=True, tag_field="map", forbid_unknown_fields=True):
    """A map of `dimension` numbers into themselves."""

    dimension: ClassVar[int] = 1

    @property
    def kind(self) -> str:
        """The name of the map in JSON documents."""
        return str(self.__struct_config__.tag)

    def admitted(self, start: Array) -> Array:
        """The start (D,) itself, or the nearest that the map can take."""
        return start


class Logistic(Map, frozen=True, kw_only=True, tag="logistic"):
    """x -> eta x (1 - x) on [0, 1], 0 <= eta <= 4."""

    eta: float

    def admitted(self, start: Array) -> Array:
        """The start if it is inside [0, 1]; UsageError if not."""
        return np.clip(start, 0.0, 1.0)


class LogisticFlow(Logistic, frozen=True, kw_only=True, tag="logistic_flow"):
    """The state of x' = eta x (1 - x) one unit of time later."""


class LorenzFlow(Map, frozen=True, kw_only=True, tag="lorenz_flow"):
    """The state (x, y, z) of x' = sigma (y - x), y' = x (rho - z) - y, z' = x y - beta z after a
    time `interval`.
    """

    dimension: ClassVar[int] = 3
    sigma: float
    rho: float
    beta: float
    interval: float

    def __post_init__(self) -> None:
        """Raises UsageError for a time that is not finite or not > 0."""
        if not 0 < self.interval < np.inf:
            raise UsageError(f"interval is {self.interval}; expected a finite time > 0")


class Billiard(Map, frozen=True, kw_only=True):
    """A point that flies straight at constant speed and is reflected by the wall: (x, y, direction
    x, y) from bounce to bounce.

    The table is centred on the origin, `width` [m] along x and `height` [m] along y. Iterate 0 is
    the start inside it, with a unit direction; iterate n has the place [m] of bounce n and the
    direction after it.
    """

    dimension: ClassVar[int] = 4
    width: float
    height: float

    def __post_init__(self) -> None:
        """Raises UsageError for a table without finite sizes > 0."""
        if not (0 < self.width < np.inf and 0 < self.height < np.inf):
            raise UsageError(
                f"billiard table of {self.width} m by {self.height} m; expected finite sizes > 0"
            )

    def admitted(self, start: Array) -> Array:
        """The start (x, y, u, v) with (u, v) divided by its length."""
        return np.concatenate((start[:2], start[2:] / np.hypot(*start[2:])))


class RectangleBilliard(Billiard, frozen=True, kw_only=True, tag="billiard_rectangle"):
    """A billiard table with four straight walls."""


class StadiumBilliard(Billiard, frozen=True, kw_only=True, tag="billiard_stadium"):
    """Half circles of diameter `height` at both ends of two straight walls; width >= height."""

    def __post_init__(self) -> None:
        """Raises UsageError also for a stadium that is wider than long."""
        super().__post_init__()
        if self.width < self.height:
            raise UsageError(
                f"stadium of {self.width} m by {self.height} m; expected a width of at least the"
                " height"
            )


AnyMap = Logistic | LogisticFlow | LorenzFlow | RectangleBilliard | StadiumBilliard
"""Every map there is; a new one is added here."""
