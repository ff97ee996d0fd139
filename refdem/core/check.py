"""A check: decides itself where it applies, names the runs it needs, and judges them."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from refdem.core.case import Instance
from refdem.core.engine import Method
from refdem.core.finding import Finding
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant


@dataclass(frozen=True, eq=False)
class Trial:
    """All that judging needs: the instance, the method's claims, its levels (coarse to fine) and the truth, if certified."""

    instance: Instance
    method: Method
    levels: tuple[float, ...]
    truth: SampledTruth | None
    truth_reason: str = ""

    @property
    def finest(self) -> Variant:
        """The plain run of the finest level."""
        return Variant(self.levels[-1])

    @property
    def plain(self) -> tuple[Variant, ...]:
        """The plain run of every level."""
        return tuple(Variant(level) for level in self.levels)


@dataclass(frozen=True, eq=False)
class Outcome:
    """A run that worked, as a check sees it."""

    trajectory: Trajectory
    cost: Cost


class Check(ABC):
    """One verified property. Adding one is one file in checks/ with an instance of a subclass named CHECK."""

    name: ClassVar[str]
    title: ClassVar[str]
    kills: ClassVar[str]  # the fault that it catches, in a few words

    @abstractmethod
    def applies(self, trial: Trial) -> str | None:
        """None if it applies, else the reason why not."""

    @abstractmethod
    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The runs that `judge` will read."""

    @abstractmethod
    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """The findings, at least one."""
