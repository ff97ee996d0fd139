"""The first stage of a campaign: which methods run which instances, and, once the truths are
known, the union of the runs that applicable checks need.

A *row* is an instance with a *subject* for each method of each engine; with its truth and the
checks that apply, a subject becomes a *task*. A *variant* is one run of a task.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import msgspec
import numpy as np

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
from refdem.planning.certified_matrix import certified_matrix, requested_numbers
from refdem.planning.specification import Specification

ESCAPES = "the motion is infinite before"
"""Text in the reason of a truth whose motion escapes to infinity in finite time."""


@dataclass(frozen=True, eq=False)
class Task:
    """One method of one engine on one instance.

    `subject` is what its checks judge, `unsupported` the reason why the engine does not run it,
    `checks` are those that apply, `left_out` has the reason for each that does not.
    """

    engine: Engine
    subject: Subject
    unsupported: str | None
    checks: tuple[Check, ...] = ()
    left_out: Mapping[str, str] = field(default_factory=dict)
    is_selection: bool = False
    """True if only some checks were selected; then it is no error that none of them decides."""

    @property
    def method(self) -> Method:
        """The method that runs the instance."""
        return self.subject.method

    @cached_property
    def variants(self) -> tuple[Variant, ...]:
        """The union of the runs that the checks need at first; a run precedes those that continue
        from its end.
        """
        needed: dict[Variant, None] = {}
        for check in self.checks:
            needed |= dict.fromkeys(check.needs(self.subject))
        return in_order(needed)


def in_order(variants: Iterable[Variant]) -> tuple[Variant, ...]:
    """Variants without repetition; the plain runs from whose ends some continue come first."""
    requested = list(variants)
    bases = [variant.base for variant in requested if variant.goes_on]
    return tuple(dict.fromkeys([*bases, *requested]))


Supported = tuple[Subject, str | None]
"""A method on an instance, and the reason why the engine does not support that, or None."""


@dataclass(frozen=True, eq=False)
class Row:
    """One instance of a campaign, the only checks to run on it (none: all), and the subjects of
    every engine.
    """

    instance: Instance
    only: tuple[str, ...]
    subjects: tuple[tuple[Engine, list[Supported]], ...]

    @property
    def is_judged(self) -> bool:
        """True if some method of some engine supports the instance."""
        reasons = [reason for _, supported in self.subjects for _, reason in supported]
        return None in reasons

    @property
    def delays(self) -> tuple[float, ...]:
        """The delays [s] > 0 by which velocities of some method lag at one of its levels,
        sorted.
        """
        delays: set[float] = set()
        for _, supported in self.subjects:
            for subject, _ in supported:
                if subject.method.velocity_time != "synchronous":
                    levels = refinement.order_levels(self.instance, subject.method, subject.levels)
                    delays |= {subject.method.delay(level) for level in levels}
        # A delay of 0 is that of the samples themselves.
        delays.discard(0.0)
        return tuple(sorted(delays))


def rows(specification: Specification, engines: list[Engine]) -> list[Row]:
    """The rows of a campaign, before any truth is known."""
    planned = []
    for instance, only in instances(specification):
        of_engines = [(engine, subjects(specification, instance, engine)) for engine in engines]
        planned.append(Row(instance, only, tuple(of_engines)))
    return planned


def instances(specification: Specification) -> list[tuple[Instance, tuple[str, ...]]]:
    """The instances of a campaign, each with the only checks to run on it (none: all).

    A selection is replaced by all instances that it admits, with its one check. Instances that are
    already judged by all checks are not repeated.
    """
    requested: list[tuple[Instance, tuple[str, ...]]] = []
    for entry in specification.case:
        case = discovery.case(entry.id)
        if isinstance(case, Selection):
            requested += [(instance, (case.check,)) for instance in _admitted(case)]
        else:
            requested.append((case.at(**entry.set), ()))
    fully_judged = {instance.label for instance, only in requested if not only}
    return [
        (instance, only)
        for instance, only in requested
        if not only or instance.label not in fully_judged
    ]


def _admitted(selection: Selection) -> list[Instance]:
    """The instances that a selection admits, among all cases at the parameters that it names."""
    judged_kinds = discovery.check(selection.check).judges
    by_label: dict[str, Instance] = {}
    for case in map(discovery.case, discovery.names("cases")):
        if isinstance(case, Selection):
            continue
        for parameters in selection.parameters(case):
            try:
                instance = case.at(**parameters)
            except UsageError:
                # The case has no such settings; a motion that ends, for example, has no long run.
                continue
            if isinstance(instance.problem, judged_kinds) and selection.admits(instance) is None:
                by_label[instance.label] = instance
    return list(by_label.values())


def engines(specification: Specification) -> tuple[list[Engine], dict[str, str]]:
    """The engines to run, and for each other one the reason why it is missing.

    Raises EngineMissingError for a missing engine that was requested by name, and UsageError for a
    method that no engine has.
    """
    requested = specification.engines
    installed = []
    missing = {}
    for name in requested or discovery.names("engines"):
        engine = discovery.engine(name)
        reason = engine.missing()
        if reason is None:
            installed.append(engine)
        elif requested:
            raise EngineMissingError(f"engine {name} is not installed here; {reason}")
        else:
            missing[name] = reason
    if not specification.method or requested:
        return installed, missing
    return _with_method(installed, specification.method), missing


def present(specification: Specification) -> tuple[Specification, list[str]]:
    """The campaign without the engines that were requested by name and are not installed, and a
    sentence for each of these.

    Raises EngineMissingError where none of the requested engines is installed.
    """
    kept = []
    absent = []
    for name in specification.engines:
        reason = discovery.engine(name).missing()
        if reason is None:
            kept.append(name)
        else:
            absent.append(f"engine {name} is not installed here; {reason}")
    if absent and not kept:
        raise EngineMissingError(" ".join(absent))
    return msgspec.structs.replace(specification, engines=kept), absent


def _with_method(engines: list[Engine], method_name: str) -> list[Engine]:
    """The engines that have a method of that name; raises UsageError if none has."""
    chosen = []
    all_names: set[str] = set()
    for engine in engines:
        names = {method.name for method in engine.methods}
        all_names |= names
        if method_name in names:
            chosen.append(engine)
    if not chosen:
        hint = nearest(method_name, all_names)
        raise UsageError(f"no engine has a method {method_name!r}; {hint}")
    return chosen


def subjects(specification: Specification, instance: Instance, engine: Engine) -> list[Supported]:
    """A subject, still without truth, for each method of an engine on an instance, with the reason
    where it is not supported.

    Methods for other kinds of problems are omitted. If an engine has no method for this kind, the
    refusal of its first method is returned. Raises UsageError for a method that the engine does not
    have.
    """
    if specification.method:
        methods = [engine.method(specification.method)]
    else:
        methods = engine.chosen_methods(as_shipped=specification.as_shipped)
    answering = [method for method in methods if method.answers == instance.problem.kind]
    of_methods = []
    for method in answering or methods[:1]:
        unsupported = engine.unsupported(instance.problem, method)
        levels: tuple[float, ...] = ()
        if unsupported is None:
            levels = refinement.levels(
                instance,
                method,
                specification.levels_of(instance),
                specification.most_steps,
                first_step(specification, instance),
            )
            if not levels:
                duration_in_tau = instance.scales.duration / instance.scales.tau
                unsupported = (
                    f"the run needs more than {specification.most_steps:g} steps for"
                    f" {duration_in_tau:.3g} times the shortest time tau; shorten the duration"
                )
        refusal = partial(_unsupported, engine, method)
        subject = Subject(
            instance,
            method,
            levels,
            None,
            unsupported=refusal,
            derivatives=certified_matrix,
        )
        of_methods.append((subject, unsupported))
    return of_methods


def _unsupported(engine: Engine, method: Method, motion: Motion) -> str | None:
    """`Engine.unsupported` with the motion last, as `Subject.unsupported` needs it."""
    return engine.unsupported(motion, method)


def first_step(specification: Specification, instance: Instance) -> float | None:
    """The first level [s] that the caller requested, if any."""
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
    """One task for each method of an engine: its subject with truth, and the checks that apply.

    `only` are the checks to run (none: all), `reason` is the reason why there is no truth.
    """
    supported = subjects(specification, instance, engine)
    return _tasks(specification, instance, only, engine, supported, truth, reason)


def _tasks(
    specification: Specification,
    instance: Instance,
    only: tuple[str, ...],
    engine: Engine,
    supported: list[Supported],
    truth: SampledTruth | None,
    reason: str,
) -> list[Task]:
    """One task for each subject of an engine; see `tasks`."""
    excluded = instance.case.exclude_for(instance.p)
    names = discovery.names("checks")
    if only:
        names = [name for name in names if name in only]
    if specification.checks:
        names = [name for name in names if name in specification.checks]
    is_selection = bool(only or specification.checks)
    planned = []
    for without_truth, unsupported in supported:
        levels = without_truth.levels
        if truth is not None and first_step(specification, instance) is None:
            method = without_truth.method
            levels = refinement.past_impacts(
                instance, method, levels, truth, specification.most_steps
            )
        subject = replace(without_truth, levels=levels, truth=truth, truth_reason=reason)
        applicable = []
        left_out = {}
        candidates = names
        if unsupported is None and truth is not None and ESCAPES in truth.reason:
            # No later sample can be requested.
            unsupported = f"the motion does not last until its last sample ({truth.reason})"
        if unsupported is not None:
            candidates = []
        for name in candidates:
            check = discovery.check(name)
            why_not = excluded.get(name) or check.left_out(subject)
            if why_not is None:
                applicable.append(check)
            else:
                left_out[name] = why_not
        # The single check of a selection may not apply to a method.
        if applicable or unsupported is not None or not only:
            checks = tuple(applicable)
            planned.append(Task(engine, subject, unsupported, checks, left_out, is_selection))
    return planned


def tasks_of(
    specification: Specification, rows: list[Row], truths: list[SampledTruth]
) -> list[Task]:
    """The tasks of all rows with their truths, as far as they go into a report."""
    reported: list[Task] = []
    for row, truth in zip(rows, truths, strict=True):
        for engine, supported in row.subjects:
            planned = _tasks(
                specification, row.instance, row.only, engine, supported, truth, truth.reason
            )
            reported += judged(planned)
    return reported


def judged(tasks: list[Task]) -> list[Task]:
    """The tasks of one engine that go into a report.

    The reference has a method for each kind of scene, so that the refusals of its other methods are
    left out, unless all of them refuse.
    """
    supported = [task for task in tasks if task.unsupported is None or not task.engine.is_reference]
    return supported or tasks[:1]


def request(
    task: Task, variant: Variant, base: Trajectory | None = None, *, ulps: int = 0
) -> Request:
    """The request of a variant of a task.

    `base` is the trajectory from whose end the variant continues, if any. The start of every run is
    moved by `ulps` units in the last place.
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
    if variant.change == "threads":
        return replace(plain, threads=variant.amount)
    if variant.change == "differentiated":
        return replace(plain, sensitivities=requested_numbers(task.subject.instance, task.method))
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
        transformation, motion = symmetry.image(task.subject.instance, variant.change)
        if plain.step is None:
            step = None
        else:
            # In the units of time of the transformation.
            step = plain.step * transformation.units[2]
        is_moved = problem is not task.subject.instance.problem
        if is_moved:
            motion = transformation.applied(problem)
        return replace(plain, problem=motion, step=step)
    if base is None:
        raise UsageError(f"variant {variant} continues a run that is not available")
    if variant.change == "reversed":
        sign = -1.0
    else:
        sign = 1.0
    end = base.end()
    # A scene takes unit quaternions only.
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
