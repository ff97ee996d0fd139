"""refdem truth: certified values, each with its radius."""

import re
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Any

import typer

from refdem.cli import completion
from refdem.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from refdem.certification.listing import CertifiedCase
    from refdem.cli.progress import Watch
    from refdem.core.case import Instance
    from refdem.core.truth import Ball, Truth
    from refdem.truth.sensitivities import Sensitivities

    Values = Sequence[dict[str, str | None]]

LONG_PROOF = 10.0
"""Expected seconds of work above which they are announced beforehand."""
DERIVING = 10.0
"""Time of the derivatives, with the differences that enclose them, in units of that of the values.
Measured: 8 to 20.
"""
SHORT_PROOF = 0.5
"""Limit on the time [s] of a proof that only shows that a parameter has no effect."""


def command(
    case: Annotated[
        str,
        typer.Argument(
            autocompletion=completion.cases, help="Case; with --list and --csv, default: all."
        ),
    ] = "",
    set: Annotated[
        list[str] | None, typer.Option(help="Parameter of the case, name=value.")
    ] = None,
    at: Annotated[
        str,
        typer.Option(
            help="Times [s], separated by commas. Decimals and fractions are read exactly."
        ),
    ] = "",
    digits: Annotated[
        int, typer.Option(help="Number of certified digits of each value.", min=1, max=1000)
    ] = 40,
    sensitivities: Annotated[
        bool,
        typer.Option(
            "--sensitivities",
            help=(
                "Print the derivative of every quantity with respect to every number of the"
                " case, as balls."
            ),
        ),
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    list: Annotated[
        bool,
        typer.Option(
            "--list",
            help=(
                "List the certified sets with their numbers of values, digits, methods and"
                " witnesses."
            ),
        ),
    ] = False,
    csv: Annotated[
        bool,
        typer.Option(
            "--csv",
            help=(
                "Print the certified values that refdem contains, of one case or of all, as CSV."
            ),
        ),
    ] = False,
) -> None:
    """Prints certified values of a case.

    The parameters are free. With --list and --csv, shows the certified values that refdem contains.

    Example: refdem truth pendulum --set theta0=2 --at 1,5/2 --json
    """
    from refdem.cli.progress import Watch
    from refdem.core import discovery
    from refdem.core.parameters import labelled, settings
    from refdem.core.selection import Selection

    if list:
        listed(case, json)
        return
    if csv:
        print_certified_table(case)
        return
    if not case:
        raise UsageError(
            "expected a case, for example `refdem truth pendulum`; `refdem list cases` lists all,"
            " and `refdem truth --list` those with certified values"
        )
    name, of_label = labelled(case)
    chosen = discovery.case(name)
    if isinstance(chosen, Selection):
        raise UsageError(
            f"{name} is a selection of cases and has no truth of its own; ask for one of its cases"
        )
    instance = chosen.at(**(of_label | settings(set or [])))
    times = [exact(text) for text in at.split(",") if text.strip()]
    with Watch("proving") as watch:
        truth = instance.truth().refined(digits)
        seconds = announce(truth, max(times, default=Fraction(0)), digits, watch)
        if sensitivities:
            warn(DERIVING * seconds)
            print_derivatives(instance, times, digits, json)
            return
        values = values_at(truth, times, digits)
        without_effect = []
        if seconds <= SHORT_PROOF:
            without_effect = sentences_without_effect(instance, values, times, digits)
    document = {
        "case": name,
        "parameters": instance.p.texts(),
        "values": values,
        "witness": truth.witness,
    }
    # What is not a motion has no unit of time.
    unit = ""
    if "duration" in instance.p:
        unit = "s"
    print_document(document, json, unit)
    for sentence in without_effect:
        typer.echo(sentence, err=True)


def values_at(truth: "Truth", times: "Sequence[Fraction]", digits: int) -> "Values":
    """The scalars of a truth and its quantities at these times, as the JSON has them."""
    values = []
    for quantity, ball in scalars(truth, alone=not times).items():
        values.append(value(None, quantity, ball, truth.method, digits))
    for t in times:
        for quantity, ball in truth.at(t).items():
            values.append(value(t, quantity, ball, truth.method, digits))
    return values


def print_derivatives(
    instance: "Instance", times: "Sequence[Fraction]", digits: int, as_json: bool
) -> None:
    """Prints the certified derivatives of every quantity at these times by every number of the
    case; raises UsageError without a time.
    """
    import json

    from refdem.truth.sensitivities import sensitivities

    if not times and len(instance.times) > 1:
        raise UsageError("--sensitivities needs times: for example --at 5/2")
    # A case without time is looked at once.
    times = times or [Fraction(0)]
    parameters = instance.case.written_out(instance.p)
    found = [sensitivities(instance.case.truth, parameters, t, digits) for t in times]
    rows = [row for one in found for row in rows_of(instance, one, digits)]
    beside = [row for one in found for row in one_sided_rows(instance, one, digits)]
    missing = {number: reason for one in found for number, reason in one.missing.items()}
    if as_json:
        document = {
            "case": instance.case.id,
            "parameters": instance.p.texts(),
            "sensitivities": rows,
            "missing": missing,
            "beside": beside,
        }
        print(json.dumps(document, indent=1))
        return
    for row in rows:
        print(derivative_line(row))
    for row in beside:
        print(f"{derivative_line(row)}, beside it at {row['by']} = {row['at']}")
    for number, reason in missing.items():
        typer.echo(f"no derivative by {number}: {reason}", err=True)
    for number in without_effect(rows):
        typer.echo(f"no quantity depends on {number} at these times", err=True)


def rows_of(
    instance: "Instance", found: "Sensitivities", digits: int
) -> "Iterator[dict[str, str | None]]":
    """The derivatives of one time as the JSON has them."""
    for quantity, by_number in found.of.items():
        for number, ball in by_number.items():
            yield derivative(instance, found.t, quantity, number, ball, digits)


def one_sided_rows(
    instance: "Instance", found: "Sensitivities", digits: int
) -> "Iterator[dict[str, str | None]]":
    """The derivatives on either side of numbers by which there is none, as the JSON has them."""
    for number, sides in found.beside.items():
        for side in sides:
            for quantity, ball in side.of.items():
                row = derivative(instance, found.t, quantity, number, ball, digits)
                yield row | {"at": f"{float(side.place):.9g}"}


def derivative(
    instance: "Instance", t: Fraction, quantity: str, number: str, ball: "Ball", digits: int
) -> dict[str, str | None]:
    """One derivative as the JSON has it."""
    from refdem.core.moved import unit_of_derivative

    row = value(t, quantity, ball, "", digits)
    del row["method"]
    by = instance.p.declared[number.partition(".")[0]].unit
    declared = instance.quantities.get(quantity)
    unit = declared.unit if declared else "1"
    return row | {"by": number, "unit": unit_of_derivative(unit, by)}


def derivative_line(row: "Mapping[str, str | None]") -> str:
    """A derivative as a line for people."""
    name = f"d {row['quantity']}({row['t']})/d {row['by']}"
    return f"{name:34} {row['mid']} +- {row['radius']} {row['unit']}"


def without_effect(rows: "Values") -> list[str]:
    """The numbers by which all derivatives are exactly 0."""
    has_effect: dict[str, bool] = {}
    for row in rows:
        number = str(row["by"])
        is_zero = row["radius"] == "0" and Fraction(str(row["mid"])) == 0
        has_effect[number] = has_effect.get(number, False) or not is_zero
    return [number for number, acts in has_effect.items() if not acts]


def are_same(values: "Values", others: "Values") -> bool:
    """True if two lists have the same quantities at the same times, within their radii."""
    if [(one["t"], one["quantity"]) for one in values] != [
        (other["t"], other["quantity"]) for other in others
    ]:
        return False
    for one, other in zip(values, others, strict=True):
        distance = abs(Fraction(str(one["mid"])) - Fraction(str(other["mid"])))
        if distance > Fraction(str(one["radius"])) + Fraction(str(other["radius"])):
            return False
    return True


def sentences_without_effect(
    instance: "Instance", values: "Values", times: "Sequence[Fraction]", digits: int
) -> list[str]:
    """A sentence for each parameter that was set and changes none of the values.

    A parameter whose proof takes longer than SHORT_PROOF gets no sentence.
    """
    from refdem.cli.without_effect import at_defaults
    from refdem.errors import NotCertifiedError

    sentences = []
    latest = max(times, default=Fraction(0))
    for name, other in at_defaults(instance).items():
        try:
            truth = other.truth().refined(digits)
            if truth.forecast(latest, digits) > SHORT_PROOF:
                continue
            others = values_at(truth, times, digits)
        except NotCertifiedError:
            continue
        if are_same(values, others):
            default = instance.p.declared[name].default or "left out"
            sentences.append(
                f"{name}={instance.p.texts()[name]} changes none of these values: its default is"
                f" {default}"
            )
    return sentences


def scalars(truth: "Truth", *, alone: bool) -> "Mapping[str, Ball]":
    """The scalars; if none are certified, that is reported on stderr, and is the answer only if
    nothing else was requested.
    """
    from refdem.errors import NotCertifiedError

    try:
        return truth.scalars()
    except NotCertifiedError as error:
        if alone:
            raise
        typer.echo(f"no scalars are certified: {error}", err=True)
        return {}


def listed(case: str, as_json: bool) -> None:
    """Prints what is certified of a case (its sets), or of all (a line each); what has no witness
    is red.
    """
    import msgspec

    from refdem.certification.listing import certified_cases, in_all
    from refdem.planning.kept_truth import truth_folder
    from refdem.truth import load

    only = []
    if case:
        only.append(case)
    cases = certified_cases(truth_folder(), only)
    sets = []
    if case and cases and cases[0].sets:
        sets = load(case)
    if as_json:
        rows = []
        for certified in sets:
            count = len(certified.values)
            rows.append(
                {"set": certified.label, "values": count, "parameters": certified.parameters}
            )
        document = {"cases": cases, "sets": rows}
        print(msgspec.json.format(msgspec.json.encode(document)).decode())
        return
    print(
        f"{'case':24} {'sets':>4} {'values':>6} {'digits':>6} {'stale':>5}  method | witness when"
        " proved | witness in the tests"
    )
    for certified_case in cases:
        color = None
        if certified_case.has_no_witness:
            color = "red"
        typer.secho(line_of(certified_case), fg=color)
    for certified in sets:
        count = len(certified.values)
        print(f"    {certified.label}: {count} values at t = {times_of(certified)}")
    print(in_all(cases))


def line_of(certified: "CertifiedCase") -> str:
    """One case as a line: sets, values, digits, stale sets, methods, witness when it was proved,
    witness in the tests.
    """
    digits = "exact"
    if certified.digits is not None or not certified.sets:
        digits = str(certified.digits or "-")
    methods = "; ".join(certified.methods) or "nothing certified"
    witness = "none"
    if certified.witnessed:
        agreement = f"{certified.witnessed} values to {certified.agreed} digits"
        witness = f"{certified.witness} ({agreement})"
    counts = f"{certified.sets:4} {certified.values:6} {digits!s:>6} {certified.stale:5}"
    in_tests = certified.own_witness or "none"
    return f"{certified.case:24} {counts}  {methods} | {witness} | {in_tests}"


def times_of(certified: Any) -> str:
    """The times of a certified set, as printed text."""
    times = sorted({value.t for value in certified.values if value.t is not None})
    return ", ".join(str(t) for t in times) or "no time"


def announce(truth: "Truth", t: Fraction, digits: int, watch: "Watch") -> float:
    """Reports the expected time [s] of the values up to t, and returns it.

    A rough estimate is reported as soon as there is one, because the forecast of an expensive proof
    is itself expensive.
    """
    from refdem.cli.progress import rounded
    from refdem.truth.forecast import told_to

    is_announced = False

    def first_forecast(seconds: float) -> None:
        nonlocal is_announced
        watch.expect(seconds)
        if seconds > LONG_PROOF and not is_announced:
            is_announced = True
            watch.say(
                f"first estimate of the proof's run time: {rounded(seconds)} of CPU time; the"
                " estimate is being refined"
            )

    with told_to(first_forecast):
        seconds = truth.forecast(t, digits)
    watch.expect(seconds)
    warn(seconds)
    return seconds


def warn(seconds: float) -> None:
    """Warns of work longer than LONG_PROOF seconds; raises UsageError above HOPELESS."""
    from refdem.cli.progress import rounded
    from refdem.truth.forecast import HOPELESS

    if seconds > HOPELESS:
        raise UsageError(
            f"the proof would take about {rounded(seconds)} of CPU; ask for an earlier time, or"
            " for fewer digits"
        )
    if seconds > LONG_PROOF:
        typer.echo(
            f"the proof will take about {rounded(seconds)} of CPU; fewer digits or an earlier time"
            " take less",
            err=True,
        )


def print_certified_table(case: str) -> None:
    """Prints the certified store as CSV; raises UsageError for a case that it does not have."""
    import sys

    from refdem.truth.certified.reader import load
    from refdem.truth.certified.table import csv_of

    try:
        sys.stdout.write(csv_of(load(case)))
    except ValueError as error:
        raise UsageError(f"truth --csv: {error}") from None


def exact(text: str) -> Fraction:
    """A time as an exact number >= 0; raises UsageError."""
    if not re.fullmatch(r"\d{1,30}(\.\d{0,60})?([eE][+-]?\d{1,2})?(/[1-9]\d{0,30})?", text.strip()):
        raise UsageError(
            f"--at got {text!r}; expected times >= 0 such as 2.5 or 5/2, separated by commas"
        )
    numerator, _, denominator = text.strip().partition("/")
    return Fraction(numerator) / int(denominator or 1)


def value(
    t: Fraction | None, quantity: str, ball: Any, method: str, digits: int
) -> dict[str, str | None]:
    """One value as the JSON has it."""
    mid, radius = ball.decimals(places=digits + 5)
    time = None
    if t is not None:
        time = str(t)
    return {"t": time, "quantity": quantity, "mid": mid, "radius": radius, "method": method}


def print_document(document: dict[str, Any], as_json: bool, unit: str) -> None:
    """Prints the values as JSON, or as a table in which times have this unit."""
    import json

    if as_json:
        print(json.dumps(document, indent=1))
        return
    values = document["values"]
    for item in values:
        name = item["quantity"]
        if item["t"] is not None:
            # A map counts its iterates and has no unit of time.
            time = f"{item['t']} {unit}".rstrip()
            name = f"{name}({time})"
        print(f"{name:24} {item['mid']} +- {item['radius']}")
    method = "none"
    if values:
        method = values[0]["method"]
    print(f"method: {method}\nwitness: {document['witness']}")
