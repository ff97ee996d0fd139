"""refdem explain: what will run, what is left out because the scene does not need it, and who refuses."""

from typing import Annotated

import typer


def command(
    case: Annotated[str, typer.Argument(help="The case, also as `pendulum[theta0=2]`.")],
    engine: Annotated[list[str] | None, typer.Option(help="Engines; none: all that are installed.")] = None,
    set: Annotated[list[str] | None, typer.Option(help="Parameter, name=value.")] = None,
) -> None:
    """Says what would run for a case, and why.

    Example: refdem explain free-rigid-body --engine mujoco
    """
    from refdem.campaign import plan
    from refdem.campaign.specification import Entry, Specification
    from refdem.cli.run import labelled, settings

    name, own = labelled(case)
    specification = Specification(name="explain", case=[Entry(name, own | settings(set or []))], engines=engine or [])
    engines, missing = plan.engines(specification)
    for instance, only in plan.instances(specification):
        scales = instance.scales
        print(f"{instance.label}: {instance.case.title}")
        print(f"  the scene needs: {', '.join(sorted(instance.scene.features))}")
        print(f"  L = {scales.length:.6g} m, tau = {scales.tau:.6g} s, T = {scales.duration:.6g} s, {len(instance.times)} samples")
        for found in engines:
            for task in plan.tasks(specification, instance, only, found, None):
                show(task)
    for name, reason in missing.items():
        print(f"  {name}: not installed; {reason}")


def show(task) -> None:  # type: ignore[no-untyped-def]
    """Prints one task."""
    title = f"  {task.engine.name}/{task.method.name}"
    if task.refusal is not None:
        print(f"{title}: refuses: {task.refusal}")
        return
    levels = ", ".join(f"{level:.3g}" for level in task.trial.levels if level) or "one run, exact"
    print(f"{title}: {len(task.variants)} runs; levels: {levels}")
    print(f"      checks: {', '.join(check.name for check in task.checks)}")
    for name, reason in task.left_out.items():
        print(f"      without {name}: {reason}")
