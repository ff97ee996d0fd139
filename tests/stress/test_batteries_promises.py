"""No false alarms: the reference holds the last point that it promises, on every sweep of every
battery.
"""

from pathlib import Path

import pytest

from refdem.stress.selection import battery, names
from refdem.stress.sweep import Sweep
from tests.stress import carried

DEAR = ("friction", "mass-ratio", "restitution")
"""Batteries whose truth takes seconds: one sweep of each stands for all here, and `refdem stress`
runs the others.
"""

EVER = float("inf")
"""No forecast is too long: what is promised is run, however busy or slow the machine is."""
STIFF = "fast and slow together"
HOLDS = {STIFF: "exact-linear"}
"""The method that reaches a promised point to which a method of steps would need minutes."""


def promised() -> list[tuple[str, str, tuple[str, ...]]]:
    """Battery, sweep and its last promised point; of costly sweeps all up to it, for the
    forecast.
    """
    found = []
    for name in names():
        sweeps = [sweep for sweep in battery(name).sweeps if sweep.promised]
        found += [
            (name, sweep.name, _due(sweep)) for sweep in (sweeps[:1] if name in DEAR else sweeps)
        ]
    return found


def _due(sweep: Sweep) -> tuple[str, ...]:
    if sweep.costly:
        return sweep.points[: sweep.points.index(sweep.promised) + 1]
    return (sweep.promised,)


@pytest.mark.parametrize(
    ("name", "sweep", "points"), [pytest.param(*due, id=f"{due[0]}-{due[1]}") for due in promised()]
)
def test_the_reference_holds_what_it_promises(
    name: str, sweep: str, points: tuple[str, ...], tmp_path: Path
) -> None:
    record = carried.results(
        tmp_path, name, sweep, points, method=HOLDS.get(sweep, ""), longest=EVER
    )
    assert any(result.kept for result in record.results), "no method reached the promised point"
    broken = [
        (result.method, result.end.sentence)
        for result in record.results
        if result.kept is False and result.end
    ]
    assert not broken


def test_a_method_of_steps_holds_the_points_of_a_stiff_sweep_that_take_less_than_a_second(
    tmp_path: Path,
) -> None:
    points = ("1", "1e1", "1e2", "1e3", "1e4", "1e5")
    record = carried.results(
        tmp_path, "stiffness", STIFF, points, method="taylor-oscillator", longest=EVER
    )
    assert carried.verdicts(record) == {"taylor-oscillator": ["pass"] * len(points)}


def test_every_battery_promises_something_of_the_reference_or_says_that_it_only_informs() -> None:
    assert {
        name for name in names() if not any(sweep.promised for sweep in battery(name).sweeps)
    } <= {"many-steps"}


def test_a_drift_within_the_quarter_that_is_fitted_is_no_breach_at_the_start(
    tmp_path: Path,
) -> None:
    """At the start the claim alone allows 2e-6, and the fit leaves 5e-6 of the drift there."""
    record = carried.results(
        tmp_path, "many-steps", "harmonic oscillator", ("65536",), method="gear-6", longest=EVER
    )
    assert carried.verdicts(record) == {"gear-6": ["pass"]}
