"""Predicted resolution: the smallest relative misreading of a number that the checks against truth
would detect, from certified derivatives instead of runs with a misread number.

Theorem: a number p misread by a factor 1 + a displaces every quantity q of a run by

    dq(t) = a p dq/dp(t) + O(a^2),

so that the error of an otherwise exact run exceeds a bound b for a > b/(|dq/dp| |p|). The smallest
such threshold, over samples, quantities and checks, is the resolution.

Hypotheses, and where each is checked:

* the derivatives exist. They do not where the kind of motion changes at the parameter.
  `sensitivities_at` encloses them, and `missing` lists those that do not exist;
* a run is displaced as the true motion is, to first order. This holds for a converging run and
  small a: `SMALL`.

Errors of the run itself are included: the runs that were judged are displaced by a p dq/dp and
judged again. Laws that are judged by states and not by quantities (energy, momentum, lengths of
rods) are not displaced, so that the predicted resolution may be coarser.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import msgspec
import numpy as np

from refdem.core import discovery
from refdem.core.case import Array, Instance
from refdem.core.engine import Engine
from refdem.core.parameters import labelled
from refdem.core.problem import Request
from refdem.core.resolution import NumberResolution, Resolution
from refdem.core.run import Run
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.errors import NotCertifiedError, RefdemError
from refdem.faults import numbers as scene_numbers
from refdem.planning import plan
from refdem.planning.deviations import of_engine
from refdem.planning.in_process import record_of, truth_of
from refdem.planning.plan import Task
from refdem.planning.resolution import FIRST, LEAST, Trial, checks_of_plain_runs, threshold
from refdem.planning.specification import Specification
from refdem.truth.sensitivities import Number, at_times, numbers_of, sensitivities_at

DIGITS = 17
"""Decimal places of the derivatives."""
SAMPLES = 65
"""Samples at which derivatives are taken, spread over the run."""
SMALL = 1e-2
"""The largest misreading for which terms of second and higher order are neglected."""
PROBES = (1.0 + 2.0**-20, 1.0 - 2.0**-20)
"""Factors by which numbers of a case are multiplied to find the numbers of the scene that follow
from them. The second is used where the first gives an invalid scene, such as a restitution above 1.
"""
ALIKE = 1e-9
"""Relative difference up to which numbers of two scenes count as equal: far below the change by a
factor, and far above rounding.
"""
STILL = 1e-12
"""Displacement in scales, for a misreading by 100 %, up to which a number has no effect."""
NO_DERIVATIVE = "there is no derivative by it: the motion is of another kind on one side"
NOT_OF_THE_CASE = "it is no number of the case, nor a vector of it"
NOT_SMALL = f"no misreading of {100 * SMALL:g} % or less is noticed"


@dataclass(frozen=True, eq=False)
class Displaced(Instance):
    """An instance whose observed quantities are displaced by `by` (T,), each in its unit."""

    by: Mapping[str, Array]

    def observe(self, trajectory: Trajectory) -> dict[str, Array]:
        """Every quantity that the trajectory shows, each (T,), displaced."""
        quantities = super().observe(trajectory)
        return {
            name: values + self.by[name][: len(values)] if name in self.by else values
            for name, values in quantities.items()
        }


def beside(specification: Specification, found: Resolution) -> Resolution:
    """The measured resolution of a method on a case, with the predicted one of each number."""
    instance = discovery.case(labelled(found.label)[0]).at(**labelled(found.label)[1])
    narrow = specification.of_one(instance, found.method)
    engine = discovery.engine(found.engine)
    try:
        of_numbers = predicted(narrow, engine, instance, truth_of(instance))
    except NotCertifiedError as error:
        of_numbers = tuple(
            NumberResolution(number=one.number, reason=str(error)) for one in found.numbers
        )
    by_name = {one.number: one for one in of_numbers}
    numbers = []
    for entry in found.numbers:
        computed = by_name.get(entry.number)
        if computed is not None:
            entry = msgspec.structs.replace(
                entry, computed=computed.smallest, computed_by=computed.by or computed.reason
            )
        numbers.append(entry)
    return msgspec.structs.replace(found, numbers=tuple(numbers))


def predicted(
    specification: Specification, engine: Engine, instance: Instance, truth: SampledTruth
) -> tuple[NumberResolution, ...]:
    """The predicted resolution of the specified method for each number of the scene.

    Raises NotCertifiedError where derivatives are not certified.
    """
    (task,) = plan.tasks(specification, instance, (), engine, truth, truth.reason)
    narrow = msgspec.structs.replace(specification, checks=checks_of_plain_runs(task))
    (task,) = plan.tasks(narrow, instance, (), engine, truth, truth.reason)
    runs: dict[Variant, Run] = {}
    sound = record_of(task, runs, of_engine(engine))
    listed = list(scene_numbers.numbers(instance.scene))
    if any(finding.outcome in ("fail", "error") for finding in sound.findings):
        why = "a finding fails without any misreading"
        return tuple(NumberResolution(number=number.name, reason=why) for number in listed)
    verdicts = Verdicts(task, runs)
    slopes = Slopes.of(instance, truth)
    return tuple(_predicted_for(verdicts, slopes, number) for number in listed)


def _predicted_for(
    verdicts: "Verdicts", slopes: "Slopes", number: scene_numbers.Number
) -> NumberResolution:
    """The predicted resolution for one number of the scene."""
    instance = verdicts.task.subject.instance
    directions = numbers_behind(instance, number)
    if not directions:
        return NumberResolution(number=number.name, reason=NOT_OF_THE_CASE)
    if any(one.name in slopes.missing for one in directions):
        return NumberResolution(number=number.name, reason=NO_DERIVATIVE)
    by = slopes.along(directions)
    scales = instance.quantities
    if all(np.max(np.abs(change)) <= STILL * scales[name].scale for name, change in by.items()):
        return NumberResolution(number=number.name, reason="no quantity depends on it")
    found = threshold(lambda amount: verdicts.displaced(by, amount), verdicts.displaced(by, FIRST))
    if found.detected is None or found.detected > SMALL:
        return NumberResolution(number=number.name, reason=NOT_SMALL)
    return NumberResolution(number=number.name, smallest=max(found.detected, LEAST), by=found.by)


@dataclass(frozen=True)
class Verdicts:
    """The runs of a task, which are judged with displaced quantities."""

    task: Task
    runs: dict[Variant, Run]
    """All runs so far; checks may request finer levels after they have seen displaced runs."""

    def displaced(self, by: Mapping[str, Array], amount: float) -> Trial:
        """The findings of the runs whose quantities are displaced by `amount` times `by`."""
        subject = self.task.subject
        change = {name: amount * values for name, values in by.items()}
        moved = Displaced(subject.instance.case, subject.instance.p, change)
        task = replace(self.task, subject=replace(subject, instance=moved))
        record = record_of(task, self.runs, of_engine(task.engine))
        return Trial(record.findings)


@dataclass(frozen=True)
class Slopes:
    """The logarithmic derivatives p dq/dp of every quantity q by every number p of a case, at each
    sample (T,).

    They are 0 at samples at which they were not computed. `missing` are the numbers without a
    derivative.
    """

    by_number: Mapping[str, Mapping[str, Array]]
    missing: frozenset[str]

    @classmethod
    def of(cls, instance: Instance, truth: SampledTruth) -> "Slopes":
        """The derivatives at SAMPLES samples, up to the last time at which truth is certified."""
        make = instance.case.truth
        p = instance.case.written_out(instance.p)
        numbers = list(numbers_of(p))
        spread = np.linspace(0, truth.until - 1, min(SAMPLES, truth.until))
        samples = np.unique(spread.astype(int))
        times = [Fraction(float(instance.times[sample])) for sample in samples]
        # The derivatives at the last time are enclosed to find the numbers that have none.
        (at_last,) = sensitivities_at(make, p, times[-1:], DIGITS)
        missing = frozenset(at_last.missing)
        found = at_times(make, p, numbers, times, DIGITS)
        by_number: dict[str, dict[str, Array]] = {}
        for place, number in enumerate(numbers):
            value = float(number.of(p))
            of_quantity = {}
            for name in instance.quantities:
                change = np.zeros(len(instance.times))
                if all(name in one for one in found):
                    change[samples] = [value * float(one[name][place]) for one in found]
                of_quantity[name] = change
            by_number[number.name] = of_quantity
        return cls(by_number, missing)

    def along(self, numbers: Sequence[Number]) -> dict[str, Array]:
        """dq/da of every quantity where all these numbers are multiplied by 1 + a: the sum of
        p dq/dp.
        """
        first, *others = (self.by_number[number.name] for number in numbers)
        summed = dict(first)
        for other in others:
            summed = {name: change + other[name] for name, change in summed.items()}
        return summed


def numbers_behind(instance: Instance, number: scene_numbers.Number) -> list[Number]:
    """The number of the case, or all numbers of one vector of it, whose misreading has the same
    effect on the scene as that of a number of the scene; empty if there is none.
    """
    p = instance.case.written_out(instance.p)
    own = list(numbers_of(p))
    vectors: dict[str, list[Number]] = {}
    for one in own:
        vectors.setdefault(one.parameter, []).append(one)
    candidates = [[one] for one in own if one.of(p)]
    candidates += [vector for vector in vectors.values() if len(vector) > 1]
    request = Request(problem=instance.problem, method="", step=instance.problem.interval)
    for factor in PROBES:
        try:
            misread = _numbers_in(number.misread(request, factor).problem.document())
        except RefdemError:
            continue
        for candidate in candidates:
            scene = _scene_at(instance, candidate, factor)
            is_alike = len(scene) == len(misread)
            if is_alike and np.allclose(scene, misread, rtol=ALIKE, atol=0.0):
                return candidate
    return []


def _scene_at(instance: Instance, numbers: Sequence[Number], factor: float) -> list[float]:
    """The numbers in the scene of the case with some of its numbers multiplied by a factor; none
    where the case has no such scene.
    """
    moved = instance.case.written_out(instance.p)
    for one in numbers:
        moved = one.set_in(moved, one.of(moved) * Fraction(factor))
    try:
        return _numbers_in(instance.case.problem(moved).document())
    except (RefdemError, ValueError, ArithmeticError):
        return []


def _numbers_in(document: Any) -> list[float]:
    """All numbers of a document, in its order."""
    plain = msgspec.to_builtins(document, enc_hook=lambda value: value.item())
    found: list[float] = []
    pending = [plain]
    while pending:
        part = pending.pop()
        if isinstance(part, dict):
            pending += part.values()
        elif isinstance(part, list | tuple):
            pending += part
        elif isinstance(part, int | float):
            found.append(float(part))
    return found
