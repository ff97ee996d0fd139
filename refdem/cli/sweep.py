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
            help=(
                "A case such as `pendulum`, or `pendulum[gravity=2]` with fixed values of"
                " other parameters."
            ),
        ),
    ],
    set: Annotated[
        list[str] | None,
        typer.Option(
            help=(
                "Parameter with its values: name=0.5,1,2, or name=FIRST:LAST:STEP as in"
                " 0.5:2:0.5. Values of an array are separated by semicolons: name='1,2,3;1,2,4'."
                " Several parameters are combined in all ways."
            )
        ),
    ] = None,
    engine: options.Engines = None,
    method: Annotated[str, typer.Option(help="Run only this method of each engine.")] = "",
    step: Annotated[
        float | None, typer.Option(help="Largest step [s]. Each refinement halves the step.")
    ] = None,
    steps_per_tau: Annotated[
        float | None,
        typer.Option(help="Largest step, given as the number of steps per shortest time tau."),
    ] = None,
    levels: Annotated[
        int,
        typer.Option(
            help=(
                "Largest number of step sizes, each half of the previous one. An observed"
                " order needs three."
            ),
            min=1,
            max=10,
        ),
    ] = 4,
    out: Annotated[
        Path,
        typer.Option(
            help=(
                "Folder for sweep.md, sweep.csv and sweep.json; with two parameters also"
                " sweep.html."
            )
        ),
    ] = Path("refdem-sweep"),
    jobs: options.Jobs = None,
    scheduler: options.Scheduler = None,
    no_cache: Annotated[
        bool, typer.Option("--no-cache", help="Ignore stored runs and compute all of them.")
    ] = False,
    json: Annotated[
        bool, typer.Option("--json", help="Print the table as JSON instead of text.")
    ] = False,
) -> None:
    """Tabulates errors and costs over values of parameters.

    The table has the error, cost and verdict of engines in one case.

    Each row is one method at one setting with one step. The error is the largest over the run,
    against certified truth, in units of the scale of each quantity. The verdict is the worst one at
    that setting, over all steps. With two parameters, sweep.html has a heat map of correct digits
    for each method. Runs are stored, so that a sweep that was interrupted, or has more values,
    computes only those that are missing. The exit status is that of `refdem run`.

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
