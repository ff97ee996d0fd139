"""A bench from cases and engines to a record.

It reads no stored run; truth, which no engine touches, may be kept.
"""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

import refdem
from refdem.bench import precision
from refdem.bench.beside import Beside
from refdem.bench.entrant import Entrant
from refdem.bench.levels import levels
from refdem.bench.measurement import Measured, interleaved, refined
from refdem.bench.memory import peaks
from refdem.bench.peers import peers
from refdem.bench.record import TARGETS, Curve, Growth, Record
from refdem.bench.stability import stability_limit
from refdem.bench.turns import Place
from refdem.campaign import plan, worker
from refdem.campaign.kept_truth import kept_truth
from refdem.campaign.specification import Entry, Specification
from refdem.core.case import Instance
from refdem.core.engine import Engine
from refdem.core.truth import SampledTruth
from refdem.errors import RefdemError, UsageError


@dataclass
class Bench:
    """What to run: `rounds` of everything, no run longer than `longest` [s] or of more than
    `most_steps` steps.

    `grow` names a parameter of the cases and its values: the time at the finest level is measured
    at each. `beside` is the Python of another installation, which runs everything in turns with
    this one.
    """

    cases: list[Entry]
    engines: list[str] = field(default_factory=list)
    method: str = ""
    rounds: int = 5
    most_steps: float = 1e6
    longest: float = 0.3
    with_peers: bool = True
    with_memory: bool = True
    with_stability: bool = True
    grow: Mapping[str, list[str]] = field(default_factory=dict)
    progress: Callable[[str], None] = lambda told: None
    beside: Path | None = None

    def record(self) -> Record:
        """Everything measured; raises UsageError if no method can run any of the cases."""
        specification = Specification(
            name="bench", case=self.cases, engines=self.engines, method=self.method
        )
        engines, _ = plan.engines(specification)
        measured = [self._of(instance, engines) for instance, _ in plan.instances(specification)]
        if not any(entrant.errors for found in measured for entrant in found):
            reasons = dict.fromkeys(entrant.refusal for found in measured for entrant in found)
            raise UsageError("nothing could be run: " + "; ".join(reasons))
        everything = [entrant for found in measured for entrant in found]
        yardstick = self._timed(everything)
        compared = {
            found[0].entrant.instance.label: sorted(_common(found)) for found in measured if found
        }
        curves = [
            self._curve(entrant, set(compared[entrant.entrant.instance.label]))
            for entrant in everything
        ]
        return Record(
            refdem=refdem.__version__,
            rounds=self.rounds,
            load=round(os.getloadavg()[0], 1),
            longest=self.longest,
            most_steps=self.most_steps,
            yardstick=yardstick,
            compared=compared,
            curves=self._with_memory(everything, curves),
        )

    def _of(self, instance: Instance, engines: list[Engine]) -> list[Measured]:
        """Every method refined on one instance; refusals stay, but for the reference's methods and
        peers made for other scenes.
        """
        self.progress(f"{instance.label}: refining")
        found = []
        for engine, is_peer in [(e, False) for e in engines] + [(p, True) for p in self._peers()]:
            silent = is_peer or engine.is_reference
            for method in engine.methods:
                if (
                    self.method and not is_peer and method.name != self.method
                ) or method.answers != instance.problem.kind:
                    continue
                refusal = engine.refuses(instance.problem, method) or ""
                chosen: tuple[float, ...] = ()
                if not refusal:
                    chosen = levels(instance, method, most_steps=self.most_steps)
                if refusal and silent:
                    continue
                entrant = Entrant(instance, engine, method, chosen, is_peer)
                found.append(
                    Measured(
                        entrant,
                        refusal=refusal
                        or ("" if chosen else f"more than {self.most_steps:g} steps"),
                    )
                )
        able = [measured for measured in found if not measured.refusal]
        truth = sampled_truth(instance, [measured.entrant for measured in able])
        refused = [measured for measured in found if measured.refusal]
        return [
            *(refined(measured.entrant, truth, longest=self.longest) for measured in able),
            *refused,
        ]

    def _timed(self, everything: list[Measured]) -> list[float]:
        """All rounds, alone or in turns; the yardstick of each."""

        def told(done: int) -> None:
            self.progress(f"round {done} of {self.rounds}")

        if self.beside is None:
            return interleaved(everything, self.rounds, told)
        with Beside(self.beside) as other:
            other.begin(
                [place(measured, level) for measured in everything for level in measured.errors]
            )
            return interleaved(
                everything,
                self.rounds,
                told,
                lambda k: None if other.reasons[k] else other.seconds(k),
            )

    def _peers(self) -> list[Engine]:
        if self.with_peers:
            return peers()
        return []

    def _curve(self, measured: Measured, names: set[str]) -> Curve:
        """The curve of an entrant, with all that follows from its points."""
        entrant = measured.entrant
        instance = entrant.instance
        method = entrant.method
        bare = Curve(
            label=instance.label,
            engine=entrant.engine.name,
            method=method.name,
            control=method.control,
            refusal=measured.refusal,
            is_reference=entrant.engine.is_reference,
            is_peer=entrant.is_peer,
        )
        points = measured.points(names)
        if not points:
            return bare
        if method.control == "step":
            claimed = method.order_for(instance.problem.features)
        else:
            claimed = 0
        scales = instance.scales
        constant = precision.constant(
            points, claimed=claimed, tau=scales.tau, duration=scales.duration
        )
        limit, limited = stability_limit(entrant) if self.with_stability else (None, "")
        return msgspec.structs.replace(
            bare,
            points=points,
            reached=[precision.reach(points, target) for target in TARGETS],
            compiled=measured.compiled,
            order_claimed=claimed,
            order_seen=precision.order(points) if claimed else None,
            constant_seen=constant,
            limit=limit,
            limited=limited,
            growth=self._growth(measured),
        )

    def _growth(self, measured: Measured) -> list[Growth]:
        """Time against steps, and against the parameter asked for at the finest level."""
        entrant = measured.entrant
        level = next(reversed(measured.errors))
        counted = [
            (cost.steps, precision.seconds_of(measured.rounds[h]))
            for h, cost in measured.first.items()
            if cost.steps
        ]
        stepped = entrant.method.control == "step" and len(counted) > 1
        if stepped:
            found = [precision.growth("steps", *zip(*counted, strict=True))]
        else:
            found = []
        for name, values in self.grow.items():
            sizes = []
            times = []
            for value in values:
                grown = entrant.instance.case.at(**(dict(entrant.instance.p.given) | {name: value}))
                if entrant.engine.refuses(grown.problem, entrant.method) is None:
                    one = Measured(
                        Entrant(grown, entrant.engine, entrant.method, (level,), entrant.is_peer)
                    )
                    try:
                        one.errors, one.first = {level: {}}, {level: one.entrant.run(level)[1]}
                    except RefdemError:
                        continue  # the finest step of one size need not fit the samples of another
                    one.rounds = {level: []}
                    interleaved([one], self.rounds)
                    sizes.append(float(value))
                    times.append(precision.seconds_of(one.rounds[level]))
            if sizes:
                found.append(precision.growth(name, sizes, times))
        return found

    def _with_memory(self, measured: list[Measured], curves: list[Curve]) -> list[Curve]:
        """The curves with the peak memory of their finest runs."""
        if self.with_memory:
            places = [k for k, found in enumerate(measured) if found.errors]
        else:
            places = []
        asked = []
        for k in places:
            entrant = measured[k].entrant
            run = list(measured[k].errors)
            asked.append(
                (
                    entrant.engine.address,
                    entrant.is_peer,
                    entrant.request(run[0]),
                    entrant.request(run[-1]),
                )
            )
        for k, peak in zip(places, peaks(asked), strict=True):
            curves[k] = msgspec.structs.replace(curves[k], memory=peak)
        return curves


def place(measured: Measured, level: float) -> Place:
    """One level as another installation is told of it."""
    entrant = measured.entrant
    request = msgspec.Raw(entrant.request(level).to_json())
    return Place(entrant.engine.address, entrant.is_peer, request, measured.first[level].seconds)


def sampled_truth(instance: Instance, entrants: list[Entrant]) -> SampledTruth:
    """The certified samples; raises UsageError if there are none to measure errors against."""
    delays = tuple(
        sorted({delay for e in entrants for level in e.levels if (delay := e.method.delay(level))})
    )
    if delays:
        truth = None
    else:
        truth = kept_truth(instance)
    if truth is None:
        truth = msgspec.msgpack.decode(
            worker.sampled_truth(instance.case.id, dict(instance.p.given), delays),
            type=SampledTruth,
        )
    if truth.until < min(2, len(instance.times)):
        raise UsageError(
            f"{instance.label} has no certified truth to measure errors against: {truth.reason}"
        )
    return truth


def _common(found: list[Measured]) -> set[str]:
    """Names of the quantities that every run of an instance shows; all that any shows if there are
    none.
    """
    shown = [set(errors) for measured in found for errors in measured.errors.values()]
    if shown:
        return set.intersection(*shown) or set.union(*shown)
    return set()
