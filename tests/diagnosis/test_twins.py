"""Diagnosis by twins: a code with a known fault is told by it, a right one by its integrator, an
unknown one by nothing.
"""

import json
import re
from dataclasses import replace
from math import inf

import numpy as np
import pytest
from typer.testing import CliRunner

from refdem.cli.app import app
from refdem.cli.diagnose import parts_of
from refdem.core import discovery
from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.diagnosis.scaled_faults import continued
from refdem.diagnosis.twins import Diagnosis, Twin, diagnosis, first_part
from refdem.errors import UsageError
from refdem.faults.catalogue import chosen
from refdem.faults.transparent import Transparent


def asked(case, method, halvings, **given):
    instance = discovery.case(case).at(**given)
    return instance, Request(
        problem=instance.problem, method=method, step=float(instance.times[1]) / 2**halvings
    )


SHORT = {"duration": "2", "samples": "8"}


@pytest.mark.parametrize(
    ("fault", "case", "method", "given"),
    [
        ("no-gyroscopic-term", "free-rigid-body", "rk4", SHORT),
        ("velocity-not-held", "pendulum", "verlet", SHORT),
        ("damping-doubled", "two-spheres", "verlet", {"damping": "1", "samples": "16"}),
    ],
)
def test_a_code_with_a_known_fault_is_told_by_it(fault, case, method, given):
    instance, request = asked(case, method, 1, **given)
    (planted,) = chosen([fault])
    run, _ = planted.carrier().run(request)
    found = diagnosis(instance, request, run)
    assert found.explanation.fault is planted
    assert found.explanation.digits > 11
    assert f"behaves as {fault}" in found.sentence()


def leapfrog(request, late=0.0, stiffness=1.0):
    """A code of another hand: the oscillator (m = k = 1) by positions alone, x(n+1) = 2 x(n) -
    x(n-1) - h^2 k x(n) (Stoermer).
    """
    h = request.step
    count = request.stride * (len(request.problem.times) - 1)
    x = [1.0, 1.0 - stiffness * h * h / 2]
    while len(x) < count + 2:
        x.append((2 - stiffness * h * h) * x[-1] - x[-2])
    x = np.array(x)
    v = np.concatenate([[0.0], (x[2:] - x[:-2]) / (2 * h)])
    rows = np.arange(0, count + 1, request.stride)
    position, velocity = np.zeros((2, len(rows), 1, 3))
    position[:, 0, 0], velocity[:, 0, 0] = x[rows], v[rows] + late * np.sin(7 * rows * h)
    return Trajectory.of_points(request.problem.times, position, velocity)


def test_faults_that_do_the_same_are_both_named():
    instance, request = asked("free-rigid-body", "rk4", 1, **SHORT)
    run, _ = chosen(["no-gyroscopic-term"])[0].carrier().run(request)
    said = diagnosis(instance, request, run).sentence()
    assert "behaves as no-gyroscopic-term" in said
    assert re.search(
        r"; .*\binertia-of-a-sphere\b.* reproduce the run equally well: it cannot distinguish", said
    )


def test_a_right_code_of_another_hand_is_told_by_its_integrator():
    instance, request = asked("harmonic-oscillator", "stoermer", 2, **SHORT)
    found = diagnosis(instance, request, leapfrog(request)).explanation
    assert (found.fault, found.method) == (None, "verlet")
    assert found.digits > 11


def test_a_fault_that_nobody_knows_is_not_given_a_name():
    instance, request = asked("harmonic-oscillator", "stoermer", 2, **SHORT)
    found = diagnosis(instance, request, leapfrog(request, late=0.05))
    assert found.explanation is None
    assert found.sentence().startswith(
        "no known fault reproduces this run (not a diagnosis); the nearest is "
    )
    assert re.search(
        r", which agrees to \d\.\d digits, a difference of \d\.\de-\d\d of its scale",
        found.sentence(),
    )


@pytest.mark.parametrize("factor", [0.731, 0.9987, 1.0137, 1.37])
def test_the_amplitude_of_a_fault_is_solved_for(factor):
    instance, request = asked("harmonic-oscillator", "stoermer", 2, **SHORT)
    found = diagnosis(instance, request, leapfrog(request, stiffness=factor))
    names = {found.explanation.name, *found.alike}
    assert "spring-stiffness" in names
    (twin,) = (
        twin
        for twin in found.twins
        if twin.name == "spring-stiffness" and twin.method == "verlet" and twin.step == request.step
    )
    assert twin.amplitude == pytest.approx(factor - 1, rel=1e-9)
    assert (
        f"the stiffness of element 0 (spring) is {factor:.6g} times that of the scene"
        in twin.behaviour
    )


def test_an_amplitude_that_changes_with_the_step_is_the_integrators_and_no_fault():
    """Velocities of another definition, off by a part h^2/8 of themselves: at one step a factor, at
    another step another one.
    """
    instance, request = asked("harmonic-oscillator", "stoermer", 2, **SHORT)
    finer = replace(request, step=request.step / 2)

    def averaged(request):
        run = leapfrog(request)
        return replace(run, velocity=run.velocity * (1 - request.step**2 / 8))

    alone = diagnosis(instance, request, averaged(request))
    assert alone.explanation is not None
    both = diagnosis(instance, request, averaged(request), (finer, averaged(finer)))
    assert both.explanation is None
    assert alone.explanation.name in both.refuted


