"""refdem list: cases, engines and checks."""

from typing import Annotated, Any

import typer

from refdem.errors import UsageError


def command(
    what: Annotated[
        str,
        typer.Argument(help="cases, engines or checks. Any other word is a search word for cases."),
    ] = "cases",
    about: Annotated[
        list[str] | None, typer.Argument(help="Search words for cases, such as friction.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Lists cases, engines or checks.

    Cases are listed with their parameters, engines and codes with their methods.

    Example: refdem list friction
    """
    import json as format

    kinds = {"cases": case, "engines": engine, "checks": check}
    words = about or []
    if what not in kinds:
        # A word alone is about cases: `refdem list satellite`.
        words = [what, *words]
        what = "cases"
    from refdem.core import codes, discovery

    listed = discovery.names(what)
    if words:
        if what != "cases":
            raise UsageError(
                f"list {what} got {' '.join(words)!r}; search words apply to cases only: `refdem"
                " list cases`"
            )
        listed = found(" ".join(words))
    if what == "engines":
        listed += [name for name in codes.descriptions() if name not in listed]
    if what == "cases" and not json:
        kinds[what] = case_with_parameters
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


def found(text: str) -> list[str]:
    """Ids of the cases that have all words of a text, or of the one that it names; raises
    UsageError if there are none.
    """
    from refdem.core import discovery

    if text in discovery.names("cases"):
        return [text]
    about = discovery.cases_about(text)
    if not about:
        raise UsageError(
            f"no case matches {text!r}; `refdem list cases` lists all, `refdem list engines` and"
            " `refdem list checks` the rest"
        )
    return about


def case(name: str) -> dict[str, Any]:
    """A case as JSON has it: with its parameters and quantities, or for a selection of cases the
    check by which it selects.
    """
    from refdem.core import discovery
    from refdem.core.selection import Selection

    listed = discovery.case(name)
    described = case_with_parameters(name)
    if isinstance(listed, Selection):
        return described
    quantities = listed.at().quantities.values()
    return described | {"quantities": [{"name": q.name, "unit": q.unit} for q in quantities]}


def case_with_parameters(name: str) -> dict[str, Any]:
    """The same without the quantities, for which some cases compute their motion."""
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
        for p in (*listed.parameters, *listed.clock)
    ]
    return {
        "id": listed.id,
        "title": listed.title,
        "statement": listed.statement,
        "parameters": parameters,
    }


def engine(name: str) -> dict[str, Any]:
    """An engine as JSON has it: with its methods and their claims."""
    from refdem.core import discovery
    from refdem.planning.sheets import claims

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
