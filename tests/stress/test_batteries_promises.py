"""No false alarms: the reference holds the last rung that it promises, on every ladder of every
battery.
"""

from pathlib import Path

import pytest

from refdem.stress.ladder import Ladder
from refdem.stress.selection import battery, names
from tests.stress import carried

DEAR = ("friction", "mass-ratio", "restitution")
"""Batteries whose truth takes seconds: one ladder of each stands for all here, and `refdem stress`
climbs the others.
"""

EVER = float("inf")
"""No forecast is too long: what is promised is climbed, however busy or slow the machine is."""
STIFF = "fast and slow together"
HOLDS = {STIFF: "exact-linear"}
"""The method that climbs to a promised rung to which a method of steps would need minutes."""


def promised() -> list[tuple[str, str, tuple[str, ...]]]:
    """Battery, ladder and its last promised rung; of costly ladders all up to it, for the
    forecast.
    """
    found = []
    for name in names():
        ladders = [ladder for ladder in battery(name).ladders if ladder.promised]
        found += [
            (name, ladder.name, _due(ladder))
            for ladder in (ladders[:1] if name in DEAR else ladders)
        ]
    return found


def _due(ladder: Ladder) -> tuple[str, ...]:
    if ladder.costly:
        return ladder.rungs[: ladder.rungs.index(ladder.promised) + 1]
    return (ladder.promised,)


@pytest.mark.parametrize(
    ("name", "ladder", "rungs"), [pytest.param(*due, id=f"{due[0]}-{due[1]}") for due in promised()]
)
def test_the_reference_holds_what_it_promises(
    name: str, ladder: str, rungs: tuple[str, ...], tmp_path: Path
) -> None:
    record = carried.climbs(
        tmp_path, name, ladder, rungs, method=HOLDS.get(ladder, ""), longest=EVER
    )
    assert any(climb.kept for climb in record.climbs), "no method reached the promised rung"
    broken = [
        (climb.method, climb.end.sentence)
        for climb in record.climbs
        if climb.kept is False and climb.end
    ]
    assert not broken


def test_a_method_of_steps_holds_the_rungs_of_a_stiff_ladder_that_take_less_than_a_second(
    tmp_path: Path,
) -> None:
    rungs = ("1", "1e1", "1e2", "1e3", "1e4", "1e5")
    record = carried.climbs(
        tmp_path, "stiffness", STIFF, rungs, method="taylor-oscillator", longest=EVER
    )
    assert carried.verdicts(record) == {"taylor-oscillator": ["pass"] * len(rungs)}


def test_every_battery_promises_something_of_the_reference_or_says_that_it_only_informs() -> None:
    assert {
        name for name in names() if not any(ladder.promised for ladder in battery(name).ladders)
    } <= {"many-steps"}


def test_a_drift_within_the_quarter_that_is_fitted_is_no_breach_at_the_start(
    tmp_path: Path,
) -> None:
    """At the start the claim alone allows 2e-6, and the fit leaves 5e-6 of the drift there."""
    record = carried.climbs(
        tmp_path, "many-steps", "harmonic oscillator", ("65536",), method="gear-6", longest=EVER
    )
    assert carried.verdicts(record) == {"gear-6": ["pass"]}
