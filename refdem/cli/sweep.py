"""refdem sweep: one case over values of its parameters, in engines, at several steps."""

from pathlib import Path
from typing import Annotated

import typer

from refdem.cli import completion, options
from refdem.errors import UsageError

CHECKS = ("error", "order")
"""Checks whose runs measure the error at every step and its order."""


def command(
    case: Annotated[
        str,
        typer.Argument(
            autocompletion=completion.cases,
            help="The case, also as `pendulum[gravity=2]` for parameters that stay.",
        ),
    ],
    set: Annotated[
        list[str] | None,
        typer.Option(
            help=(
                "Parameter with its values: name=0.5,1,2, or name=0.5:2:0.5 from first to last in"
                " steps; of an array, name='1,2,3;1,2,4'. With several, all combinations."
            )
        ),
    ] = None,
    engine: options.Engines = None,
    method: Annotated[str, typer.Option(help="Only this method of the engines.")] = "",
    step: Annotated[
        float | None, typer.Option(help="Largest step [s]; refinement continues from it.")
    ] = None,
    steps_per_tau: Annotated[
        float | None,
        typer.Option(help="Largest step, as the number of steps per shortest time tau."),
    ] = None,
    levels: Annotated[
        int,
        typer.Option(
            help="Steps at most, each half of the one before; an order needs three.", min=1, max=10
        ),
    ] = 4,
    out: Annotated[
        Path, typer.Option(help="Folder for sweep.md, .csv and .json; of two parameters .html.")
    ] = Path("refdem-sweep"),
    jobs: options.Jobs = None,
    scheduler: options.Scheduler = None,
    no_cache: Annotated[bool, typer.Option("--no-cache", help="Ignore stored runs.")] = False,
    json: Annotated[
        bool, typer.Option("--json", help="Print the table as JSON in place of text.")
    ] = False,
) -> None:
    """Tables error, cost and verdict over the parameters of a case, for engines and steps.

    Each row is one method at one setting with one step. The error is the largest over the run,
    against certified truth, in units of the scale of each quantity. The verdict is the worst of
    what was decided at that setting, over all steps. Of two parameters, sweep.html has a heat map
    of correct digits for each method. What has run is kept: a sweep that was killed, or has more
    values, runs only what is missing. Exit status as of `refdem run`.

    Example: refdem sweep pendulum --set theta0=0.5,1,2 --engine reference --engine mujoco
    """
    from refdem.cli.outputs import refuse_unwritable
    from refdem.cli.progress import Progress
    from refdem.cli.run import workers
    from refdem.cli.summary import exit_status
    from refdem.core.store import Store, default_path
    from refdem.planning import grid
    from refdem.planning.campaign import Campaign
    from refdem.planning.plan import present
    from refdem.planning.specification import Entry, Specification
    from refdem.report import heat_map, sweep
    from refdem.report.contents import contents_of
    from refdem.report.files import written

    if step is not None and steps_per_tau is not None:
        raise UsageError("got both --step and --steps-per-tau; expected at most one of them")
    address = options.scheduler_address(scheduler)
    count = workers(jobs)
    progress = Progress()
    instances, names = grid.instances(case, set or [])
    progress("settings", len(instances), len(instances))
    specification = Specification(
        name="sweep",
        case=[Entry(instance.case.id, instance.p.changed()) for instance in instances],
        engines=engine or [],
        checks=list(CHECKS),
        levels=levels,
        method=method,
        step=step,
        steps_per_tau=steps_per_tau,
    )
    specification, absent = present(specification)
    refuse_unwritable(out)
    store = Store(default_path())
    campaign = Campaign(specification, store, count, not no_cache, progress, address)
    sheets = campaign.sheets()
    settings = {}
    for instance in instances:
        texts = instance.p.texts()
        settings[instance.label] = {name: texts[name] for name in names}
    contents = contents_of(sheets)
    points = sweep.points(contents, settings)
    document = sweep.as_json(case, names, points, absent)
    title = f"Sweep of {case}"
    has_map = heat_map.write(out, title, names, points, store)
    written(out / "sweep.md", sweep.markdown(title, names, points, has_map=has_map))
    written(out / "sweep.csv", sweep.csv(names, points))
    written(out / "sweep.json", document)
    if json:
        print(document)
    else:
        made = contents.campaign.runs_made
        read = contents.campaign.runs_read
        print(sweep.text(names, points))
        print("\n".join([f"{made} runs made, {read} read from the store", *absent]))
        print(f"table: {out / 'sweep.csv'}")
        if has_map:
            print(f"heat map: {out / 'sweep.html'}")
    raise typer.Exit(exit_status(sheets, absent))
