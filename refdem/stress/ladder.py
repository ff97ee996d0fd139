"""A ladder: one scene that is made harder rung by rung; a battery: the ladders that ask one
question.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from refdem.core import discovery
from refdem.core.case import Canonical
from refdem.errors import UsageError
from refdem.stress.measures.measure import Measure


@dataclass(frozen=True, kw_only=True)
class Ladder:
    """Rungs from benign to extreme, each an exact number as text; `along` says what it is a number
    of, with its unit.

    `case` is an id of the catalogue, with parameters as in `pendulum[theta0=2]`, or a scene of
    stress/scenes. The reference promises every rung up to `promised` for the reason `basis`;
    without these a ladder only informs. `is_general`: it can be put on any motion.
    `exempt` has, by method, a nearer rung and the reason why no more is promised of it. A `costly`
    one is climbed rung by rung, while the time forecast for the next is within the budget.
    """

    name: str
    case: str | Canonical
    along: str
    rungs: tuple[str, ...]
    measure: Measure
    promised: str = ""
    basis: str = ""
    exempt: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    is_general: bool = False
    costly: bool = False

    def __post_init__(self) -> None:
        if bool(self.promised) != bool(self.basis) or (
            self.promised and self.promised not in self.rungs
        ):
            raise UsageError(
                f"ladder {self.name}: promised is {self.promised!r}; expected one of its rungs,"
                " with a basis"
            )

    @property
    def values(self) -> tuple[Fraction, ...]:
        """The rungs as exact numbers."""
        return tuple(Fraction(rung) for rung in self.rungs)

    def promise(self, method: str) -> tuple[str, str]:
        """The last rung that is promised of a method, and why; empty if nothing is."""
        return self.exempt.get(method, (self.promised, self.basis))

    def canonical(self) -> tuple[Canonical, dict[str, str]]:
        """The case, and its parameters as text."""
        from refdem.core.parameters import labelled
        from refdem.core.selection import Selection

        if isinstance(self.case, Canonical):
            return self.case, {}
        name, given = labelled(self.case)
        found = discovery.case(name)
        if isinstance(found, Selection):
            raise UsageError(f"case {name} is a selection of others; name one of these")
        return found, given


@dataclass(frozen=True, kw_only=True)
class Battery:
    """Ladders that ask one question; adding one is one file in stress/batteries with an instance
    named BATTERY.
    """

    id: str
    title: str
    question: str
    ladders: tuple[Ladder, ...] = field(default_factory=tuple)
