"""The bench on real cases: its numbers against what theory says of the methods."""

import sys
from pathlib import Path

import numpy as np
import pytest

from refdem.bench.beside import Beside
from refdem.bench.comparison import compared_in_turns
from refdem.bench.entrant import Entrant
from refdem.bench.levels import levels
from refdem.bench.memory import peaks
from refdem.bench.record import BenchRecord, Curve
from refdem.bench.session import Bench
from refdem.bench.stability import stability_limit
from refdem.bench.tables import introduction, tables
from refdem.core import discovery
from refdem.errors import UsageError
from refdem.planning.specification import Entry

REFERENCE = discovery.engine("reference")


@pytest.fixture(scope="module")
def record() -> BenchRecord:
    """The reference on a short harmonic oscillator."""
    entry = Entry("harmonic-oscillator", {"duration": "4"})
    options = {"with_peers": False, "with_memory": False}
    return Bench(
        [entry],
        ["reference"],
        rounds=4,
        most_steps=2e4,
        grow={"samples": ["64", "1024"]},
        **options,
    ).record()


def curve(record: BenchRecord, method: str) -> Curve:
    """The curve of a method of the reference."""
    return next(found for found in record.curves if found.method == method)


@pytest.mark.parametrize(("method", "order"), [("velocity-verlet", 2), ("rk4", 4)])
def test_the_order_seen_is_that_of_the_method(record: BenchRecord, method: str, order: int) -> None:
    assert curve(record, method).order_seen == pytest.approx(order, abs=0.1)


def test_the_constant_of_verlet_is_that_of_its_phase_error(record: BenchRecord) -> None:
    # Verlet's phase runs ahead by omega t (omega h)^2/24, and sin falls behind by that much: C (1 +
    # T/tau) = (T/tau)/24 at the most.
    found = curve(record, "velocity-verlet").constant_seen
    assert found is not None
    assert 0.3 / 24 < found < 1.2 / 24 + 1 / 8 / 5


def test_a_closed_form_has_every_error_at_one_price(record: BenchRecord) -> None:
    reached = curve(record, "exact-harmonic").reached
    assert all(reach is not None for reach in reached)
    assert len({reach.seconds for reach in reached if reach}) == 1


def test_what_a_low_order_cannot_reach_is_not_reached(record: BenchRecord) -> None:
    assert curve(record, "velocity-verlet").reached[-1] is None


GEAR = {f"gear-{order}" for order in (4, 5, 6)}


def test_every_method_of_a_scene_has_its_row(record: BenchRecord) -> None:
    # What the reference has in its registry is measured: no list is written by hand.
    body = Bench(
        [Entry("free-rigid-body", {"duration": "2"})],
        ["reference"],
        rounds=1,
        most_steps=2e3,
        with_peers=False,
        with_memory=False,
        with_stability=False,
    ).record()
    of_a_body = {f"{name}-free-body" for name in (*GEAR, "exact", "rk4", "splitting")}
    assert {found.method for found in body.curves} == {*of_a_body, "euler-angles"}
    assert all(found.points for found in body.curves)
    of_an_oscillator = {found.method for found in record.curves}
    assert of_an_oscillator >= {*GEAR, "exact-harmonic", "rk4", "velocity-verlet"}


def test_errors_at_equal_work_fall_with_the_order_and_with_time(record: BenchRecord) -> None:
    shown = {table.title: table for table in tables(record, "harmonic-oscillator[duration=4]")}
    rows = {row[0]: row[1:] for row in shown["Error at equal work"].rows}
    assert set(rows) == {row[0] for row in shown["Time to an error"].rows}
    in_a_millisecond = [
        float(rows[f"reference {name} (reference)"][1]) for name in ("velocity-verlet", "rk4")
    ]
    assert in_a_millisecond[0] > 100 * in_a_millisecond[1]


