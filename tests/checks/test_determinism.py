"""The check of determinism: the same bits again, with denser output, and on more threads."""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError
from refdem.faults.fault import Carrier, Fault
from refdem.faults.transparent import Transparent
from refdem.planning.in_process import record_of, task_of, truth_of

GAS = {"n": "100", "duration": "1", "samples": "4"}


def findings(engine) -> dict[str, str]:
    """Outcomes of the check by quantity, for the reference's gas in an engine."""
    instance = discovery.case("granular-gas").at(**GAS)
    record = record_of(task_of(engine, "gas", instance, truth_of(instance), 2))
    return {f.quantity: f.outcome for f in record.findings if f.check == "determinism"}


def summed_by_threads(request: Request, run: Trajectory) -> Trajectory:
    """One velocity is off by a last digit if there is more than one thread."""
    if request.threads == 1:
        return run
    velocity = run.velocity.copy()
    velocity[-1, 0, 0] = np.nextafter(velocity[-1, 0, 0], np.inf)
    return replace(run, velocity=velocity)


def test_a_gas_has_the_same_bits_on_two_threads():
    outcomes = findings(ENGINE)
    assert outcomes["threads"] == "pass"
    assert set(outcomes.values()) == {"pass"}


def test_a_last_digit_that_depends_on_the_number_of_threads_fails():
    fault = Fault(
        name="summed-by-threads",
        kind="gas",
        sentence="Sums depend on the number of threads.",
        on=(),
        sees=("determinism", "threads"),
        after=summed_by_threads,
    )
    outcomes = findings(Carrier(ENGINE, fault))
    assert [name for name, outcome in outcomes.items() if outcome == "fail"] == ["threads"]


def test_threads_are_in_a_request_only_where_there_are_more_than_one():
    problem = discovery.case("granular-gas").at(**GAS).problem
    one = Request(problem=problem, method="gas", step=problem.interval / 64)
    two = replace(one, threads=2)
    assert b"threads" not in one.to_json()
    assert b'"threads":2' in two.to_json()
    assert Request.from_json(two.to_json()).threads == 2
    assert Request.from_json(one.to_json()).threads == 1
    assert one.key() != two.key()


def test_no_thread_at_all_is_refused():
    problem = discovery.case("granular-gas").at(**GAS).problem
    with pytest.raises(UsageError, match="threads is 0"):
        Request(problem=problem, method="gas", threads=0)


def opposite_where_dense(request: Request, run: Trajectory) -> Trajectory:
    """Every other attitude is written with the opposite sign; which of them, depends on the number
    of samples.
    """
    attitude = run.attitude.copy()
    attitude[len(run.t) % 3 :: 2] *= -1.0
    return replace(run, attitude=attitude)


def turned_a_little(request: Request, run: Trajectory) -> Trajectory:
    """The opposite sign, and a last digit besides that depends on the number of samples."""
    attitude = -run.attitude
    attitude[-1, 0, 1] += len(run.t) * 1e-15
    return replace(run, attitude=attitude)


@pytest.mark.parametrize(
    ("after", "outcome"), [(opposite_where_dense, "pass"), (turned_a_little, "fail")]
)
def test_attitudes_are_compared_up_to_their_sign(after, outcome):
    fault = Fault(
        name="opposite",
        kind="rotation",
        sentence="",
        on=(),
        sees=("determinism", "output-rate"),
        after=after,
    )
    instance = discovery.case("free-rigid-body").at(duration="2")
    task = task_of(
        Carrier(Transparent(), fault), "verlet", instance, truth_of(instance), 3, ("determinism",)
    )
    outcomes = {f.quantity: f.outcome for f in record_of(task).findings}
    assert outcomes["output-rate"] == outcome
    assert outcomes["repeated"] == "pass"
