"""Resolution: the smallest misreading of a number that a run would notice, found by trial."""

import numpy as np
import pytest
from msgspec.structs import replace

from refdem.core import discovery
from refdem.core.finding import Finding
from refdem.core.problem import Request
from refdem.core.resolution import NumberResolution, Resolution
from refdem.core.run import Failure
from refdem.core.store import Store
from refdem.execution.schedule import InProcess
from refdem.faults.numbers import numbers
from refdem.planning import plan
from refdem.planning import resolution as module
from refdem.planning.in_process import truth_of
from refdem.planning.resolution import CLOSE, FIRST, LEAST, Threshold, Trial, resolution, threshold
from refdem.planning.specification import Entry, Specification


def judged(value, bound=1.0):
    """A trial whose one finding has this value."""
    outcome = "fail" if value > bound else "pass"
    finding = Finding(
        check="error", quantity="x", outcome=outcome, sentence="", value=value, bound=bound
    )
    return Trial((finding,))


@pytest.mark.parametrize("limit", [3e-12, 1e-9, 2.2e-4, 0.9e-3, 1.1e-3, 0.04, 0.7])
@pytest.mark.parametrize("power", [0.5, 1.0, 2.0])
def test_a_threshold_is_found_whatever_the_power_with_which_errors_grow(limit, power):
    trials = []

    def trial(amount):
        trials.append(amount)
        return judged((amount / limit) ** power)

    found = threshold(trial, trial(FIRST))
    assert found.by == "error/x"
    assert limit < found.detected <= CLOSE * limit * (1 + 1e-12)
    if power == 1.0:
        assert len(trials) <= 8


def test_what_no_finding_fails_up_to_all_of_the_number_is_not_seen():
    assert threshold(lambda amount: judged(0.5), judged(0.5)).detected is None


def test_what_always_fails_is_seen_at_the_least_misreading():
    found = threshold(lambda amount: judged(np.inf), judged(np.inf))
    assert found.detected == pytest.approx(LEAST)


def test_a_trial_above_the_smallest_one_changes_nothing():
    found = Threshold(undetected=1e-4, detected=1e-3, by="error/x")
    found.add(1e-2, judged(100.0))
    assert (found.undetected, found.detected) == (1e-4, 1e-3)


def seen_by_number(label, engine, method, **given):
    instance = discovery.case(label).at(**given)
    specification = Specification(name="test", case=[], levels=4, method=method)
    found = resolution(specification, discovery.engine(engine), instance, truth_of(instance))
    return {entry.number: entry for entry in found.numbers}


def test_a_free_body_shows_its_moments_and_its_spin_and_never_its_mass():
    found = seen_by_number("free-rigid-body", "reference", "splitting-free-body")
    assert found["mass"].smallest is None
    assert found["mass"].reason == "the motion does not depend on it"
    for axis in (1, 2, 3):
        assert found[f"moment of inertia {axis}"].smallest < 1e-6
    assert found["spin"].smallest < 1e-9


def test_two_rigid_spheres_in_pymunk_show_restitution_and_friction_after_their_impact():
    given = {"friction": "1/4", "spins": "0,0,1,0,0,-2", "masses": "1,3", "radii": "1/2,3/4"}
    found = seen_by_number("hard-spheres", "pymunk", "semi-implicit-euler", **given)
    assert found["restitution of the contact"].smallest < 0.01
    assert found["friction of the contact"].smallest < 0.05
    assert found["inertia of body 0"].smallest < 0.05
    assert found["inertia of body 1"].smallest < 0.05


def test_a_method_that_fails_anyway_notices_nothing():
    """Its step is far too large for the order that it claims."""
    instance = discovery.case("pendulum").at()
    engine = discovery.engine("pymunk")
    specification = Specification(name="test", case=[], levels=4, method="semi-implicit-euler")
    truth = truth_of(instance)
    wrong = {name: [value + 0.1 for value in values] for name, values in truth.values.items()}
    found = resolution(specification, engine, instance, replace(truth, values=wrong))
    assert {entry.reason for entry in found.numbers} == {"a finding fails without any misreading"}


def test_a_deviation_that_is_expected_hides_nothing_else():
    """MuJoCo's contact is soft: a block sinks a little, which validation/expected has."""
    found = seen_by_number(
        "newtons-first-law", "mujoco", "implicitfast", member="block", duration="2.25"
    )
    assert found["position"].smallest < 1e-8
    assert found["g of the uniform gravity"].smallest < 1.0


LABELS = [
    "asymmetric-field",
    "two-spheres",
    "pendulum",
    "double-pendulum",
    "rolling",
    "stick-slip",
    "granular-gas",
]


@pytest.mark.parametrize("label", LABELS)
def test_every_number_of_a_scene_can_be_misread_and_changes_the_request(label):
    instance = discovery.case(label).at()
    request = Request(problem=instance.problem, method="", step=instance.problem.interval)
    names = [number.name for number in numbers(instance.scene)]
    assert len(names) == len(set(names)) > 1
    for number in numbers(instance.scene):
        misread = number.misread(request, 1.5)
        assert misread.packed() != request.packed()
        assert number.misread(request, 1.0).packed() == request.packed()


