"""refdem faults: known faults against checks: the kill matrix."""

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from refdem.kills.trials import Kill, Matrix


def command(
    engine: Annotated[
        str,
        typer.Option(
            help=(
                "Engine to plant the faults in, instead of the transparent one. Only faults of"
                " its input and output can be planted."
            )
        ),
    ] = "",
    seeds: Annotated[int, typer.Option(help="Number of random parameter sets per fault.")] = 20,
    fault: Annotated[
        list[str] | None, typer.Option(help="Names of faults, or of kinds of faults; default: all.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Plants known faults and shows which checks detect them.

    The engine without a fault is tested as well, for false alarms.

    A fault is killed if the check of the quantity that is named for it fails. Exit status 1 if a
    fault survives, or if a check fails for the engine without a fault.

    Example: refdem faults --seeds 2 --fault friction
    """
    import msgspec

    from refdem.cli.progress import Progress
    from refdem.core import discovery
    from refdem.errors import EngineMissingError, UsageError
    from refdem.faults.catalogue import chosen
    from refdem.kills.trials import FaultTrial

    if seeds < 1:
        raise UsageError(f"--seeds is {seeds}; expected a number >= 1")
    carrier = None
    if engine and engine != "transparent":
        carrier = discovery.engine(engine)
    if carrier is not None and (reason := carrier.missing()) is not None:
        raise EngineMissingError(f"engine {engine} is not installed here; {reason}")
    faults = chosen(fault or [])
    trial = FaultTrial(engine=carrier, seeds=seeds, chosen=faults, progress=Progress())
    matrix = trial.matrix()
    if json:
        print(msgspec.json.format(msgspec.json.encode(matrix)).decode())
    else:
        print("\n".join(lines(matrix)))
    if not matrix.kills:
        raise UsageError(
            f"nothing was judged: none of the requested faults applies to engine {engine}"
        )
    has_failed = bool(matrix.survivors() or matrix.alarms)
    raise typer.Exit(int(has_failed))


def lines(matrix: "Matrix") -> list[str]:
    """The matrix, class by class; survivors and alarms in full sentences; the counts."""
    by_fault: dict[str, list[Kill]] = {}
    for kill in matrix.kills:
        by_fault.setdefault(kill.fault, []).append(kill)
    printed = []
    kind = ""
    for kills in by_fault.values():
        # A heading for each class of faults.
        if kills[0].kind != kind:
            kind = kills[0].kind
            printed.append(f"{kind:40}killed  beyond   by the check, and others that saw it")
        printed.append(_row(kills))
    for kill in matrix.survivors():
        printed.append(
            f"SURVIVES {kill.fault} on {kill.label} (seed {kill.seed}):"
            f" {kill.check}/{kill.quantity}: {kill.sentence}"
        )
    for alarm in matrix.alarms:
        printed.append(f"ALARM {alarm.id} (seed {alarm.seed}): {alarm.sentence}")
    if matrix.idle():
        printed.append(f"checks that detect none of the faults: {', '.join(matrix.idle())}")
    nearest_first = sorted(matrix.near.items(), key=lambda pair: pair[1])
    near = ", ".join(f"{name} {margin:.1f}" for name, margin in nearest_first)
    printed.append(f"decades between the correct engine and its bounds: {near}")
    killed = sum(kill.killed for kill in matrix.kills)
    printed.append(
        f"{len(by_fault)} faults at {matrix.seeds} seeds: {killed} of {len(matrix.kills)} killed,"
        f" {len(matrix.alarms)} alarms"
    )
    return printed


def _row(kills: "list[Kill]") -> str:
    """One fault: at how many seeds it was killed, by how many decades at least, by what, and which
    other checks saw it.
    """
    first = kills[0]
    killed = sum(kill.killed for kill in kills)
    beyond = min((kill.beyond for kill in kills if kill.beyond is not None), default=None)
    others = sorted({name.split("/")[0] for kill in kills for name in kill.also} - {first.check})
    if beyond is None:
        decades = "broken"
    elif beyond == float("inf"):
        decades = "inf"
    else:
        decades = f"{beyond:.2f}"
    counts = f"{killed:3}/{len(kills):<3} {decades:>6}"
    also = ", ".join(others) or "nothing else"
    return f"  {first.fault:36} {counts}   {first.check}/{first.quantity}; {also}"
