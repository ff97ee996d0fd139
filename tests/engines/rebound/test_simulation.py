"""Why the adapter gives ias15 a smaller epsilon where springs swing: REBOUND ends the iteration of
a step early, and by chance.

The simulations are REBOUND's own, nothing of refdem is in them. A step of ias15 is implicit; it is
iterated until the last coefficient b6 of its series no longer changes, or changes by more than it
did the time before (Rein and Spiegel 2015, section 2.3). A change that is small by chance in one
iteration is followed by a larger one, so that the step is left while its other coefficients are
still wrong. Which steps that befalls hangs on the last bits, so that many runs are looked at.
"""

from math import cos

import numpy as np
import pytest
import rebound

from refdem.core import discovery
from refdem.engines.rebound import ENGINE
from refdem.engines.rebound.simulation import SWINGING
from refdem.planning.in_process import record_of, task_of, truth_of

STAGES = 7
"""Evaluations of the force in an iteration (and one at the start of a step)."""
STIFFNESS = 1.0
DAMPING = 0.2
AMPLITUDE = 0.2
FREQUENCIES = (0.3, 0.5)
END = 5.0
SAMPLES = 16
RUNS = 64


def state_at(t):
    """x and v of x'' + c x' + k x = sum f cos(w t), x(0) = 1, v(0) = 0, in closed form."""
    # The response to f cos(w t) is the real part of f e^(i w t)/(k - w^2 + i c w).
    steady = [
        AMPLITUDE / (STIFFNESS - w**2 + 1j * DAMPING * w) * np.exp(1j * w * np.array([0.0, t]))
        for w in FREQUENCIES
    ]
    place = sum(wave.real for wave in steady)
    rate = sum((1j * w * wave).real for w, wave in zip(FREQUENCIES, steady, strict=True))
    # What is left of the start swings freely: e^(-c t/2) (a cos(W t) + b sin(W t)).
    decay = DAMPING / 2
    swing = np.sqrt(STIFFNESS - decay**2)
    a = 1.0 - place[0]
    b = (0.0 - rate[0] + decay * a) / swing
    c = np.cos(swing * t)
    s = np.sin(swing * t)
    fades = np.exp(-decay * t)
    free = fades * (a * c + b * s)
    free_rate = fades * (swing * (b * c - a * s)) - decay * free
    return np.array([free + place[1], free_rate + rate[1]])


def steps(start, epsilon):
    """Of each step to END, from sample to sample: its iterations, and how far it moves the error
    of (x, v).
    """
    sim = rebound.Simulation()
    sim.integrator = "ias15"
    sim.integrator.adaptive_mode = "global"
    sim.integrator.epsilon = epsilon
    sim.gravity = "none"
    sim.dt = END / SAMPLES / 256
    sim.add(m=1.0, x=start)
    calls = []
    found = []
    errors = [np.zeros(2)]

    def force(_):
        body = sim.particles[0]
        calls.append(sim.t)
        body.ax += -STIFFNESS * body.x - DAMPING * body.vx
        body.ax += sum(AMPLITUDE * cos(w * sim.t) for w in FREQUENCIES)

    def told(_):
        body = sim.particles[0]
        error = np.array([body.x, body.vx]) - state_at(sim.t)
        if len(calls) > STAGES:
            found.append(((len(calls) - 1) // STAGES, np.abs(error - errors[-1]).max()))
        errors.append(error)
        calls.clear()

    sim.additional_forces = force
    sim.force_is_velocity_dependent = 1
    sim.heartbeat = told
    for k in range(1, SAMPLES + 1):
        sim.integrate(k * END / SAMPLES)
    return found


def worst_steps(epsilon):
    """The step with the largest error of each of RUNS runs, whose starts are a unit in the last
    place apart: that alone moves x by less than 2e-14.
    """
    starts = 1.0 + np.arange(RUNS) * 2.0**-52
    return [max(steps(start, epsilon), key=lambda step: step[1]) for start in starts]


def test_some_runs_have_a_step_whose_iteration_ends_early_and_that_is_off():
    """Seen: 11 of 64, off by 2.3e-13 to 2.6e-13; the others by 2e-15 at most."""
    off = [step for step in worst_steps(1e-9) if step[1] > 1e-13]
    assert len(off) >= 1
    assert {iterations for iterations, _ in off} == {3}


def test_at_the_epsilon_of_the_adapter_none_has():
    assert max(error for _, error in worst_steps(SWINGING)) < 2e-14


def test_a_setting_that_failed_for_that_passes():
    """1.2e-13 off at the default epsilon, beyond a bound of 3.9e-14, on the machine that saw it."""
    instance = discovery.case("quadratic-response").at(eps="0", duration="5", samples="16")
    record = record_of(task_of(ENGINE, "ias15", instance, truth_of(instance), 4))
    assert {finding.outcome for finding in record.findings} == {"pass"}


@pytest.mark.parametrize("t", [0.0, 1.25, 5.0])
def test_the_closed_form_obeys_the_equation(t):
    h = 2.0**-10
    before, now, after = (state_at(t + shift) for shift in (-h, 0.0, h))
    pull = sum(AMPLITUDE * cos(w * t) for w in FREQUENCIES)
    assert (after[0] - before[0]) / (2 * h) == pytest.approx(now[1], abs=1e-6)
    acceleration = pull - DAMPING * now[1] - STIFFNESS * now[0]
    assert (after[1] - before[1]) / (2 * h) == pytest.approx(acceleration, abs=1e-6)


def test_the_closed_form_starts_at_rest_at_one():
    assert state_at(0.0) == pytest.approx([1.0, 0.0], abs=1e-15)


def test_the_default_step_is_that_of_the_installed_engine():
    assert rebound.Simulation().dt == ENGINE.default_step