def test_longer_rods_hold_their_bodies_farther_out():
    instance = discovery.case("double-pendulum").at()
    request = Request(problem=instance.problem, method="", step=instance.problem.interval)
    (length,) = [n for n in numbers(instance.scene) if n.name == "length of the rods"]
    longer = length.misread(request, 1.25).problem.scene
    before = instance.scene.bodies.position
    np.testing.assert_allclose(
        np.linalg.norm(np.diff(longer.bodies.position, axis=0)),
        1.25 * np.linalg.norm(np.diff(before, axis=0)),
    )


def test_the_sentence_names_what_is_seen_first_and_what_is_not_with_its_reason():
    found = [
        NumberResolution(number="friction", smallest=0.02, by="error/x"),
        NumberResolution(number="inertia of body 1", reason="it never spins"),
        NumberResolution(number="restitution", smallest=0.003, by="error/x"),
    ]
    given = {"label": "case", "engine": "code", "method": "euler"}
    assert Resolution(numbers=tuple(found), **given).sentence == (
        "Would have noticed: restitution 0.3 %, friction 2 %,"
        " no misreading of inertia of body 1, because it never spins."
    )
    assert Resolution(numbers=(), **given).sentence == ""


@pytest.fixture
def made(monkeypatch):
    """The places that jobs are made for, one after the other; each is done in this process."""
    places = []
    job = module._job

    def noted(specification, instance, truth, place):
        places.append(place)
        return job(specification, instance, truth, place)

    monkeypatch.setattr(module, "_job", noted)
    monkeypatch.setattr(module, "Schedule", lambda workers, seconds: InProcess())
    return places


ASKED = Specification(
    name="test", case=[Entry("harmonic-oscillator")], engines=["rebound"], method="leapfrog"
)
LEAPFROG = ("harmonic-oscillator", "rebound", "leapfrog")


def test_what_was_measured_is_read_from_the_store_while_nothing_has_changed(tmp_path, made):
    store = Store(tmp_path / "store.sqlite")
    first = module.measured(ASKED, store, 1, nothing)
    assert module.measured(ASKED, store, 1, nothing) == first
    assert made == [LEAPFROG]
    assert module.measured(ASKED, store, 1, nothing, use_store=False) == first
    assert made == [LEAPFROG, LEAPFROG]
    module.measured(replace(ASKED, levels=2), store, 1, nothing)
    assert made == [LEAPFROG, LEAPFROG, LEAPFROG]


def test_what_is_finished_stays_when_the_command_is_killed(tmp_path, made):
    store = Store(tmp_path / "store.sqlite")
    both = replace(ASKED, method="", engines=["rebound", "pymunk"])

    def killed(stage, done, total):
        if stage == "resolution" and done == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        module.measured(both, store, 1, killed)
    done = made[0]
    made.clear()
    found = module.measured(both, store, 1, nothing)
    assert len(found) > 1
    assert done not in made
    assert done in {(one.label, one.engine, one.method) for one in found}


def test_a_method_that_could_not_be_measured_says_why_and_is_not_kept(tmp_path, made, monkeypatch):
    def crashes(*arguments):
        return Failure(kind="crash", sentence="the worker process died")

    store = Store(tmp_path / "store.sqlite")
    monkeypatch.setattr(module, "of_method", crashes)
    (found,) = module.measured(ASKED, store, 1, nothing)
    assert found.sentence == (
        "Would have noticed: no misreading of any number, because it could not be measured: the"
        " worker process died."
    )
    module.measured(ASKED, store, 1, nothing)
    assert made == [LEAPFROG, LEAPFROG]


def nothing(stage, done, total):
    """Tells nobody of the progress."""


def test_only_checks_that_read_plain_runs_count():
    instance = discovery.case("free-rigid-body").at()
    specification = Specification(name="test", case=[], levels=3, method="rk4")
    (task,) = plan.tasks(
        specification, instance, (), discovery.engine("mujoco"), truth_of(instance), ""
    )
    from refdem.planning.resolution import checks_of_plain_runs

    names = checks_of_plain_runs(task)
    assert {"error", "energy"} <= set(names)
    assert not {"symmetry", "reversal", "determinism"} & set(names)


def test_the_levels_of_a_case_s_entry_are_those_that_are_measured(tmp_path, made):
    store = Store(tmp_path / "store.sqlite")
    entry = Entry("harmonic-oscillator", levels=2)
    coarse = replace(ASKED, case=[entry])
    assert module.measured(coarse, store, 1, nothing) == module.measured(
        replace(ASKED, levels=2), store, 1, nothing, use_store=False
    )
    # Kept for two levels, and not for four.
    assert module.measured(ASKED, store, 1, nothing) != module.measured(coarse, store, 1, nothing)
    assert made == [LEAPFROG] * 3
