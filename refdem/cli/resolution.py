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
            autocompletion=completion.cases,
            help="Cases such as `pendulum` or `pendulum[theta0=2]`.",
        ),
    ] = None,
    engine: options.Engines = None,
    method: Annotated[str, typer.Option(help="Run only this method of each engine.")] = "",
    campaign: Annotated[
        str, typer.Option(help="Campaign whose rows are used instead of cases.")
    ] = "",
    levels: Annotated[
        int,
        typer.Option(
            help="Largest number of step sizes, each half of the previous one.", min=1, max=10
        ),
    ] = 4,
    out: Annotated[
        Path | None,
        typer.Option(
            help=(
                "Folder for resolution.md. If it contains a report, the pages of its cases"
                " include the result."
            )
        ),
    ] = None,
    jobs: options.Jobs = None,
    no_cache: Annotated[
        bool, typer.Option("--no-cache", help="Ignore stored measurements.")
    ] = False,
    computed: Annotated[
        bool,
        typer.Option(
            "--computed",
            help=(
                "Also compute the result from certified derivatives, without runs that"
                " misread a number."
            ),
        ),
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Finds the smallest reading error of each number that is detected.

    Each number (a mass, a stiffness, a coefficient of friction, an initial value, ...) is
    multiplied by 1 + a in every request to an engine, and the runs are judged as if the number had
    been read correctly. A search between 1e-12 and 1 finds the smallest a at which a finding fails.
    Runs of changed scenes (shifted, boosted, relabelled) are left out; they may detect more. The
    result states which errors a passed check excludes, not whether the engine is right. Exit
    status 0.

    Example: refdem resolution hard-spheres --engine pymunk --engine rebound
    """
    import msgspec

    from refdem.cli.outputs import refuse_unwritable
    from refdem.cli.progress import Progress
    from refdem.cli.run import workers
    from refdem.core.parameters import labelled
    from refdem.core.store import Store, default_path
    from refdem.planning import predicted_resolution, resolution
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
        found = [predicted_resolution.beside(specification, one) for one in found]
    if out is not None:
        page.write(out, found)
    if json:
        print(msgspec.json.format(msgspec.json.encode(found)).decode())
    else:
        print("\n".join([*page.lines(found), *absent]))
