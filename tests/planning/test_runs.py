"""What is remembered from run to run of a campaign: the steps with which a method did not end."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.run import Failure, Run
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.execution.spool import spool
from refdem.planning import plan
from refdem.planning.runs import Hangs, Recent, RequestedRun, Runs
from refdem.planning.specification import Entry, Specification

HANG = Failure(kind="hang", sentence="it was still running")
CRASH = Failure(kind="crash", sentence="its process died")


def asked(step: float, duration: str = "4") -> RequestedRun:
    """A run of the reference at a step [s]."""
    specification = Specification(name="t", case=[Entry("harmonic-oscillator")], levels=2)
    instance = discovery.case("harmonic-oscillator").at(duration=duration, samples="16")
    tasks = plan.tasks(specification, instance, (), discovery.engine("reference"), None)
    task = next(one for one in tasks if one.method.control == "step" and one.unsupported is None)
    variant = Variant(step)
    return RequestedRun(
        place=(0, variant), task=task, request=plan.request(task, variant), key="key"
    )


@pytest.mark.parametrize(("step", "is_given_up"), [(0.125, True), (0.0625, True), (0.25, False)])
def test_a_step_that_hung_takes_all_smaller_ones_with_it(step: float, is_given_up: bool) -> None:
    hangs = Hangs()
    hangs.note(asked(0.125), HANG)
    failure = hangs.given_up(asked(step))
    assert (failure is not None) == is_given_up
    assert failure is None or not failure.is_begun


def test_what_hangs_at_two_steps_hangs_at_all_and_on_this_case_alone() -> None:
    hangs = Hangs()
    for step in (0.125, 0.0625):
        hangs.note(asked(step), HANG)
    assert hangs.given_up(asked(0.25)) is not None
    assert hangs.given_up(asked(0.125, duration="2")) is None


@pytest.mark.parametrize("failure", [None, CRASH])
def test_a_run_that_ended_takes_no_other_with_it(failure: Failure | None) -> None:
    hangs = Hangs()
    hangs.note(asked(0.125), failure)
    assert hangs.given_up(asked(0.0625)) is None


def test_one_campaign_knows_nothing_of_the_hangs_of_another() -> None:
    Hangs().note(asked(0.125), HANG)
    assert Hangs().given_up(asked(0.125)) is None


@pytest.mark.parametrize(
    ("failure", "is_lasting"),
    [(None, True), (Failure(kind="unsupported", sentence="no"), True), (CRASH, False)],
)
def test_runs_are_kept_whole_unless_one_may_end_otherwise(
    failure: Failure | None, is_lasting: bool
) -> None:
    one = asked(0.125)
    run = Run(key="key", request=one.request, engine="reference", version="1", failure=failure)
    with spool() as trajectories:
        found = Runs(spool=trajectories)
        found.add(one.place, run)
        assert found.is_lasting == is_lasting
        assert found.of_task(1) == {}
        assert found.different(read=False) == 1
        assert found.different(read=True) == 0


def test_the_trajectories_asked_for_last_are_held_as_far_as_there_is_room(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    t = np.arange(4.0)
    packed = Trajectory.of_values(t, {"x": t}).to_bytes()
    monkeypatch.setattr("refdem.planning.runs.HELD", 2 * len(packed))
    request = asked(0.125).request
    runs = [Run(key=key, request=request, engine="reference", version="1") for key in "abc"]
    with spool() as trajectories:
        for run in runs:
            trajectories.keep(run.key, packed)
        recent = Recent(Runs(spool=trajectories))
        first, second = map(recent.trajectory, runs[:2])
        assert recent.trajectory(runs[0]) is first
        # The second was not asked for longest, and goes.
        third = recent.trajectory(runs[2])
        assert recent.trajectory(runs[0]) is first
        assert recent.trajectory(runs[2]) is third
        again = recent.trajectory(runs[1])
        assert again is not second
        assert again is not None
        np.testing.assert_array_equal(again.values["x"], t)


def test_a_run_that_failed_has_no_trajectory_to_read() -> None:
    run = Run(
        key="key", request=asked(0.125).request, engine="reference", version="1", failure=CRASH
    )
    with spool() as trajectories:
        recent = Recent(Runs(spool=trajectories))
        assert recent.trajectory(run) is None
