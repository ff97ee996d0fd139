"""refdem smoke: a few small scenes that test the adapter rather than the engine."""

from typing import Annotated

import typer


def command(
    engine: Annotated[str, typer.Argument(help="Engine, or path to a refdem.toml file.")],
) -> None:
    """Tests the adapter of an engine.

    Small scenes test its clock, units, signs, shapes, quaternion order and inertia axes.

    Example: refdem smoke mujoco
    """
    from refdem.core import discovery
    from refdem.errors import EngineMissingError, UsageError
    from refdem.smoke.battery import smoke

    chosen = discovery.engine(engine)
    if (reason := chosen.missing()) is not None:
        raise EngineMissingError(f"engine {engine} is not installed here; {reason}")
    findings = smoke(chosen)
    for finding in findings:
        print(f"{finding.outcome:12} {finding.quantity:24} {finding.sentence}")
    outcomes = {finding.outcome for finding in findings}
    if not outcomes & {"pass", "fail", "error"}:
        raise UsageError(
            f"nothing was judged: engine {engine} supports none of the scenes that test an adapter"
        )
    if "fail" in outcomes:
        raise typer.Exit(1)
    if "error" in outcomes:
        raise typer.Exit(3)
    raise typer.Exit(0)
