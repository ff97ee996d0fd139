"""refdem truth: certified values, each with its radius."""

import re
from fractions import Fraction
from typing import Annotated, Any

import typer

from refdem.errors import UsageError


def command(
    case: Annotated[str, typer.Argument(help="The case.")],
    set: Annotated[list[str] | None, typer.Option(help="Parameter, name=value.")] = None,
    at: Annotated[str, typer.Option(help="Times [s], separated by commas; decimals or fractions, exact.")] = "",
    digits: Annotated[int, typer.Option(help="Digits after which the radius may begin.", min=1, max=1000)] = 40,
    json: Annotated[bool, typer.Option("--json", help="For programs.")] = False,
) -> None:
    """Prints certified values of a case, for any parameters.

    Example: refdem truth pendulum --set theta0=2 --at 1,5/2 --json
    """
    from refdem.core import discovery
    from refdem.core.parameters import labelled, settings
    from refdem.core.selection import Selection

    name, own = labelled(case)
    found = discovery.case(name)
    if isinstance(found, Selection):
        raise UsageError(f"{name} is a selection of cases and has no truth of its own; ask for one of its cases")
    instance = found.at(**(own | settings(set or [])))
    times = [exact(text) for text in at.split(",") if text.strip()]
    truth = instance.truth().refined(digits)
    values = [value(None, *item, truth.method, digits) for item in truth.scalars().items()]
    for t in times:
        values += [value(t, *item, truth.method, digits) for item in truth.at(t).items()]
    show({"case": name, "parameters": instance.p.texts(), "values": values, "witness": truth.witness}, json)


def exact(text: str) -> Fraction:
    """A time as an exact number >= 0; raises UsageError."""
    if not re.fullmatch(r"\d{1,30}(\.\d{0,60})?([eE][+-]?\d{1,2})?(/[1-9]\d{0,30})?", text.strip()):
        raise UsageError(f"--at got {text!r}; expected times >= 0 such as 2.5 or 5/2, separated by commas")
    numerator, _, denominator = text.strip().partition("/")
    return Fraction(numerator) / int(denominator or 1)


def value(t: Fraction | None, quantity: str, ball: Any, method: str, digits: int) -> dict[str, str | None]:
    """One value as the JSON has it."""
    mid, radius = ball.decimals(places=digits + 5)
    when = None if t is None else str(t)
    return {"t": when, "quantity": quantity, "mid": mid, "radius": radius, "method": method}


def show(found: dict[str, Any], as_json: bool) -> None:
    """Prints as JSON or as a table."""
    import json

    if as_json:
        print(json.dumps(found, indent=1))
        return
    for item in found["values"]:
        when = "" if item["t"] is None else f"({item['t']} s)"
        print(f"{item['quantity'] + when:24} {item['mid']} +- {item['radius']}")
    print(f"method: {found['values'][0]['method'] if found['values'] else 'none'}\nwitness: {found['witness']}")
