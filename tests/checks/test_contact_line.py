"""contact-line: it passes what slides and rolls, fails wrong lever arms and moments of inertia, and
says where no friction acts. The checks of energy and of event times judge the same body.
"""

import pytest

from refdem.checks._sphere_on_plane import starts_on_plane
from refdem.core import discovery
from refdem.core.engine import Engine
from refdem.core.finding import Finding
from refdem.engines.reference import ENGINE
from refdem.faults.catalogue import chosen
from refdem.faults.transparent import Transparent
from refdem.planning.in_process import record_of, task_of, truth_of

SHORT = {"samples": "16"}
CASES = [
    {},
    {"speed": "1", "spin": "8", "inertia_factor": "1/2", "friction": "1"},
    {"slope": "3/4", "speed": "-2"},
    {"slope": "2", "speed": "-4", "inertia_factor": "1"},
    {"slope": "7/8", "speed": "0"},
]


def found(engine: Engine, method: str, check: str, **given: str) -> dict[str, Finding]:
    """The findings of one check, by quantity."""
    instance = discovery.case("rolling").at(**SHORT, **given)
    task = task_of(engine, method, instance, truth_of(instance), 4, (check,))
    return {f.quantity: f for f in record_of(task).findings if f.check == check}


@pytest.mark.parametrize("given", CASES, ids=str)
def test_the_reference_and_the_transparent_engine_pass(given: dict[str, str]) -> None:
    for engine, method in (
        (ENGINE, "exact-rolling"),
        (Transparent(), "verlet"),
        (Transparent(), "verlet-single"),
    ):
        for check in ("contact-line", "energy", "event-times"):
            outcomes = {f.outcome for f in found(engine, method, check, **given).values()}
            assert outcomes <= {"pass"}


def test_the_moment_the_work_and_the_onset_are_judged() -> None:
    for check, quantities in (
        ("contact-line", {"moment"}),
        ("energy", {"balance", "finest", "dissipation"}),
        ("event-times", {"stick"}),
    ):
        seen = found(Transparent(), "verlet", check)
        assert {name: f.outcome for name, f in seen.items()} == dict.fromkeys(quantities, "pass")


@pytest.mark.parametrize(
    "fault",
    [
        "rolling-wrong-inertia",
        "rolling-lever-of-the-diameter",
        "rolling-lever-one-in-a-thousand",
        "rolling-without-spin-up",
        "rolling-spins-backwards",
    ],
)
def test_a_fault_is_seen(fault: str) -> None:
    (wrong,) = chosen([fault])
    instance = discovery.case("rolling").at(**SHORT)
    task = task_of(wrong.carrier(), "verlet", instance, truth_of(instance), 4, ("contact-line",))
    (finding,) = (f for f in record_of(task).findings if f.check == "contact-line")
    assert finding.outcome == "fail"


def test_work_of_friction_that_is_not_all_told_is_seen() -> None:
    (unending,) = chosen(["rolling-friction-without-end"])
    outcomes = {f.outcome for f in found(unending.carrier(), "verlet", "energy").values()}
    assert "fail" in outcomes


def test_a_slip_that_ends_too_early_is_seen() -> None:
    (early,) = chosen(["rolling-below-a-threshold"])
    instance = discovery.case("rolling").at(**SHORT)
    task = task_of(early.carrier(), "verlet", instance, truth_of(instance), 6, ("event-times",))
    outcomes = {f.quantity: f.outcome for f in record_of(task).findings}
    assert outcomes["stick"] == "fail"


@pytest.mark.parametrize(
    "given", [{"friction": "0", "slope": "1/2"}, {"spin": "-8"}, {"friction": "0"}], ids=str
)
def test_where_no_friction_acts_there_is_nothing_to_judge(given: dict[str, str]) -> None:
    instance = discovery.case("rolling").at(**SHORT, **given)
    subject = task_of(ENGINE, "exact-rolling", instance, truth_of(instance), 4, ()).subject
    check = discovery.check("contact-line")
    assert check.applies(subject) == "no friction acts"


def test_a_ball_in_the_air_a_block_and_a_pair_do_not_lie_on_a_plane() -> None:
    for case in ("bouncing-ball", "block-on-slope", "hard-spheres", "hard-wall"):
        assert not starts_on_plane(discovery.case(case).at().scene)
    assert starts_on_plane(discovery.case("rolling").at().scene)
