"""refdem resolution: the smallest misreading of each number of a scene that fails the gate."""

from pathlib import Path
from typing import Annotated

import typer

from refdem.cli import completion, options
from refdem.errors import UsageError


def command(
    case: Annotated[
        list[str] | None,
        typer.Argument(
            autocompletion=completion.cases, help="Cases, also as `pendulum[theta0=2]`."
        ),
    ] = None,
    engine: options.Engines = None,
    method: Annotated[str, typer.Option(help="Only this method of the engines.")] = "",
    campaign: Annotated[
        str, typer.Option(help="The rows of this campaign, in place of cases.")
    ] = "",
    levels: Annotated[
        int,
        typer.Option(help="Steps at most, each half of the one before.", min=1, max=10),
    ] = 4,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Folder for resolution.md, and of the report whose case pages include the result."
        ),
    ] = None,
    jobs: options.Jobs = None,
    no_cache: Annotated[
        bool, typer.Option("--no-cache", help="Ignore what was measured before.")
    ] = False,
    computed: Annotated[
        bool,
        typer.Option(
            "--computed", help="Also compute it without misread runs, by certified derivatives."
        ),
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Finds the smallest relative misreading of each number of a scene that a run would notice.

    Each number (a mass, a stiffness, a friction, a start, ...) is multiplied by 1 + a in every
    request that an engine gets, and its runs are judged as if it had been read correctly. The
    smallest a at which some finding fails is found by trial, between 1e-12 and 1, without runs of
    changed scenes (shifted, boosted, relabelled), which may show more. The result says what a pass
    excludes, not whether the engine is right. Exit status 0.

    Example: refdem resolution hard-spheres --engine pymunk --engine rebound
    """
    import msgspec

    from refdem.cli.outputs import refuse_unwritable
    from refdem.cli.progress import Progress
    from refdem.cli.run import workers
    from refdem.core.parameters import labelled
    from refdem.core.store import Store, default_path
    from refdem.planning import foreseen, resolution
    from refdem.planning.plan import present
    from refdem.planning.specification import Entry, Specification, named
    from refdem.report import resolution as page

    if bool(case) == bool(campaign):
        raise UsageError(
            "expected cases (`refdem list cases`) or --campaign NAME, and not both; for example"
            " `refdem resolution hard-spheres`"
        )
    if campaign:
        specification = named(campaign)
    else:
        entries = [Entry(*labelled(label)) for label in case or []]
        specification = Specification(name="resolution", case=entries, levels=levels)
    specification = msgspec.structs.replace(
        specification, engines=engine or specification.engines, method=method
    )
    specification, absent = present(specification)
    if out is not None:
        refuse_unwritable(out)
    store = Store(default_path())
    found = resolution.measured(
        specification, store, workers(jobs), Progress(), use_store=not no_cache
    )
    if not found:
        raise UsageError("nothing was measured: none of the requested engines runs these cases")
    if computed:
        found = [foreseen.beside(specification, one) for one in found]
    if out is not None:
        page.write(out, found)
    if json:
        print(msgspec.json.format(msgspec.json.encode(found)).decode())
    else:
        print("\n".join([*page.lines(found), *absent]))
