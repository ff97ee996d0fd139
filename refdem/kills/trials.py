"""Faults against checks: every known fault is planted in an engine, and the quantity named for it
must fail (a *kill*); a finding that blames the engine without a fault is a false *alarm*.

A *setting* (faults/settings.py) is a case with parameters that are drawn from a seed.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import product

import msgspec

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.engine import Engine
from refdem.core.finding import Finding, Record
from refdem.core.run import Run
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.execution.schedule import Progress, counted
from refdem.execution.worker import no_truth
from refdem.faults.catalogue import faults
from refdem.faults.fault import Fault
from refdem.faults.settings import SETTINGS
from refdem.faults.transparent import Transparent
from refdem.planning.in_process import record_of, task_of, truth_of

WRONG = ("fail", "error")
FEWEST = 3
"""Refinement levels that an order needs. For a fault that shows without an order, trials start with
one level.
"""
ORDERS = ("order", "convergence", "limit")
WITHHELD = no_truth("truth is withheld")
"""The truth of settings that are judged as if nothing could be certified."""


class Kill(msgspec.Struct, frozen=True, kw_only=True):
    """The outcome of one fault on one setting at one seed.

    `killed` says that the quantity named for the fault failed, `beyond` by how many decades;
    `also` are the checks and quantities that failed besides.
    """

    fault: str
    kind: str
    setting: str
    seed: int
    label: str
    check: str
    quantity: str
    killed: bool
    beyond: float | None
    sentence: str
    also: tuple[str, ...] = ()


class Alarm(msgspec.Struct, frozen=True, kw_only=True):
    """A finding that blames the correct engine: a false alarm."""

    id: str
    setting: str
    seed: int
    sentence: str


class Matrix(msgspec.Struct, frozen=True, kw_only=True):
    """The kills of all planted faults, and all alarms.

    `near` is the smallest margin of the correct engine, in decades, by check.
    """

    engine: str
    seeds: int
    kills: tuple[Kill, ...]
    alarms: tuple[Alarm, ...]
    near: dict[str, float] = {}

    def survivors(self) -> list[Kill]:
        """The faults that some seed did not show."""
        return [kill for kill in self.kills if not kill.killed]

    def idle(self) -> list[str]:
        """The checks that saw no fault at all."""
        killing: set[str] = set()
        for kill in self.kills:
            if kill.killed:
                killing |= {name.split("/")[0] for name in (*kill.also, kill.check)}
        return [name for name in discovery.names("checks") if name not in killing]


@cache
def instance_at(setting: str, seed: int) -> Instance:
    """The instance that a seed draws in a setting; nothing is proved of it."""
    drawn = SETTINGS[setting]
    return discovery.case(drawn.case).at(**drawn.parameters(setting, seed))


@cache
def setting_at(setting: str, seed: int) -> tuple[Instance, SampledTruth]:
    """The instance that a seed draws in a setting, and its truth, proved once in a process."""
    instance = instance_at(setting, seed)
    if SETTINGS[setting].proved:
        truth = truth_of(instance)
    else:
        truth = WITHHELD
    return instance, truth


def engine_of(setting: str) -> Engine:
    """The engine without any fault that runs a setting: the transparent one unless another is
    named.
    """
    name = SETTINGS[setting].engine
    if name:
        return discovery.engine(name)
    return Transparent()


@dataclass(frozen=True)
class FaultTrial:
    """The trial of an engine: all of its faults against all checks at `seeds` seeds from `first`
    on; `matrix` and `kill` return what comes of it.

    `engine` None is the transparent engine of refdem/faults; `chosen` faults, or all. `whole`
    judges by all checks at seed 0, to fill `also`.
    """

    engine: Engine | None = None
    seeds: int = 20
    first: int = 0
    chosen: tuple[Fault, ...] = ()
    whole: bool = True
    progress: Progress = lambda stage, done, total: None

    @property
    def drawn(self) -> range:
        """The seeds of the parameter sets that are drawn."""
        return range(self.first, self.first + self.seeds)

    @cached_property
    def faults(self) -> tuple[Fault, ...]:
        """The faults that the engine can carry."""
        every = self.chosen or faults()
        if self.engine is None:
            return every
        return tuple(fault for fault in every if fault.inside is None)

    def matrix(self) -> Matrix:
        """The kills of every fault at every seed, and the alarms of the engine without a fault."""
        kills = []
        alarms = []
        near = dict[str, float]()
        work = list(product(self.drawn, self.faults))
        for seed, fault in counted(work, "faults", len(work), self.progress):
            kills.append(self.kill(fault, seed))
        for record, setting, seed in self._sound():
            for finding in record.findings:
                if finding.outcome in WRONG:
                    name = record.id(finding)
                    alarms.append(
                        Alarm(id=name, setting=setting, seed=seed, sentence=finding.sentence)
                    )
                if finding.margin is not None:
                    near[finding.check] = min(near.get(finding.check, 99.0), finding.margin)
        if self.engine:
            name = self.engine.name
        else:
            name = Transparent.name
        return Matrix(
            engine=name, seeds=self.seeds, kills=tuple(kills), alarms=tuple(alarms), near=near
        )

    def kill(self, fault: Fault, seed: int) -> Kill:
        """The outcome of one fault at one seed; the settings of a fault take turns with the
        seed.
        """
        setting = fault.on[seed % len(fault.on)]
        record = self._spoiled(fault, setting, seed)
        check, quantity = fault.sees
        named = _named(fault, record)
        if named:
            sentence = named[0].sentence
        else:
            sentence = "the quantity was not judged"
        wrong = [f"{f.check}/{f.quantity}" for f in record.findings if f.outcome in WRONG]
        return Kill(
            fault=fault.name,
            kind=fault.kind,
            setting=setting,
            seed=seed,
            label=record.label,
            check=check,
            quantity=quantity,
            killed=_killed(named),
            beyond=_beyond(named),
            sentence=sentence,
            also=tuple(wrong),
        )

    def _spoiled(self, fault: Fault, setting: str, seed: int) -> Record:
        """The record of an engine with the fault, refined no further than is needed to kill it."""
        instance, truth = self.instance(setting, seed)
        checks: tuple[str, ...] = ()
        if not self.whole or seed != 0:
            checks = _needed(fault)
        engine = fault.carrier(self.engine or engine_of(setting))
        # Runs of fewer levels are used again with more of them.
        known_runs = dict[Variant, Run]()
        # An order needs some levels; other checks may see a fault at the first.
        if not checks or checks[0] in ORDERS:
            fewest = FEWEST
        else:
            fewest = 1
        for levels in range(fewest, fault.levels + 1):
            record = self._record(engine, fault.method, instance, truth, levels, checks, known_runs)
            if _killed(_named(fault, record)):
                break
        return record

    def _record(
        self,
        engine: Engine,
        method: str,
        instance: Instance,
        truth: SampledTruth,
        levels: int,
        checks: Iterable[str],
        known: dict[Variant, Run] | None = None,
    ) -> Record:
        """The record at so many refinement levels, judged by these checks, or by all if empty.

        An engine that the caller brought runs its first method that does not refuse, in place of
        the transparent engine's `method`.
        """
        if self.engine is not None:
            supporting = (
                m.name for m in engine.methods if engine.unsupported(instance.problem, m) is None
            )
            method = next(supporting, engine.methods[0].name)
        return record_of(task_of(engine, method, instance, truth, levels, checks), known)

    def _sound(self) -> Iterator[tuple[Record, str, int]]:
        """Record, setting and seed of the engine without any fault, on every setting that a fault
        uses.
        """
        settings: dict[str, None] = {}
        for fault in self.faults:
            settings |= dict.fromkeys(fault.on)
        work = list(product(self.drawn, settings))
        for seed, setting in counted(work, "sound engine", len(work), self.progress):
            instance, truth = self.instance(setting, seed)
            engine = self.engine or engine_of(setting)
            method = self._method(setting, seed)
            yield self._record(engine, method, instance, truth, FEWEST, ()), setting, seed

    def _method(self, setting: str, seed: int) -> str:
        """The method at a seed of the engine of a setting; the methods of a setting take turns.

        Empty for an engine that the caller brought, whose method `_record` chooses.
        """
        if self.engine is not None:
            return ""
        methods = SETTINGS[setting].methods
        return methods[seed % len(methods)]

    def instance(self, setting: str, seed: int) -> tuple[Instance, SampledTruth]:
        """The instance of a setting at a seed, and its truth."""
        return setting_at(setting, seed)


def _named(fault: Fault, record: Record) -> list[Finding]:
    """The findings on the quantity named for the fault, which must fail."""
    return [f for f in record.findings if (f.check, f.quantity) == fault.sees]


def _killed(named: list[Finding]) -> bool:
    """True if one of the findings is a failure or an error."""
    return any(f.outcome in WRONG for f in named)


def _needed(fault: Fault) -> tuple[str, ...]:
    """The one check that must see the fault; the cheapest where only a broken contract is to be
    seen.
    """
    check, _ = fault.sees
    if check == "run":
        check = "error"
    return (check,)


def _beyond(named: list[Finding]) -> float | None:
    """Decades by which the named quantity is out of bounds (negative: inside)."""
    margins = [-f.margin for f in named if f.margin is not None]
    return max(margins, default=None)


def by_check(kills: Iterable[Kill]) -> Mapping[str, int]:
    """Number of faults that each check saw, whether or not it is named for them."""
    counts: dict[str, int] = {}
    for kill in kills:
        for check in {name.split("/")[0] for name in kill.also}:
            counts[check] = counts.get(check, 0) + 1
    return counts
