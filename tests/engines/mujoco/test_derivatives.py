"""Derivatives by `mjd_transitionFD`, chained: right at random settings, and seen where they are
wrong; and which campaigns ask for them.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.mujoco import derivatives
from refdem.errors import UnsupportedError
from refdem.planning import plan
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.planning.specification import Entry, Specification
from tests.random_settings import SETTINGS, first_accepted, settings, shortened

ENGINE = discovery.engine("mujoco")
METHOD = ENGINE.method("euler-derivatives")
SMOOTH = (
    "double-pendulum",
    "driven-oscillator",
    "duffing",
    "free-rigid-body",
    "harmonic-oscillator",
    "heavy-top",
    "newtons-first-law",
    "pendulum",
    "two-body-orbit",
    "van-der-pol",
    "viscous-oscillator",
    "whirling-shaft",
)
PENDULUM = {"theta0": "2", "thetadot0": "1/2", "duration": "1", "samples": "8"}


def found(instance, levels=3):
    """The findings of the check by quantity."""
    task = task_of(ENGINE, METHOD.name, instance, truth_of(instance), levels, ["gradient"])
    return {finding.quantity: finding for finding in record_of(task).findings}


def drawn(case, number):
    """A random setting of a case that the method supports."""

    def made(rng):
        instance = shortened(case, settings(rng, case))
        if reason := ENGINE.unsupported(instance.problem, METHOD):
            raise UnsupportedError(reason)
        return instance

    return first_accepted(case, number, made)


@pytest.mark.parametrize("case", SMOOTH)
@pytest.mark.parametrize("number", range(SETTINGS))
def test_derivatives_of_smooth_motions_are_right_at_random_settings(case, number):
    findings = found(drawn(case, number))
    assert findings["matrix"].outcome == "pass", findings["matrix"].sentence
    assert all(finding.outcome == "pass" for finding in findings.values())


def test_the_matrix_of_a_free_fall_is_that_of_its_formula():
    # r = r0 + v0 t, so that dr/dv0 = t and dv/dv0 = 1; the axes do not mix.
    instance = discovery.case("newtons-first-law").at()
    keys = ("scene.bodies.0.position.0", "scene.bodies.0.velocity.1")
    request = Request(
        problem=instance.problem,
        method=METHOD.name,
        step=float(instance.times[1]),
        sensitivities=keys,
    )
    run, _ = ENGINE.run(request)
    by_place = np.zeros((len(run.t), 13))
    by_place[:, 0] = 1.0
    by_speed = np.zeros((len(run.t), 13))
    by_speed[:, 1] = run.t
    by_speed[:, 4] = 1.0
    np.testing.assert_allclose(run.derivatives[keys[0]][:, 0], by_place, atol=1e-8)
    np.testing.assert_allclose(run.derivatives[keys[1]][:, 0], by_speed, atol=1e-8)


def test_states_are_those_of_the_run_without_derivatives():
    instance = discovery.case("pendulum").at(**PENDULUM)
    asked = Request(problem=instance.problem, method="euler", step=float(instance.times[1]) / 4)
    plain, _ = ENGINE.run(asked)
    keys = ("scene.bodies.0.velocity.0",)
    more = Request(problem=asked.problem, method=METHOD.name, step=asked.step, sensitivities=keys)
    differentiated, _ = ENGINE.run(more)
    assert np.array_equal(differentiated.position, plain.position)
    assert set(differentiated.derivatives) == set(keys)


WRONG = {
    "transposed": lambda of_step, product: of_step.T @ product,
    "the matrix of the last step alone": lambda of_step, product: of_step,
}


@pytest.mark.parametrize("error", WRONG)
def test_a_wrong_product_of_matrices_fails(monkeypatch, error):
    monkeypatch.setattr(derivatives, "after_step", WRONG[error])
    assert found(discovery.case("pendulum").at(**PENDULUM))["matrix"].outcome == "fail"


KEY = "scene.bodies.0.velocity.0"


def own_error():
    """The largest difference [1/s, 1] of derivatives from central differences of the runs."""
    problem = discovery.case("pendulum").at(**PENDULUM).problem
    step = problem.interval / 16

    def run(change):
        """The run whose start is faster by `change` [m/s] along x."""
        velocity = problem.scene.bodies.velocity + np.array([change, 0.0, 0.0])
        moved = Motion(problem.scene.with_state(velocity=velocity), problem.times)
        asked = Request(problem=moved, method=METHOD.name, step=step, sensitivities=(KEY,))
        return ENGINE.run(asked)[0]

    change = 2.0**-14
    difference = (run(change).position - run(-change).position) / (2 * change)
    return np.max(np.abs(run(0.0).derivatives[KEY][..., :3] - difference))


def without_last(right):
    """`chained` without the matrix of the last step before each sample."""

    def chained(mujoco, model, data, request, rows):
        products = right(mujoco, model, data, request, rows)
        data.qpos[:] = rows[0, : model.nq]
        data.qvel[:] = rows[0, model.nq : -1]
        last = np.empty((2 * model.nv, 2 * model.nv))
        for sample in range(1, len(rows)):
            for _ in range(request.stride):
                mujoco.mjd_transitionFD(model, data, 2.0**-17, True, last, None, None, None)
                mujoco.mj_step(model, data)
            products[sample] = np.linalg.solve(last, products[sample])
        return products

    return chained


def test_derivatives_are_those_of_the_steps_themselves(monkeypatch):
    assert own_error() < 1e-8
    # A step of 1/128 s is what lacks here.
    monkeypatch.setattr(derivatives, "chained", without_last(derivatives.chained))
    assert own_error() > 1e-3


def test_a_last_step_that_is_missing_is_within_the_error_of_a_method_of_order_1(monkeypatch):
    monkeypatch.setattr(derivatives, "chained", without_last(derivatives.chained))
    findings = found(discovery.case("pendulum").at(**PENDULUM))
    assert findings["order"].order_seen == pytest.approx(1.0, abs=0.1)


def test_contact_and_friction_are_refused():
    for case in ("block-on-slope", "coulomb-oscillator", "rolling"):
        problem = discovery.case(case).at().problem
        assert "derivatives" in ENGINE.unsupported(problem, METHOD)


def test_campaigns_run_the_method_by_its_name_only():
    def planned(**given):
        """The methods that a campaign of the pendulum runs."""
        specification = Specification(name="test", case=[Entry("pendulum")], **given)
        ((instance, _),) = plan.instances(specification)
        return {
            subject.method.name for subject, _ in plan.subjects(specification, instance, ENGINE)
        }

    assert METHOD.name not in planned()
    assert METHOD.name not in planned(as_shipped=True)
    assert planned(method=METHOD.name) == {METHOD.name}
