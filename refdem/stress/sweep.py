"""Sweep: one scene that is made harder point by point. Battery: the sweeps that answer one
question.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from refdem.core import discovery
from refdem.core.case import Canonical
from refdem.errors import UsageError
from refdem.stress.measures.measure import Measure

ELASTIC_SPHERES = "two-spheres[angle=1/2]"
"""An oblique impact without a dashpot, which all engines can run."""
DAMPED_SPHERES = "two-spheres[damping=1]"
"""A head-on impact with a dashpot."""
SIX_DECADES = ("1", "1e1", "1e2", "1e4", "1e6")
"""Points of a number that grows from 1 to a million."""
TWELVE_DECADES = (*SIX_DECADES, "1e9", "1e12")
"""Points of a number that grows from 1 to a million million; binary64 resolves 1 part in 1e16."""


def scene_words(case: str) -> str:
    """The scene of a sweep in words: the id of its case, or what its parameters make of it."""
    if case == ELASTIC_SPHERES:
        return "elastic spheres"
    return case.partition("[")[0]


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """Points from benign to extreme, each an exact number as text.

    - `along` says in words what the number is, with its unit.
    - `case` is an id of the catalogue, with parameters as in `pendulum[theta0=2]`, or a scene of
      stress/scenes.
    - `measure` builds the scene of a point and judges it.
    - `promised` is the last point that the reference must hold, for the reason `basis`; without
      them the sweep only informs.
    - `exempt` maps a method to a lower promise with its reason.
    - `is_general`: the sweep can be put on any motion.
    - `costly`: points run one after another, as long as the forecast for the next is within the
      budget.
    """

    name: str
    case: str | Canonical
    along: str
    points: tuple[str, ...]
    measure: Measure
    promised: str = ""
    basis: str = ""
    exempt: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    is_general: bool = False
    costly: bool = False

    def __post_init__(self) -> None:
        if bool(self.promised) != bool(self.basis) or (
            self.promised and self.promised not in self.points
        ):
            raise UsageError(
                f"sweep {self.name}: promised is {self.promised!r}; expected one of its points,"
                " with a basis"
            )

    @property
    def values(self) -> tuple[Fraction, ...]:
        """The points as exact numbers."""
        return tuple(Fraction(point) for point in self.points)

    def promise(self, method: str) -> tuple[str, str]:
        """The last point that a method must hold, and the reason; two empty strings without a
        promise.
        """
        return self.exempt.get(method, (self.promised, self.basis))

    def canonical(self) -> tuple[Canonical, dict[str, str]]:
        """The case, and its parameters as text; raises UsageError for a selection of cases."""
        from refdem.core.parameters import labelled
        from refdem.core.selection import Selection

        if isinstance(self.case, Canonical):
            return self.case, {}
        name, parameters = labelled(self.case)
        case = discovery.case(name)
        if isinstance(case, Selection):
            raise UsageError(f"case {name} is a selection of others; name one of these")
        return case, parameters


@dataclass(frozen=True, kw_only=True)
class Battery:
    """Sweeps that answer one question; a new one is a file in stress/batteries with an instance
    named BATTERY.
    """

    id: str
    title: str
    question: str
    sweeps: tuple[Sweep, ...] = field(default_factory=tuple)
