"""A figure as data: curves, points and clouds on axes, with a caption, the numbers seen in it, and
the commands that make it.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from refdem.errors import UsageError

Array = NDArray[np.float64]
GREY = -1
"""Ink of series that are neither data nor a claim; numbers of colours start at 0."""
FEWEST_DIGITS = 2
"""Significant digits of a number of which only the order of magnitude matters."""
ROUND_OFF = 1e-6
"""A smaller number is taken to be an error, of which only the order of magnitude matters."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Series:
    """One part of a picture: x, y (N,), nan where a curve breaks.

    `ink` numbers the report's colours, GREY is none of them. `label` is for the legend; series of
    one ink share a label, and those without one are not in it. An `area` is a closed outline, a
    `cloud` so many points that only their density is drawn, a `text` writes `words` (N,).
    """

    x: Array
    y: Array
    label: str = ""
    ink: int = 0
    mark: Literal["line", "points", "area", "cloud", "text"] = "line"
    dashed: bool = False
    width: float = 1.5
    words: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Raises UsageError unless x and y have one shape (N,), with as many words in a text."""
        if self.x.ndim != 1 or self.x.shape != self.y.shape or not len(self.x):
            raise UsageError(
                f"series {self.label!r}: x and y have shapes {self.x.shape} and {self.y.shape};"
                " expected (N,), N >= 1, twice"
            )
        if self.mark == "text" and len(self.words) != len(self.x):
            raise UsageError(
                f"series {self.label!r}: {len(self.words)} words for {len(self.x)} places"
            )


@dataclass(frozen=True, kw_only=True)
class Axis:
    """An axis of a panel: its title and its ends.

    `ends` are those of the data unless given, `is_hidden` leaves line, ticks and title out.
    """

    title: str = ""
    ends: tuple[float, float] | None = None
    is_log: bool = False
    is_hidden: bool = False


@dataclass(frozen=True, eq=False, kw_only=True)
class Panel:
    """A picture with its axes, `size` in pixels (width, height)."""

    series: tuple[Series, ...]
    x: Axis
    y: Axis
    title: str = ""
    size: tuple[int, int] = (460, 280)

    def ends(self, name: Literal["x", "y"]) -> tuple[float, float]:
        """The given ends of an axis, or those of all finite data with a margin of 4 %."""
        axis: Axis = getattr(self, name)
        if axis.ends is not None:
            return axis.ends
        values = np.concatenate([getattr(series, name) for series in self.series])
        low = float(np.nanmin(values))
        high = float(np.nanmax(values))
        if axis.is_log:
            return low / 1.2, high * 1.2
        margin = 0.04 * (high - low)
        if margin == 0:
            # All values are alike: the picture shows them in the middle of an axis of length 2.
            margin = 1.0
        return low - margin, high + margin


@dataclass(frozen=True, eq=False, kw_only=True)
class Figure:
    """A figure of the chapter (1.15), made anew, or of a benchmark (co-4): panels in `columns`.

    `numbers` are what was measured in it, by name, and `digits` how many significant digits of them
    decide something.
    `commands`: what makes it, then what shows the runs behind it one by one.
    """

    id: str
    title: str
    caption: str
    panels: tuple[Panel, ...]
    columns: int = 1
    numbers: dict[str, float] = field(default_factory=dict)
    digits: int = FEWEST_DIGITS
    commands: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The id of the figure in the form of a file name."""
        return file_name(self.id)

    def digits_of(self, number: str) -> int:
        """How many significant digits of a number are shown: `digits`, but fewest of an error."""
        is_error = "standard error" in number or "its error" in number
        if is_error or abs(self.numbers[number]) < ROUND_OFF:
            return FEWEST_DIGITS
        return self.digits


def file_name(id: str) -> str:
    """The id of a figure as it stands in file names: "1.15" becomes "fig-1-15"."""
    return "fig-" + id.replace(".", "-")
