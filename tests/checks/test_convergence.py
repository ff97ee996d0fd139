"""Convergence where there is no truth: Verlet's own formula converges with order 2, and a
first-order error in it is seen.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.engine import Method
from refdem.core.refinement import levels
from refdem.core.trajectory import Cost, Trajectory

SECOND = Method(name="second", summary="", control="step", order=2)


def blind(method=SECOND):
    """The harmonic oscillator (m = k = x0 = 1) whose truth nobody knows."""
    instance = discovery.case("harmonic-oscillator").at()
    return Subject(
        instance, method, levels(instance, method, 4, 1e9), None, truth_reason="withheld"
    )


def verlet(subject, step, first_order=0.0):
    """What velocity Verlet gives: x = cos(w t) with sin(w h/2) = h/2 (Hairer, Lubich and Wanner
    2006, section I.5).
    """
    t = subject.instance.times
    rate = 2 * np.arcsin(step / 2) / step
    position, velocity = np.zeros((2, len(t), 1, 3))
    position[:, 0, 0] = np.cos(rate * t) + first_order * step * t
    velocity[:, 0, 0] = -np.sin(rate * t) * np.sqrt(1 - step**2 / 4)
    return CompletedRun(Trajectory.of_points(t, position, velocity), Cost(seconds=0.0))


def judged(subject, first_order=0.0):
    check = discovery.check("convergence")
    assert check.applies(subject) is None
    (finding,) = check.judge(
        subject, {v: verlet(subject, v.level, first_order) for v in check.needs(subject)}
    )
    return finding


def test_a_method_of_order_two_is_seen_to_have_it():
    finding = judged(blind())
    assert finding.outcome == "pass"
    assert finding.order_seen == pytest.approx(2.0, abs=0.02)


def test_an_error_of_first_order_is_seen_without_truth():
    assert judged(blind(), first_order=0.05).outcome == "fail"


def test_a_claim_that_is_too_high_is_seen():
    subject = blind()
    finding = judged(replace(subject, method=replace(SECOND, order=3)))
    assert finding.outcome == "fail"
    assert finding.value == pytest.approx(1.0, abs=0.02)


def test_changes_that_are_round_off_show_no_order_and_lack_none():
    subject = blind()
    check = discovery.check("convergence")
    runs = {v: verlet(subject, 1e-9) for v in check.needs(subject)}
    assert check.judge(subject, runs)[0].outcome == "pass"


def test_runs_that_differ_by_more_than_a_tenth_of_the_scale_decide_nothing():
    assert judged(blind(), first_order=30.0).outcome == "undecided"


def test_it_leaves_to_the_order_what_truth_can_show():
    subject = blind()
    count = len(subject.instance.times)
    certified = type("Truth", (), {"until": count})()
    check = discovery.check("convergence")
    assert "truth is certified to the end" in check.applies(replace(subject, truth=certified))
    assert check.applies(replace(subject, truth=type("Truth", (), {"until": count - 1})())) is None
    assert "3 are needed" in check.applies(replace(subject, levels=subject.levels[:2]))
    assert "not a fixed step" in check.applies(blind_exact())


def blind_exact():
    return blind(Method(name="exact", summary="", control="exact"))
