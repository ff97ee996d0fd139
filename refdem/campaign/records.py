"""The last stage of a campaign: the records of all tasks, judged from their runs."""

from collections.abc import Mapping

from refdem.campaign import judging
from refdem.campaign.deviations import of_engine
from refdem.campaign.plan import Task
from refdem.campaign.runs import Recent, Runs
from refdem.core.finding import Record


def records(tasks: list[Task], runs: Runs, versions: Mapping[str, str]) -> list[Record]:
    """The records in order of the plan, with the deviations that are expected of the engines."""
    engines = {task.engine.name: task.engine for task in tasks}
    expected = {name: of_engine(engine) for name, engine in engines.items()}
    judged = []
    for number, task in enumerate(tasks):
        name = task.engine.name
        of_task = runs.of_task(number)
        read = Recent(runs).trajectory
        judged.append(judging.record(task, versions[name], of_task, expected[name], read))
    return judged
