"""Jobs in worker processes: what a job raises costs that job alone."""

from pathlib import Path

import pytest

from refdem.campaign.schedule import Job, Schedule
from refdem.core.run import Failure


class LocalError(ValueError):
    """An exception that cannot be made again from what it was given first: pickling it breaks a pool."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code


def works() -> bytes:
    return b"done"


def raises() -> bytes:
    raise LocalError("singular", "no analytic point")


def test_an_exception_that_cannot_travel_costs_its_own_job(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2])  # workers import this module by its name
    jobs = [Job(0, raises, ()), Job(1, works, ()), Job(2, raises, ())]
    with Schedule(1, 60) as schedule:
        found = {job.key: result for job, result in schedule.results(jobs)}
    assert found[1] == b"done"
    assert found[0] == found[2] == Failure(kind="exception", sentence="LocalError: no analytic point")
