"""The first stage of a campaign: which methods run which instances, and, once the truths are
known, the union of the runs that applicable checks need.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from refdem.campaign.specification import Specification
from refdem.core import discovery, refinement, symmetry
from refdem.core.case import Instance
from refdem.core.check import Check, Subject
from refdem.core.engine import Engine, Method
from refdem.core.parameters import nearest
from refdem.core.problem import Motion, Request
from refdem.core.selection import Selection
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.errors import EngineMissingError, UsageError


@dataclass(frozen=True, eq=False)
class Task:
    """One method of one engine on one instance: what its checks judge, those that apply, and why
    others do not.
    """

    engine: Engine
    subject: Subject
    unsupported: str | None
    checks: tuple[Check, ...] = ()
    left_out: Mapping[str, str] = field(default_factory=dict)
    is_selection: bool = False
    """Only some checks were asked for, so that they may honestly have nothing to decide here."""

    @property
    def method(self) -> Method:
        """The method that runs the instance."""
        return self.subject.method

    @cached_property
    def variants(self) -> tuple[Variant, ...]:
        """The union of what the checks need, without repetition, bases before what goes on from
        them.
        """
        wanted: dict[Variant, None] = {}
        for check in self.checks:
            wanted |= dict.fromkeys(check.needs(self.subject))
        bases = [variant.base for variant in wanted if variant.goes_on]
        return tuple(dict.fromkeys([*bases, *wanted]))


Supported = tuple[Subject, str | None]
"""What is judged of a method, and why the engine does not support it, if it does not."""


@dataclass(frozen=True, eq=False)
class Row:
    """One instance of a campaign, the only checks to run on it (none: all), and what is judged in
    every engine.
    """

    instance: Instance
    only: tuple[str, ...]
    subjects: tuple[tuple[Engine, list[Supported]], ...]

    @property
    def is_judged(self) -> bool:
        """Some method of some engine supports it."""
        reasons = [reason for _, asked in self.subjects for _, reason in asked]
        return None in reasons

    @property
    def delays(self) -> tuple[float, ...]:
        """The times [s] by which velocities of some method lag at one of its levels."""
        delays: set[float] = set()
        for _, asked in self.subjects:
            for subject, _ in asked:
                if subject.method.velocity_time != "synchronous":
                    levels = refinement.order_levels(self.instance, subject.levels)
                    delays |= {subject.method.delay(level) for level in levels}
        # Samples that are late by nothing are those of every run.
        delays.discard(0.0)
        return tuple(sorted(delays))


def rows(specification: Specification, engines: list[Engine]) -> list[Row]:
    """All that a campaign asks, before any truth is known."""
    found = []
    for instance, only in instances(specification):
        asked = [(engine, subjects(specification, instance, engine)) for engine in engines]
        found.append(Row(instance, only, tuple(asked)))
    return found


def instances(specification: Specification) -> list[tuple[Instance, tuple[str, ...]]]:
    """The instances asked for, each with the only checks to run (none: all); a selection stands for
    all that it admits.
    """
    found: list[tuple[Instance, tuple[str, ...]]] = []
    for entry in specification.case:
        case = discovery.case(entry.id)
        if isinstance(case, Selection):
            found += [(instance, (case.check,)) for instance in _admitted(case)]
        else:
            found.append((case.at(**entry.set), ()))
    whole = {instance.label for instance, only in found if not only}
    return [(instance, only) for instance, only in found if not only or instance.label not in whole]


def _admitted(selection: Selection) -> list[Instance]:
    """Every case, at the parameters that the selection asks for, that it admits."""
    judges = discovery.check(selection.check).judges
    found: dict[str, Instance] = {}
    for case in map(discovery.case, discovery.names("cases")):
        if isinstance(case, Selection):
            continue
        for given in selection.parameters(case):
            instance = case.at(**given)
            if isinstance(instance.problem, judges) and selection.admits(instance) is None:
                found[instance.label] = instance
    return list(found.values())


def engines(specification: Specification) -> tuple[list[Engine], dict[str, str]]:
    """The engines to run, and why others are missing; raises EngineMissingError for one that was
    asked for by name.
    """
    asked = specification.engines
    found = []
    missing = {}
    for name in asked or discovery.names("engines"):
        engine = discovery.engine(name)
        reason = engine.missing()
        if reason is None:
            found.append(engine)
        elif asked:
            raise EngineMissingError(f"engine {name} is not installed here; {reason}")
        else:
            missing[name] = reason
    wanted = specification.method
    if not wanted or asked:
        return found, missing
    having = []
    every: set[str] = set()
    for engine in found:
        own = {method.name for method in engine.methods}
        every |= own
        if wanted in own:
            having.append(engine)
    if not having:
        raise UsageError(f"no engine has a method {wanted!r}; {nearest(wanted, every)}")
    return having, missing


def subjects(specification: Specification, instance: Instance, engine: Engine) -> list[Supported]:
    """What is judged of each method, with the reason where the engine does not support the scene;
    raises UsageError for a method that it does not have.

    Methods for other kinds of questions are left out; an engine that has none for this kind refuses
    by its first.
    """
    methods = list(engine.methods)
    if specification.method:
        methods = [engine.method(specification.method)]
    answering = [method for method in methods if method.answers == instance.problem.kind]
    found = []
    for method in answering or methods[:1]:
        unsupported = engine.unsupported(instance.problem, method)
        levels: tuple[float, ...] = ()
        if unsupported is None:
            levels = refinement.levels(
                instance,
                method,
                specification.levels,
                specification.most_steps,
                first_step(specification, instance),
            )
            if not levels:
                turns = instance.scales.duration / instance.scales.tau
                unsupported = (
                    f"the run needs more than {specification.most_steps:g} steps for"
                    f" {turns:.3g} times the shortest time tau; shorten the duration"
                )
        refuses = partial(_unsupported, engine, method)
        found.append((Subject(instance, method, levels, None, unsupported=refuses), unsupported))
    return found


def _unsupported(engine: Engine, method: Method, motion: Motion) -> str | None:
    return engine.unsupported(motion, method)


def first_step(specification: Specification, instance: Instance) -> float | None:
    """The first level [s] that the caller asked for, if any."""
    if specification.step is not None:
        if not 0 < specification.step < float("inf"):
            raise UsageError(
                f"step is {specification.step}; expected a finite number of seconds > 0"
            )
        return specification.step
    if specification.steps_per_tau is not None:
        if not 0 < specification.steps_per_tau < float("inf"):
            raise UsageError(
                f"steps-per-tau is {specification.steps_per_tau}; expected a finite number > 0"
            )
        return instance.scales.tau / specification.steps_per_tau
    return None


def tasks(
    specification: Specification,
    instance: Instance,
    only: tuple[str, ...],
    engine: Engine,
    truth: SampledTruth | None,
    reason: str = "",
) -> list[Task]:
    """One task a method: its subject with truth, and the checks that apply."""
    asked = subjects(specification, instance, engine)
    return _tasks(specification, instance, only, engine, asked, truth, reason)


def _tasks(
    specification: Specification,
    instance: Instance,
    only: tuple[str, ...],
    engine: Engine,
    asked: list[Supported],
    truth: SampledTruth | None,
    reason: str,
) -> list[Task]:
    """One task for each subject of an engine."""
    excluded = instance.case.exclude_for(instance.p)
    names = discovery.names("checks")
    if only:
        names = [name for name in names if name in only]
    if specification.checks:
        names = [name for name in names if name in specification.checks]
    found = []
    for bare, unsupported in asked:
        subject = replace(bare, truth=truth, truth_reason=reason)
        chosen = []
        left_out = {}
        applied = names
        if unsupported is not None:
            applied = []
        for name in applied:
            check = discovery.check(name)
            why = excluded.get(name) or check.left_out(subject)
            if why is None:
                chosen.append(check)
            else:
                left_out[name] = why
        # The one check of a selection may leave a method out.
        if chosen or unsupported is not None or not only:
            is_selection = bool(only or specification.checks)
            found.append(Task(engine, subject, unsupported, tuple(chosen), left_out, is_selection))
    return found


def tasks_of(
    specification: Specification, rows: list[Row], truths: list[SampledTruth]
) -> list[Task]:
    """The tasks of all rows whose truths are known by now, as far as they go into a report."""
    found: list[Task] = []
    for row, truth in zip(rows, truths, strict=True):
        for engine, asked in row.subjects:
            reason = truth.reason
            planned = _tasks(specification, row.instance, row.only, engine, asked, truth, reason)
            found += judged(planned)
    return found


def judged(tasks: list[Task]) -> list[Task]:
    """The tasks of one engine that go into a report: the reference has a method for each kind of
    scene, so that those which refuse this one say nothing, unless all do."""
    able = [task for task in tasks if task.unsupported is None or not task.engine.is_reference]
    return able or tasks[:1]


def request(
    task: Task, variant: Variant, base: Trajectory | None = None, *, ulps: int = 0
) -> Request:
    """The request of a variant.

    `base` is the trajectory on whose end it goes on; `ulps` moves every start.
    """
    problem = task.subject.instance.problem
    if ulps:
        problem = problem.perturbed(ulps)
    control: dict[str, Any] = {}
    if task.method.control != "exact":
        control[task.method.control] = variant.level
    plain = Request(problem=problem, method=task.method.name, **control)
    if variant.change == "none":
        return plain
    if variant.change == "repeated":
        return replace(plain, repeat=1)
    if variant.change == "perturbed":
        return replace(plain, problem=problem.perturbed(variant.amount))
    if not isinstance(problem, Motion):
        raise UsageError(f"variant {variant}: {problem.words} does not have this variant")
    return _of_motion(task, plain, problem, variant, base)


def _of_motion(
    task: Task, plain: Request, problem: Motion, variant: Variant, base: Trajectory | None
) -> Request:
    """The request of a variant that only a motion has."""
    if variant.change == "denser_output":
        count = variant.amount * (len(problem.times) - 1)
        interval = problem.interval / variant.amount
        denser = np.arange(count + 1, dtype=np.float64) * interval
        return plain.with_scene(problem.scene, denser)
    if variant.change in symmetry.NAMES:
        shown, motion = symmetry.picture(task.subject.instance, variant.change)
        if plain.step is None:
            step = None
        else:
            step = plain.step * shown.units[2]
        if problem is not task.subject.instance.problem:
            motion = shown.applied(problem)
        return replace(plain, problem=motion, step=step)
    if base is None:
        raise UsageError(f"variant {variant} continues a run that is not available")
    if variant.change == "reversed":
        sign = -1.0
    else:
        sign = 1.0
    end = base.end()
    length = np.linalg.norm(end["attitude"], axis=-1, keepdims=True)
    state = {
        **end,
        "velocity": sign * end["velocity"],
        "omega": sign * end["omega"],
        "attitude": end["attitude"] / length,
    }
    if variant.change == "reversed":
        times = problem.times
    else:
        times = problem.times[::-1]
    return plain.with_scene(problem.scene.with_state(**state), times)
