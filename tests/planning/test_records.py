"""A task is judged as soon as its runs are there, and from runs in the order in which they were
asked for, whatever ended first.
"""

from collections.abc import Iterator

import pytest

from refdem.core import discovery
from refdem.core.finding import Record
from refdem.core.run import Run
from refdem.execution.spool import Spool, spool
from refdem.planning import judging, plan
from refdem.planning.in_process import run_of
from refdem.planning.records import records
from refdem.planning.runs import RequestedRun, Runner
from refdem.planning.specification import Entry, Specification


class Backwards(Runner):
    """Makes runs here, the last that was asked for first."""

    def __init__(self, spool: Spool, calls: list[str]) -> None:
        object.__setattr__(self, "spool", spool)
        object.__setattr__(self, "calls", calls)

    def runs(self, requested: list[RequestedRun], stage: str) -> Iterator[tuple[RequestedRun, Run]]:
        """The runs in the opposite order."""
        for one in reversed(requested):
            made = run_of(one.task.engine, one.request)
            assert made.trajectory is not None
            self.spool.keep(one.key, made.trajectory.to_bytes())
            run = Run(
                key=one.key, request=one.request, engine="reference", version="1", cost=made.cost
            )
            self.calls.append("run")  # type: ignore[attr-defined]
            yield one, run


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What happens, in its order: each run, and each record."""
    happened: list[str] = []
    record = judging.record

    def noted(*arguments: object) -> Record:
        happened.append("record")
        return record(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(judging, "record", noted)
    return happened


def test_a_task_is_judged_when_its_own_runs_have_ended(calls: list[str]) -> None:
    specification = Specification(
        name="t", case=[Entry("harmonic-oscillator")], levels=2, checks=["error", "reversal"]
    )
    instance = discovery.case("harmonic-oscillator").at(duration="4", samples="16")
    every = plan.tasks(specification, instance, (), discovery.engine("reference"), None)
    tasks = [task for task in every if task.method.name in ("velocity-verlet", "rk4")]
    assert len(tasks) == 2
    with spool() as trajectories:
        judged, runs = records(Backwards(trajectories, calls), tasks, {"reference": "1"}, 0)
        for number, task in enumerate(tasks):
            variants = list(runs.of_task(number))
            assert judged[number].method == task.method.name
            assert variants[: len(task.variants)] == [v for v in task.variants if v in variants]
    assert calls.count("record") == 2
    # The first is judged before the runs of the other.
    assert calls.index("record") < len(calls) - 1 - calls[::-1].index("run")
