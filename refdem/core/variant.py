"""The closed list of ways in which a run is varied so that a check can judge it."""

from dataclasses import dataclass
from typing import Literal

Change = Literal[
    "none",
    "repeated",
    "threads",
    "differentiated",
    "reversed",
    "backward",
    "perturbed",
    "denser_output",
    "shifted",
    "rotated",
    "boosted",
    "mirrored",
    "relabelled",
    "rescaled",
    "delayed",
]


@dataclass(frozen=True, order=True)
class Variant:
    """A refinement level (step [s] or tolerance; 0 for exact methods) and at most one change of it.

    The changes are:

    - repeated: the same request again;
    - threads: the same request on `amount` threads;
    - differentiated: the same request with derivatives;
    - reversed: a run from the end of the plain run with velocities of opposite sign;
    - backward: a run from the end of the plain run with negative steps;
    - perturbed: the start moved by `amount` units in the last place;
    - denser_output: `amount` times as many samples.

    The others are symmetries (core/symmetry.py).
    """

    level: float
    change: Change = "none"
    amount: int = 0

    @property
    def base(self) -> "Variant":
        """The plain run of the same level, from whose end some variants start."""
        return Variant(self.level)

    @property
    def goes_on(self) -> bool:
        """True if the run starts from the end of the plain run of its level."""
        return self.change in ("reversed", "backward")

    def __str__(self) -> str:
        """The level, the change and its amount: "0.01 perturbed(64)"."""
        if self.level:
            level = f"{self.level:.17g}"
        else:
            level = "exact"
        if self.change == "none":
            return level
        if not self.amount:
            return f"{level} {self.change}"
        return f"{level} {self.change}({self.amount})"
