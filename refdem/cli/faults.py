"""refdem faults: known faults against checks: the kill matrix."""

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from refdem.campaign.kills import Kill, Matrix


def command(
    engine: Annotated[
        str,
        typer.Option(
            help=(
                "Engine that carries the faults instead of the transparent one; only its"
                " input and output are changed."
            )
        ),
    ] = "",
    seeds: Annotated[int, typer.Option(help="Number of random parameter sets.")] = 20,
    fault: Annotated[
        list[str] | None, typer.Option(help="Only these faults, or all of a kind.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Plants known faults in an engine and shows which checks see them, and that nothing is said
    against the engine without any.

    A fault is killed if the quantity named for it fails. Exit 1 if one survives or the correct
    engine alarms.

    Example: refdem faults --seeds 2 --fault friction
    """
    import msgspec

    from refdem.campaign.kills import FaultTrial
    from refdem.cli.progress import Progress
    from refdem.core import discovery
    from refdem.errors import EngineMissingError, UsageError
    from refdem.faults.catalogue import chosen

    if seeds < 1:
        raise UsageError(f"--seeds is {seeds}; expected a number >= 1")
    if engine and engine != "transparent":
        found = discovery.engine(engine)
    else:
        found = None
    if found is not None and (reason := found.missing()) is not None:
        raise EngineMissingError(f"engine {engine} is not installed here; {reason}")
    matrix = FaultTrial(
        engine=found, seeds=seeds, chosen=chosen(fault or []), progress=Progress()
    ).matrix()
    if json:
        print(msgspec.json.format(msgspec.json.encode(matrix)).decode())
    else:
        print("\n".join(lines(matrix)))
    if not matrix.kills:
        raise UsageError(
            f"nothing was judged: engine {engine} can carry none of the faults that were asked for"
        )
    has_failed = bool(matrix.survivors() or matrix.alarms)
    raise typer.Exit(int(has_failed))


def lines(matrix: "Matrix") -> list[str]:
    """The matrix, class by class; survivors and alarms in full sentences; the counts."""
    by_fault: dict[str, list[Kill]] = {}
    for kill in matrix.kills:
        by_fault.setdefault(kill.fault, []).append(kill)
    shown = []
    kind = ""
    for kills in by_fault.values():
        if kills[0].kind != kind:
            kind = kills[0].kind
            shown.append(f"{kind}{'':{40 - len(kind)}}killed  beyond   by, and what else saw it")
        shown.append(_row(kills))
    for kill in matrix.survivors():
        shown.append(
            f"SURVIVES {kill.fault} on {kill.label} (seed {kill.seed}):"
            f" {kill.check}/{kill.quantity}: {kill.sentence}"
        )
    for alarm in matrix.alarms:
        shown.append(f"ALARM {alarm.id} (seed {alarm.seed}): {alarm.sentence}")
    if matrix.idle():
        shown.append(f"checks that kill nothing: {', '.join(matrix.idle())}")
    near = ", ".join(
        f"{name} {margin:.1f}"
        for name, margin in sorted(matrix.near.items(), key=lambda pair: pair[1])
    )
    shown.append(f"decades between the correct engine and its bounds: {near}")
    killed = sum(kill.killed for kill in matrix.kills)
    shown.append(
        f"{len(by_fault)} faults at {matrix.seeds} seeds: {killed} of {len(matrix.kills)} killed,"
        f" {len(matrix.alarms)} alarms"
    )
    return shown


def _row(kills: "list[Kill]") -> str:
    """One fault: at how many seeds it was killed, by how many decades at least, by what, and which
    other checks saw it.
    """
    first = kills[0]
    killed = sum(kill.killed for kill in kills)
    beyond = min((kill.beyond for kill in kills if kill.beyond is not None), default=None)
    others = sorted({name.split("/")[0] for kill in kills for name in kill.also} - {first.check})
    if beyond is None:
        size = "broken"
    elif beyond == float("inf"):
        size = "inf"
    else:
        size = f"{beyond:.2f}"
    return (
        f"  {first.fault:36} {killed:3}/{len(kills):<3} {size:>6}   {first.check}/{first.quantity};"
        f" {', '.join(others) or 'nothing else'}"
    )
