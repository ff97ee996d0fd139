"""A bench from cases and engines to a record.

It reads no stored run; truth, which no engine touches, may be kept.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import msgspec

import refdem
from refdem.bench import precision
from refdem.bench.beside import Beside
from refdem.bench.entrant import Entrant
from refdem.bench.interleaving import Place
from refdem.bench.levels import levels
from refdem.bench.measurement import Measured, interleaved, refined
from refdem.bench.memory import peaks
from refdem.bench.peers import peers
from refdem.bench.record import TARGETS, BenchRecord, Curve, Growth
from refdem.bench.stability import stability_limit
from refdem.core.case import Instance
from refdem.core.engine import Engine, Method
from refdem.core.truth import SampledTruth
from refdem.errors import RefdemError, UsageError
from refdem.execution import worker
from refdem.planning import plan
from refdem.planning.kept_truth import kept_truth
from refdem.planning.specification import Entry, Specification


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
    progress: Callable[[str], None] = lambda line: None
    beside: Path | None = None

    def record(self) -> BenchRecord:
        """The record of all measurements; raises UsageError if no method can run any case."""
        specification = Specification(
            name="bench", case=self.cases, engines=self.engines, method=self.method
        )
        engines, _ = plan.engines(specification)
        # The methods of each instance, and of all instances in one list.
        by_instance = [self._of(instance, engines) for instance, _ in plan.instances(specification)]
        everything = list(chain.from_iterable(by_instance))
        if not any(measured.errors for measured in everything):
            reasons = dict.fromkeys(measured.refusal for measured in everything)
            raise UsageError("nothing could be run: " + "; ".join(reasons))
        yardstick = self._timed(everything)
        # The quantities that are compared, by instance.
        compared = {}
        for methods in by_instance:
            if methods:
                label = methods[0].entrant.instance.label
                compared[label] = sorted(_common(methods))
        curves = []
        for measured in everything:
            quantities = set(compared[measured.entrant.instance.label])
            curves.append(self._curve(measured, quantities))
        return BenchRecord(
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
        measured_methods = []
        for engine in engines:
            wanted = engine.chosen_methods(self.method)
            measured_methods += self._entered(instance, engine, wanted, is_peer=False)
        for peer in self._peers():
            measured_methods += self._entered(instance, peer, peer.methods, is_peer=True)
        able = [measured for measured in measured_methods if not measured.refusal]
        refused = [measured for measured in measured_methods if measured.refusal]
        truth = sampled_truth(instance, [measured.entrant for measured in able])
        known = [refined(measured.entrant, truth, longest=self.longest) for measured in able]
        return [*known, *refused]

    def _entered(
        self, instance: Instance, engine: Engine, methods: Sequence[Method], *, is_peer: bool
    ) -> list[Measured]:
        """The methods of an engine that answer problems of this kind, with the levels they run
        at, or why they do not run.
        """
        # Refusals of a peer or of the reference are left out of the tables.
        is_silent = is_peer or engine.is_reference
        entrants = []
        for method in methods:
            if method.answers != instance.problem.kind:
                continue
            refusal = engine.unsupported(instance.problem, method) or ""
            if refusal and is_silent:
                continue
            chosen: tuple[float, ...] = ()
            if not refusal:
                chosen = levels(instance, method, most_steps=self.most_steps)
            if not refusal and not chosen:
                refusal = f"more than {self.most_steps:g} steps"
            entrant = Entrant(instance, engine, method, chosen, is_peer)
            entrants.append(Measured(entrant, refusal=refusal))
        return entrants

    def _timed(self, everything: list[Measured]) -> list[float]:
        """Runs all rounds, alone or in turns with another installation; returns the seconds of a
        fixed piece of work (the yardstick) in each round.
        """

        def report(round_done: int) -> None:
            self.progress(f"round {round_done} of {self.rounds}")

        if self.beside is None:
            return interleaved(everything, self.rounds, report)
        places: list[Place] = []
        for measured in everything:
            places += [place(measured, level) for level in measured.errors]
        with Beside(self.beside) as other:
            other.begin(places)

            def seconds_beside(number: int) -> float | None:
                if other.reasons[number]:
                    return None
                return other.seconds(number)

            return interleaved(everything, self.rounds, report, seconds_beside)

    def _peers(self) -> list[Engine]:
        """The engines that only the bench knows, if they are to run."""
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
        # Only a method with steps claims an order.
        claimed = 0
        order_seen = None
        if method.control == "step":
            claimed = method.order_for(instance.problem.features)
        if claimed:
            order_seen = precision.order(points)
        scales = instance.scales
        constant = precision.constant(
            points, claimed=claimed, tau=scales.tau, duration=scales.duration
        )
        limit: float | None = None
        limited = ""
        if self.with_stability:
            limit, limited = stability_limit(entrant)
        return msgspec.structs.replace(
            bare,
            points=points,
            reached=[precision.reach(points, target) for target in TARGETS],
            compiled=measured.compiled,
            order_claimed=claimed,
            order_seen=order_seen,
            constant_seen=constant,
            limit=limit,
            limited=limited,
            growth=self._growth(measured),
        )

    def _growth(self, measured: Measured) -> list[Growth]:
        """Time against steps, and against the requested parameter at the finest level."""
        entrant = measured.entrant
        level = next(reversed(measured.errors))
        curves = []
        steps = []
        seconds = []
        for h, cost in measured.first.items():
            if cost.steps:
                steps.append(cost.steps)
                seconds.append(precision.seconds_of(measured.rounds[h]))
        if entrant.method.control == "step" and len(steps) > 1:
            curves.append(precision.growth("steps", steps, seconds))
        for name, values in self.grow.items():
            sizes = []
            times = []
            for value in values:
                time = self._seconds_grown(entrant, level, {name: value})
                if time is not None:
                    sizes.append(float(value))
                    times.append(time)
            if sizes:
                curves.append(precision.growth(name, sizes, times))
        return curves

    def _seconds_grown(
        self, entrant: Entrant, level: float, changed: Mapping[str, str]
    ) -> float | None:
        """Seconds of a run with a parameter changed, at the same level; None if it cannot run."""
        given = dict(entrant.instance.p.given)
        grown = entrant.instance.case.at(**(given | dict(changed)))
        if entrant.engine.unsupported(grown.problem, entrant.method) is not None:
            return None
        other = Entrant(grown, entrant.engine, entrant.method, (level,), entrant.is_peer)
        try:
            _, first = other.run(level)
        except RefdemError:
            # The finest step of one size need not fit the samples of another.
            return None
        measured = Measured(other, errors={level: {}}, first={level: first}, rounds={level: []})
        interleaved([measured], self.rounds)
        return precision.seconds_of(measured.rounds[level])

    def _with_memory(self, measured: list[Measured], curves: list[Curve]) -> list[Curve]:
        """The curves with the peak memory of their finest runs."""
        if not self.with_memory:
            return curves
        # Measured methods and curves have the same numbers.
        numbers = [k for k, one in enumerate(measured) if one.errors]
        jobs = []
        for k in numbers:
            entrant = measured[k].entrant
            levels_run = list(measured[k].errors)
            coarsest = entrant.request(levels_run[0])
            finest = entrant.request(levels_run[-1])
            jobs.append((entrant.engine.address, entrant.is_peer, coarsest, finest))
        for k, peak in zip(numbers, peaks(jobs), strict=True):
            curves[k] = msgspec.structs.replace(curves[k], memory=peak)
        return curves


def place(measured: Measured, level: float) -> Place:
    """One level of a method as it is sent to another installation."""
    entrant = measured.entrant
    request = msgspec.Raw(entrant.request(level).to_json())
    return Place(entrant.engine.address, entrant.is_peer, request, measured.first[level].seconds)


def sampled_truth(instance: Instance, entrants: list[Entrant]) -> SampledTruth:
    """The certified samples; raises UsageError if there are none to measure errors against."""
    delays: set[float] = set()
    for entrant in entrants:
        delays |= {entrant.method.delay(level) for level in entrant.levels}
    # A method without delay needs no additional samples.
    delays.discard(0.0)
    truth = None
    if not delays:
        truth = kept_truth(instance)
    if truth is None:
        given = dict(instance.p.given)
        packed = worker.sampled_truth(instance.case.id, given, tuple(sorted(delays)))
        truth = msgspec.msgpack.decode(packed, type=SampledTruth)
    if truth.until < min(2, len(instance.times)):
        raise UsageError(
            f"{instance.label} has no certified truth to measure errors against: {truth.reason}"
        )
    return truth


def _common(measured: list[Measured]) -> set[str]:
    """Names of the quantities that every run of an instance has errors of; if there are none, of
    those that any run has.
    """
    names_by_run: list[set[str]] = []
    for method in measured:
        names_by_run += [set(errors) for errors in method.errors.values()]
    if not names_by_run:
        return set()
    return set.intersection(*names_by_run) or set.union(*names_by_run)
