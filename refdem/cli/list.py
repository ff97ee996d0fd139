"""refdem list: cases, engines and checks."""

from typing import Annotated, Any

import typer

from refdem.errors import UsageError


def command(
    what: Annotated[str, typer.Argument(help="cases, engines or checks")] = "cases",
    about: Annotated[
        list[str] | None, typer.Argument(help="Words that a case is found by, as friction.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Lists cases with their parameters, engines and codes with their methods, or checks.

    Example: refdem list cases friction
    """
    import json as format

    kinds = {"cases": case, "engines": engine, "checks": check}
    if what not in kinds:
        raise UsageError(f"list got {what!r}; expected cases, engines or checks")
    from refdem.core import codes, discovery

    listed = discovery.names(what)
    if about:
        text = " ".join(about)
        if what != "cases":
            raise UsageError(
                f"list {what} got {text!r}; words find cases only: `refdem list cases`"
            )
        listed = discovery.cases_about(text)
        if not listed:
            raise UsageError(f"no case is about {text!r}; `refdem list cases` has them all")
    if what == "engines":
        listed += [name for name in codes.descriptions() if name not in listed]
    items = [kinds[what](name) for name in listed]
    if json:
        print(format.dumps(items, indent=1))
        return
    for item in items:
        print(f"{item['id']:22} {item['title']}")
        for line in item.get("parameters", item.get("methods", [])):
            print(
                f"    {line['name']:20} {line.get('default', ''):12} {line.get('unit', ''):8}"
                f" {line.get('bounds', '')} {line['doc']}"
            )


def case(name: str) -> dict[str, Any]:
    """A case as JSON has it: with its parameters and quantities, or for a selection of cases the
    check by which it selects.
    """
    from refdem.core import discovery
    from refdem.core.selection import Selection

    listed = discovery.case(name)
    if isinstance(listed, Selection):
        return {
            "id": listed.id,
            "title": listed.title,
            "statement": listed.statement,
            "selects_by_check": listed.check,
        }
    instance = listed.at()
    parameters = [
        {
            "name": p.name,
            "default": p.default,
            "unit": p.unit,
            "bounds": p.bounds(),
            "shape": p.shape,
            "choices": p.choices,
            "doc": p.doc,
        }
        for p in instance.p.declared.values()
    ]
    quantities = [{"name": q.name, "unit": q.unit} for q in instance.quantities.values()]
    return {
        "id": listed.id,
        "title": listed.title,
        "statement": listed.statement,
        "parameters": parameters,
        "quantities": quantities,
    }


def engine(name: str) -> dict[str, Any]:
    """An engine as JSON has it: with its methods and their claims."""
    from refdem.campaign.sheets import claims
    from refdem.core import discovery

    listed = discovery.engine(name)
    missing = listed.missing()
    methods = [{"name": m.name, "doc": claims(m)} for m in listed.methods]
    state = f"{listed.title}: not installed; {missing}"
    if missing is None:
        state = f"{listed.title} {listed.version()}"
    return {"id": name, "title": state, "installed": missing is None, "methods": methods}


def check(name: str) -> dict[str, Any]:
    """A check as JSON has it: with the fault that it kills."""
    from refdem.core import discovery

    listed = discovery.check(name)
    return {"id": name, "title": listed.title, "kills": listed.kills}