@pytest.mark.parametrize(
    ("method", "limit"), [("velocity-verlet", 1.0), ("rk4", 2.8284271247461903 / 2)]
)
def test_the_largest_stable_step_is_that_of_theory(method: str, limit: float) -> None:
    instance = discovery.case("harmonic-oscillator").at()
    found, _ = stability_limit(Entrant(instance, REFERENCE, REFERENCE.method(method), ()))
    assert found == pytest.approx(limit, rel=5e-3)


def test_a_closed_form_has_no_stability_limit() -> None:
    instance = discovery.case("harmonic-oscillator").at()
    assert stability_limit(
        Entrant(instance, REFERENCE, REFERENCE.method("exact-harmonic"), ())
    ) == (None, "")


def test_every_point_has_all_of_its_rounds(record: BenchRecord) -> None:
    assert len(record.yardstick) == 4
    assert all(
        len(point.rounds) == 4 and min(point.rounds) > 0
        for found in record.curves
        for point in found.points
    )


def test_steps_divide_the_interval_and_each_other() -> None:
    instance = discovery.case("pendulum").at()
    found = levels(instance, REFERENCE.method("rattle"), most_steps=1e5)
    whole = instance.times[1] / np.array(found)
    assert len(found) >= 3
    assert np.all(whole == np.round(whole))
    assert np.allclose(np.array(found[:-1]) / np.array(found[1:]), 4, rtol=0)


def test_time_grows_with_the_samples_that_are_asked_for(record: BenchRecord) -> None:
    grown = {growth.by: growth for growth in curve(record, "exact-harmonic").growth}
    assert grown["samples"].sizes == [64, 1024]
    assert "steps" in {growth.by for growth in curve(record, "rk4").growth}


def test_the_tables_say_reached_and_not_reached(record: BenchRecord) -> None:
    shown = {table.title: table for table in tables(record, "harmonic-oscillator[duration=4]")}
    rows = {row[0]: row for row in shown["Time to an error"].rows}
    assert rows["reference velocity-verlet (reference)"][4] == "not reached"
    assert "Faster than the best peer by" not in shown
    assert "4 interleaved rounds" in introduction(record)
    assert "more than 0.3 s or 2e+04 steps" in introduction(record)


def test_a_case_that_nobody_can_run_is_refused() -> None:
    with pytest.raises(UsageError, match=r"nothing could be run|no engine|no method"):
        Bench(
            [Entry("pendulum")], ["reference"], method="exact-harmonic", with_peers=False
        ).record()


def test_more_output_needs_more_memory() -> None:
    case = discovery.case("harmonic-oscillator")
    few, many = (
        Entrant(case.at(samples=n), REFERENCE, REFERENCE.method("exact-harmonic"), (0.0,)).request(
            0.0
        )
        for n in ("64", "100000")
    )
    least = (
        13 * 8 * 100_000 / 2
    )  # position, velocity, attitude, omega of a body; the allocator may have held a part already
    (peak,) = peaks([("reference", False, few, many)])
    assert peak is None or peak > least


def test_another_installation_runs_every_place_in_turns_with_this_one() -> None:
    entry = Entry("harmonic-oscillator", {"duration": "4", "samples": "2"})
    options = {
        "with_peers": False,
        "with_memory": False,
        "with_stability": False,
        "beside": Path(sys.executable),
    }
    record = Bench(
        [entry], ["reference"], method="rk4", rounds=4, most_steps=2e3, **options
    ).record()
    (found,) = record.curves
    assert all(len(point.beside) == 4 and min(point.beside) > 0 for point in found.points)
    assert 0.1 < compared_in_turns(record)[0].factor < 10  # the same code in another process


def test_a_python_without_refdem_is_refused(tmp_path: Path) -> None:
    python = tmp_path / "python"
    python.write_text("#!/bin/sh\nexit 1\n")
    python.chmod(0o755)
    with (
        Beside(python) as other,
        pytest.raises(UsageError, match=r"does not run refdem.bench.interleaving"),
    ):
        other.begin([])
