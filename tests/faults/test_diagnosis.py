"""Diagnosis by twins: a code with a known fault is told by it, a right one by its integrator, an unknown one by nothing."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from refdem.cli.app import app
from refdem.cli.diagnose import parts_of
from refdem.core import discovery
from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.errors import UsageError
from refdem.faults.catalogue import chosen
from refdem.faults.transparent import Transparent
from refdem.faults.twins import diagnosis, first_part


def asked(case, method, halvings, **given):
    instance = discovery.case(case).at(**given)
    return instance, Request(problem=instance.problem, method=method, step=float(instance.times[1]) / 2**halvings)


SHORT = {"duration": "2", "samples": "8"}


@pytest.mark.parametrize(
    ("fault", "case", "method", "given"),
    [
        ("no-gyroscopic-term", "free-rigid-body", "rk4", SHORT),
        ("velocity-not-held", "pendulum", "verlet", SHORT),
        ("damping-doubled", "two-spheres", "verlet", {"samples": "16"}),
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


def leapfrog(request, late=0.0):
    """A code of another hand: the oscillator (m = k = 1) by positions alone, x(n+1) = 2 x(n) - x(n-1) - h^2 x(n) (Stoermer)."""
    h, count = request.step, request.stride * (len(request.problem.times) - 1)
    x = [1.0, 1.0 - h * h / 2]
    while len(x) < count + 2:
        x.append((2 - h * h) * x[-1] - x[-2])
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
    assert "(as does inertia-of-a-sphere)" in said


def test_a_right_code_of_another_hand_is_told_by_its_integrator():
    instance, request = asked("harmonic-oscillator", "stoermer", 2, **SHORT)
    found = diagnosis(instance, request, leapfrog(request)).explanation
    assert (found.fault, found.method) == (None, "verlet")
    assert found.digits > 11


def test_a_fault_that_nobody_knows_is_not_given_a_name():
    instance, request = asked("harmonic-oscillator", "stoermer", 2, **SHORT)
    found = diagnosis(instance, request, leapfrog(request, late=0.05))
    assert found.explanation is None
    assert found.sentence().startswith("behaves as no twin: the nearest of ")


def test_only_the_first_part_of_a_long_run_is_looked_at():
    _, request = asked("harmonic-oscillator", "verlet", 6)
    assert len(first_part(request).problem.times) == 10
    exact = replace(request, step=None)
    assert first_part(exact) is exact


@pytest.mark.parametrize(
    ("record", "parts"),
    [
        ("pendulum/mujoco/euler", ("pendulum", "mujoco", "euler")),
        ("pendulum[theta0=2 mass=1/2]/mujoco/euler/error/x", ("pendulum[theta0=2 mass=1/2]", "mujoco", "euler")),
    ],
)
def test_a_record_is_named_as_its_findings_are(record, parts):
    assert parts_of(record) == parts


@pytest.mark.parametrize("record", ["pendulum", "pendulum/mujoco", "/mujoco/euler", "pendulum//euler"])
def test_a_record_that_is_no_name_is_refused(record):
    with pytest.raises(UsageError, match="expected something like"):
        parts_of(record)


def test_the_command_says_it_in_a_sentence_and_as_json():
    done = CliRunner().invoke(app, ["diagnose", "harmonic-oscillator[duration=4 samples=16]/reference/velocity-verlet", "--json"])
    assert done.exit_code == 0, done.output
    said = json.loads(done.stdout)
    assert (said["explained_by"]["fault"], said["explained_by"]["method"]) == (None, "verlet")
    assert said["explained_by"]["digits"] > 11
    assert "behaves as verlet without any fault" in said["sentence"]


def test_twins_leave_the_transparent_engine_as_it_was():
    instance, request = asked("harmonic-oscillator", "verlet", 2, **SHORT)
    before, _ = Transparent().run(request)
    diagnosis(instance, request, before)
    after, _ = Transparent().run(request)
    np.testing.assert_array_equal(before.position, after.position)
