"""refdem explain: what will run, what is left out because the scene does not need it, and who
refuses.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated

import typer

from refdem.cli import completion
from refdem.core.outside import one_line

if TYPE_CHECKING:
    from refdem.core.case import Instance
    from refdem.planning.plan import Task

SKIPPED = {
    "rotation": "rotation (no body can rotate)",
    "tumbling": "Euler's equations (every body spins about a conserved axis)",
    "constraint": "the constraint solver (no constraints)",
    "contact": "contact search (no shapes that can touch)",
    "friction": "friction",
}
"""For each feature, the words for a scene that does not need it."""


def command(
    case: Annotated[
        str,
        typer.Argument(
            autocompletion=completion.cases,
            help="A case such as `pendulum` or `pendulum[theta0=2]`.",
        ),
    ] = "",
    engine: Annotated[
        list[str] | None,
        typer.Option(
            autocompletion=completion.engines, help="Engines; default: all installed engines."
        ),
    ] = None,
    set: Annotated[
        list[str] | None, typer.Option(help="Parameter of the case, name=value.")
    ] = None,
    timeout: Annotated[
        float, typer.Option(help="Limit on the CPU time of a proof [s].", min=1e-3, max=1e6)
    ] = 60.0,
    features: Annotated[
        bool,
        typer.Option(
            "--features",
            help=(
                "Instead, list the values that `supports`, `order_with` and `conserves`"
                " accept in a refdem.toml."
            ),
        ),
    ] = False,
) -> None:
    """Shows which methods and checks run for a case.

    Reports also why the others do not run. With --features, explains the values that a refdem.toml
    accepts.

    Example: refdem explain free-rigid-body --engine mujoco
    """
    from refdem.cli.progress import Progress
    from refdem.cli.without_effect import sentences
    from refdem.core.parameters import labelled, settings
    from refdem.core.store import Store, default_path
    from refdem.errors import UsageError
    from refdem.execution.schedule import Schedule
    from refdem.planning import plan
    from refdem.planning.specification import Entry, Specification
    from refdem.planning.truths import sampled_truths

    if features and not case:
        print("\n".join(meanings()))
        return
    if features or not case:
        raise UsageError("expected a case (`refdem list cases`), or --features alone")
    name, parameters_of_label = labelled(case)
    parameters = parameters_of_label | settings(set or [])
    specification = Specification(
        name="explain",
        case=[Entry(name, parameters)],
        engines=engine or [],
        timeout=timeout,
    )
    engines, missing = plan.engines(specification)
    store = Store(default_path())
    for instance, only in plan.instances(specification):
        print("\n".join(problem_lines(instance)), flush=True)
        # As in a campaign, the proof has a time limit and is kept in the store.
        with Schedule(1, specification.timeout) as schedule:
            (truth,) = sampled_truths(schedule, store, [(instance, ())], Progress())
        if truth.reason:
            print(f"  certified for {truth.until} of {len(instance.times)} samples: {truth.reason}")
        else:
            for sentence in sentences(instance, store):
                print(f"  {sentence}")
        for chosen_engine in engines:
            print_tasks(
                plan.tasks(specification, instance, only, chosen_engine, truth, truth.reason)
            )
    for missing_engine, reason in missing.items():
        print(f"  {missing_engine}: not installed; {reason}")


def meanings() -> list[str]:
    """Lines with every feature and every law that a refdem.toml may name, and what they mean."""
    from refdem.engines.external.features import IMPLIED, KEPT, MEANINGS

    lines = ["words of `supports`: what a scene may have"]
    lines += [f"  {name:32}{MEANINGS[name]}" for name in sorted(MEANINGS.keys() - IMPLIED)]
    lines += ["words that come with others, and need not be named there"]
    lines += [f"  {name:32}{MEANINGS[name]}" for name in sorted(IMPLIED)]
    lines += [
        "keys of `order_with`: any of these words, with the order of the method in scenes that",
        "have it, where that is lower: order_with = { contact = 1, friction = 1 }",
    ]
    lines += ["words of `conserves`: what the method keeps to round-off, whatever the step"]
    return lines + [f"  {name:32}{KEPT[name]}" for name in sorted(KEPT)]


def problem_lines(instance: "Instance") -> list[str]:
    """Lines about a problem: its title, the features that an engine must have, those that it does
    without, and its scales.
    """
    from refdem.core.problem import Motion

    features = instance.problem.features
    scales = instance.scales
    problem = instance.problem
    lines = [f"{instance.label}: {instance.case.title}"]
    if not isinstance(problem, Motion):
        return [
            *lines,
            (
                f"  problem: {problem.words}: {', '.join(sorted(features))}; samples up to"
                f" {problem.when(problem.times[-1])}"
            ),
        ]
    dimension = next(feature[-1] for feature in features if feature.startswith("dimension:"))
    skipped = [words for feature, words in SKIPPED.items() if feature not in features]
    without = ", ".join(skipped) or "nothing"
    sizes = f"L = {scales.length:.6g} m, tau = {scales.tau:.6g} s, T = {scales.duration:.6g} s"
    needs = f"  required features: {', '.join(sorted(features))}"
    return [
        *lines,
        needs,
        f"  not needed: {without}",
        f"  motion in {dimension} of 3 dimensions; {sizes}",
    ]


def print_tasks(tasks: "Iterable[Task]") -> None:
    """Prints the methods of one engine: runs and checks, then why a check is left out and why a
    method is refused, each reason once for all of them.
    """
    left_out: dict[str, list[str]] = {}
    refused: dict[str, list[str]] = {}
    from refdem.core.check import Check

    for task in tasks:
        title = f"  {task.engine.name}/{task.method.name}"
        if task.unsupported is not None:
            # The reason names the feature of the scene first, then what the method expects.
            reason = one_line(task.unsupported).partition("; expected")[0]
            refused.setdefault(f"{task.engine.name}: not supported: {reason}", []).append(
                task.method.name
            )
            continue
        levels = (
            ", ".join(f"{level:.3g}" for level in task.subject.levels if level) or "one run, exact"
        )
        print(
            f"{title}: {len(task.variants)} runs; levels: {levels}\n      checks:"
            f" {', '.join(check.name for check in task.checks)}"
        )
        deciding = [check.name for check in task.checks if type(check).further is not Check.further]
        if deciding:
            print(f"      finer runs only where these do not decide: {', '.join(deciding)}")
        for name, reason in task.left_out.items():
            left_out.setdefault(f"{name}: {reason}", []).append(task.method.name)
    for reason, methods in left_out.items():
        print(f"      not checked: {one_line(reason)} ({', '.join(methods)})")
    for refusal, methods in refused.items():
        print(f"  {refusal} ({', '.join(methods)})")
