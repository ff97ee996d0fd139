"""Numbers that a program misreads are named with their sizes, and nothing else is called so."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction

import pytest

from refdem.cli import diagnose
from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.engine import Engine
from refdem.core.parameters import Parameters
from refdem.core.problem import Request
from refdem.core.refinement import levels
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.diagnosis.misreading import Misreading, misreading
from refdem.errors import NotCertifiedError, RefdemError
from refdem.faults.catalogue import faults
from refdem.faults.fault import Carrier
from refdem.faults.settings import SETTINGS
from refdem.faults.transparent import Transparent
from refdem.truth.dual import Derivatives
from refdem.truth.sensitivities import Number, at_times

SECONDS = 100.0
REFERENCE = discovery.engine("reference")


def runs(engine: Engine, asked: Instance, method: str) -> list[Trajectory]:
    """The engine's runs at two steps, or twice the same of an exact method."""
    claims = engine.method(method)
    steps: list[float | None] = [None, None]
    if claims.control == "step":
        step = levels(asked, claims, 4, 1e6)[-1]
        steps = [step, step / 2]
    requests = [Request(problem=asked.problem, method=method, step=step) for step in steps]
    return [engine.run(request)[0] for request in requests]


@pytest.fixture
def _differentiated_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The derivatives of a case at the same numbers and times are proved once in a test."""
    kept: dict[object, list[Derivatives]] = {}

    def derivatives_at(
        make: Callable[[Parameters], Truth],
        p: Parameters,
        numbers: Sequence[Number],
        times: Sequence[Fraction],
        digits: int,
    ) -> list[Derivatives]:
        key = (make, tuple(p.texts().items()), tuple(numbers), tuple(times), digits)
        if key not in kept:
            kept[key] = at_times(make, p, numbers, times, digits)
        return kept[key]

    monkeypatch.setattr("refdem.diagnosis.misreading.at_times", derivatives_at)


def misread(case: str, method: str, **given: str) -> Misreading:
    """What a program that answers for other numbers than it is asked for has misread."""
    chosen = discovery.case(case)
    times = chosen.at().times
    duration = str(float(times[-1]))
    right = chosen.at(duration=duration)
    wrong = chosen.at(duration=duration, **given)
    return misreading(right, *runs(REFERENCE, wrong, method), SECONDS)


@pytest.mark.parametrize(
    ("case", "method", "given", "said"),
    [
        ("pendulum", "rattle", {"gravity": "9.3"}, {"gravity": 9.3 / 9.8125 - 1}),
        ("pendulum", "rattle", {"theta0": "1.0001"}, {"theta0": 1e-4}),
        ("free-rigid-body", "exact-free-body", {"inertia": "1,2.00001,3"}, {"inertia.1": 5e-6}),
        ("free-rigid-body", "rk4-free-body", {"inertia": "1,2.1,3"}, {"inertia.1": 0.05}),
        ("two-body-orbit", "exact-kepler", {"gm": "1.01"}, {"gm": 0.01}),
        ("hard-spheres", "impacts", {"restitution": "0.74"}, {"restitution": -1 / 75}),
        ("two-spheres", "velocity-verlet", {"stiffness": "130"}, {"stiffness": 1 / 64}),
    ],
)
def test_a_number_that_is_misread_is_named_with_its_size(
    case: str, method: str, given: dict[str, str], said: dict[str, float]
) -> None:
    found = misread(case, method, **given)
    (fit,) = found.fits
    shares = [amount / value for amount, value in zip(fit.amounts, fit.values, strict=True)]
    assert [number.name for number in fit.numbers] == list(said)
    assert shares == pytest.approx(list(said.values()), rel=2e-2)
    assert "no other parameter of the case explains it" in found.sentence()


def test_two_numbers_that_are_misread_at_once_are_both_named() -> None:
    found = misread("two-body-orbit", "exact-kepler", gm="1.01", eccentricity="0.51")
    (fit,) = found.fits
    assert {number.name for number in fit.numbers} == {"gm", "eccentricity"}
    assert " and " in found.sentence()


def test_numbers_that_a_run_cannot_tell_apart_are_all_named() -> None:
    """A spring and a mass move alike where their ratio is the same."""
    found = misread("harmonic-oscillator", "velocity-verlet", mass="1.1")
    names = {fit.numbers[0].name for fit in found.fits}
    assert names == {"mass", "stiffness"}
    assert "this run cannot distinguish them" in found.sentence()


def test_a_right_program_has_misread_nothing() -> None:
    found = misread("pendulum", "rattle")
    assert found.is_noise
    assert not found.fits
    assert "within its discretisation error" in found.sentence()


@pytest.mark.usefixtures("_differentiated_once")
@pytest.mark.parametrize(
    ("case", "numbers"),
    [
        ("free-rigid-body", {"inertia-one-percent"}),
        ("harmonic-oscillator", {"stiffness-by-a-hair", "masses-five-digits", "mass-lossy"}),
    ],
)
def test_a_fault_that_is_no_misread_number_is_not_called_one(case: str, numbers: set[str]) -> None:
    """Of the catalogue's faults that act on a case, only those are explained that are a misread
    number of it.
    """
    instance = discovery.case(case).at(duration="5")
    explained = []
    for fault in faults():
        if all(SETTINGS[name].case != case for name in fault.on):
            continue
        engine = Carrier(Transparent(), fault)
        try:
            made = runs(engine, instance, "rk4")
            found = misreading(instance, *made, SECONDS)
        except (RefdemError, RuntimeWarning):
            # A fault may break its run off.
            continue
        # Two numbers at once, or one that is 0 in the case, fit much.
        if found.fits and len(found.fits[0].numbers) == 1 and found.fits[0].values[0] != 0:
            explained.append(fault.name)
    assert set(explained) == numbers


def test_what_would_take_too_long_is_left_to_twins() -> None:
    instance = discovery.case("double-pendulum").at()
    with pytest.raises(NotCertifiedError, match="would take longer than"):
        misreading(instance, *runs(REFERENCE, instance, "rod-chain"), 1e-6)


def test_the_command_names_numbers_where_no_twin_moves_alike(monkeypatch, capsys) -> None:
    """No twin has Kepler's equation."""
    case = discovery.case("two-body-orbit")
    wrong = case.at(gm="1.01", duration="12")
    answer = REFERENCE.run

    def misreads(request: Request) -> object:
        return answer(replace(request, problem=wrong.problem))

    monkeypatch.setattr(REFERENCE, "run", misreads)
    monkeypatch.setattr(discovery, "engine", lambda name: REFERENCE)
    diagnose.command("two-body-orbit[duration=12]/reference/exact-kepler", json=True)
    told = json.loads(capsys.readouterr().out)
    assert told["explained_by"] is None
    assert told["misread"][0]["numbers"] == {"gm": pytest.approx(0.01, rel=1e-6)}
    assert "gm 1 % too large explains 99.99 %" in told["sentence"]