def test_a_fault_is_confirmed_by_a_run_at_another_step():
    instance, request = asked("harmonic-oscillator", "stoermer", 2, **SHORT)
    finer = replace(request, step=request.step / 2)
    runs = [leapfrog(one, stiffness=1.0137) for one in (request, finer)]
    found = diagnosis(instance, request, runs[0], (finer, runs[1]))
    assert "spring-stiffness" in {found.explanation.name, *found.alike}


def twin(name, distance, beside):
    """A twin of a catalogue fault at these distances."""
    (fault,) = chosen([name])
    return Twin(fault=fault, method="verlet", step=0.1, distance=distance, beside=beside)


def test_no_fault_is_named_below_three_digits_or_without_a_sound_twin_beside_it():
    for distance, beside in ((1.0, inf), (1e-5, inf), (2e-3, 10.0), (1e-5, 1e-3), (0.5, 0.6)):
        found = Diagnosis(twins=(twin("percent", distance, beside),), defect=beside)
        assert found.explanation is None, (distance, beside)
        assert "not a diagnosis" in found.sentence()
        assert "inf" not in found.sentence()
    assert Diagnosis(twins=(twin("percent", 1e-5, 1e-1),), defect=0.1).explanation.name == "percent"


def fitted(name, amplitude, distance, beside=1.0):
    """A twin of a catalogue fault at a fitted amplitude."""
    (fault,) = chosen([name])
    scaled = continued(fault)
    return replace(twin(name, distance, beside), scaled=scaled, amplitude=amplitude)


@pytest.mark.parametrize(
    "name", ["impact-friction-unlimited", "kick-reversed", "velocity-not-held"]
)
@pytest.mark.parametrize("amplitude", [6.125, 0.37, -3.2, 1.01])
def test_an_odd_amplitude_that_agrees_to_few_digits_explains_nothing(name, amplitude):
    for distance in (9e-4, 1e-4, 2e-6):
        found = Diagnosis(twins=(fitted(name, amplitude, distance),), defect=1.0)
        assert found.explanation is None
        assert found.sentence().startswith(
            "no known fault reproduces this run (not a diagnosis); the nearest is "
        )
    found = Diagnosis(twins=(fitted(name, amplitude, 1e-9),), defect=1.0)
    assert found.explanation.amplitude == amplitude


@pytest.mark.parametrize("amplitude", [1.0, -1.0, 0.5, 2.0, 1.0004])
def test_a_simple_amplitude_is_named_at_three_digits(amplitude):
    found = Diagnosis(twins=(fitted("kick-reversed", amplitude, 5e-4),), defect=1.0)
    assert found.explanation.name == "kick-reversed"


def test_all_faults_that_explain_a_run_equally_are_named_as_equals():
    names = ["percent", "kick-reversed", "impact-friction-unlimited", "damping-doubled"]
    twins = tuple(twin(name, 1e-12 * (n + 1), 1.0) for n, name in enumerate(names))
    found = Diagnosis(twins=twins, defect=1.0)
    assert {found.explanation.name, *found.alike} == set(names)
    assert all(name in found.sentence() for name in names)
    assert "it cannot distinguish them" in found.sentence()


def test_a_search_that_runs_out_of_time_says_so():
    instance, request = asked("harmonic-oscillator", "stoermer", 2, **SHORT)
    found = diagnosis(instance, request, leapfrog(request, late=0.05), seconds=1e-6)
    assert found.explanation is None
    assert {twin.name for twin in found.twins} == {""}
    assert (
        "; the search stopped at its time limit of 1e-06 s before all known faults were tried"
        in found.sentence()
    )
    whole = diagnosis(instance, request, leapfrog(request))
    assert "the search stopped" not in whole.sentence()


def test_a_scene_that_no_twin_can_run_is_said_to_be_one():
    assert (
        Diagnosis(twins=(), defect=inf).sentence()
        == "cannot be diagnosed: the engine with known faults does not support this scene"
    )


def test_only_the_first_part_of_a_long_run_is_looked_at():
    _, request = asked("harmonic-oscillator", "verlet", 6)
    assert len(first_part(request).problem.times) == 10
    exact = replace(request, step=None)
    assert first_part(exact) is exact


@pytest.mark.parametrize(
    ("record", "parts"),
    [
        ("pendulum/mujoco/euler", ("pendulum", "mujoco", "euler")),
        (
            "pendulum[theta0=2 mass=1/2]/mujoco/euler/error/x",
            ("pendulum[theta0=2 mass=1/2]", "mujoco", "euler"),
        ),
    ],
)
def test_a_record_is_named_as_its_findings_are(record, parts):
    assert parts_of(record) == parts


@pytest.mark.parametrize(
    "record", ["pendulum", "pendulum/mujoco", "/mujoco/euler", "pendulum//euler"]
)
def test_a_record_that_is_no_name_is_refused(record):
    with pytest.raises(UsageError, match="expected a name such as"):
        parts_of(record)


def test_the_command_says_it_in_a_sentence_and_as_json():
    done = CliRunner().invoke(
        app,
        [
            "diagnose",
            "harmonic-oscillator[duration=4 samples=16]/reference/velocity-verlet",
            "--json",
        ],
    )
    assert done.exit_code == 0, done.output
    said = json.loads(done.stdout)
    assert (said["explained_by"]["fault"], said["explained_by"]["method"]) == (None, "verlet")
    assert said["explained_by"]["digits"] > 11
    assert "behaves as verlet without a fault" in said["sentence"]


def test_twins_leave_the_transparent_engine_as_it_was():
    instance, request = asked("harmonic-oscillator", "verlet", 2, **SHORT)
    before, _ = Transparent().run(request)
    diagnosis(instance, request, before)
    after, _ = Transparent().run(request)
    np.testing.assert_array_equal(before.position, after.position)
