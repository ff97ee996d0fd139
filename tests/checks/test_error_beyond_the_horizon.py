"""What the last halvings of the step leave bounds the error also where the bound on the state has
passed its horizon.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.check import CompletedRun
from refdem.core.refinement import scored
from refdem.core.variant import Variant
from refdem.planning import plan
from refdem.planning.in_process import truth_of
from refdem.planning.specification import Specification

SPECIFICATION = Specification(name="test", case=[], levels=3, method="velocity-verlet")
STIFF = {
    **{"masses": "1,3", "radii": "1/2,3/4", "angle": "1/2", "spins": "0,0,1,0,0,-2"},
    **{"damping": "1", "friction": "1/4", "tangential_stiffness": "96"},
}


def sound(run):
    return run


def spun_too_far(run):
    """Two per cent of the spin are lost in the second half, at every step alike."""
    late = (run.t > run.t[-1] / 2)[:, None, None]
    return replace(run, omega=np.where(late, 0.98, 1.0) * run.omega)


@pytest.mark.parametrize(
    ("fault", "failed"), [(sound, set()), (spun_too_far, {"omega1.z", "omega2.z"})]
)
def test_an_error_that_no_step_removes_is_seen_beyond_the_horizon_of_a_method_of_first_order(
    fault, failed
):
    instance = discovery.case("two-spheres").at(**STIFF)
    truth = truth_of(instance)
    (task,) = plan.tasks(SPECIFICATION, instance, ("error",), discovery.engine("reference"), truth)
    method = replace(task.subject.method, order_with={"contact": 1})
    subject = replace(task.subject, method=method, truth=truth)
    assert scored(subject.bound(subject.levels[-1])) < len(instance.times) / 2
    runs = {}
    for variant in subject.plain:
        run, cost = task.engine.run(plan.request(task, variant))
        runs[variant] = CompletedRun(fault(run), cost)
    found = discovery.check("error").judge(subject, runs)
    assert {finding.quantity for finding in found if finding.outcome == "fail"} == failed


STRADDLED = {
    **{
        "mass": "0.965",
        "stiffness": "1.04",
        "friction_force": "0.114",
        "x0": "1.34",
        "v0": "0.362",
    },
    **{"duration": "11.56", "samples": "16"},
}


def rubbed(instance, step):
    """Velocity Verlet for the Coulomb oscillator; friction takes as much of the velocity as there
    is, at each half kick.
    """
    slider, spring = instance.scene.elements
    if slider.kind == "spring":
        slider, spring = spring, slider
    mass = float(instance.scene.bodies.mass[0])
    rub = slider.friction * slider.normal_force / mass * step / 2
    pull = spring.stiffness / mass * step / 2
    x = float(instance.scene.bodies.position[0, 0])
    v = float(instance.scene.bodies.velocity[0, 0])
    states = [(x, v)]
    for _ in instance.times[1:]:
        for _ in range(round(instance.problem.interval / step)):
            for half in (0, 1):
                v -= pull * x
                if abs(v) <= rub:
                    v = 0.0
                else:
                    v = v - np.copysign(rub, v)
                if half:
                    x = x
                else:
                    x = x + step * v
        states.append((x, v))
    return np.array(states)


def test_a_kink_shortly_before_the_end_of_a_long_step_is_met_alike_by_all_its_halves():
    """The velocity crosses zero so near the end of such a step that three halvings leave the same
    error.
    """
    instance = discovery.case("coulomb-oscillator").at(**STRADDLED)
    truth = truth_of(instance)
    specification = Specification(name="test", case=[], levels=4, most_steps=2e4)
    engine = discovery.engine("reference")
    task = next(
        t
        for t in plan.tasks(specification, instance, ("error",), engine, truth)
        if t.unsupported is None
    )
    method = replace(
        task.subject.method,
        control="step",
        order=2,
        order_with={"friction": 1},
        locates_events=False,
    )
    levels = tuple(instance.problem.interval / 2.0**n for n in (7, 8, 9, 10))
    subject = replace(task.subject, method=method, levels=levels, truth=truth)
    runs = {}
    for variant in subject.plain:
        run, cost = task.engine.run(plan.request(task, Variant(0.0)))
        position = np.array(run.position)
        velocity = np.array(run.velocity)
        position[:, 0, 0], velocity[:, 0, 0] = rubbed(instance, variant.level).T
        runs[variant] = CompletedRun(replace(run, position=position, velocity=velocity), cost)
    found = discovery.check("error").judge(subject, runs)
    assert {finding.quantity: finding.outcome for finding in found} == {"x": "pass", "v": "pass"}
