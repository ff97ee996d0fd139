"""Apsides: Laplace's vector and Fradkin's tensor are those of the ellipse, stay for 1e4 orbits, and
see an ellipse that turns.
"""

import re
from dataclasses import replace

import numpy as np
import pytest

from refdem.checks.apsides import fradkin, laplace, turned
from refdem.core import discovery
from refdem.engines.reference import ENGINE
from refdem.execution.worker import no_truth
from refdem.planning.in_process import record_of, task_of

ORBITS = 10_000


def precessing(rate):
    """The whole orbit is turned by `rate` [rad/s] times t: distance, speed, energy and angular
    momentum are those of truth.
    """

    def fault(run, level):
        c = np.cos(rate * run.t)[:, None]
        s = np.sin(rate * run.t)[:, None]
        turn = [
            np.stack(
                [c * a[..., 0] - s * a[..., 1], s * a[..., 0] + c * a[..., 1], a[..., 2]], axis=-1
            )
            for a in (run.position, run.velocity)
        ]
        return replace(run, position=turn[0], velocity=turn[1])

    return fault


def quick(factor):
    """Every velocity is too large by a factor."""
    return lambda run, level: replace(
        run, velocity=run.velocity * np.where(run.t > 0, factor, 1.0)[:, None, None]
    )


@pytest.mark.parametrize(
    ("quantity", "given"),
    [("laplace", {}), ("laplace", {"eccentricity": "0.9"}), ("fradkin", {"stiffness": "2"})],
)
@pytest.mark.parametrize(
    ("method", "fault"),
    [("exact", precessing(1e-10)), ("exact", quick(1 + 1e-10)), ("fourth", precessing(1e-2))],
)
def test_an_ellipse_that_turns_or_swells_is_seen(judge, quantity, given, method, fault):
    assert judge("apsides", "two-body-orbit", method, **given)[quantity].outcome == "pass"
    spoiled = judge("apsides", "two-body-orbit", method, fault, **given)[quantity]
    assert spoiled.outcome == "fail"
    assert spoiled.margin < 0


def test_an_orbit_that_turns_keeps_its_energy_and_its_angular_momentum(judge):
    """What these two checks cannot see."""
    for check in ("energy", "angular-momentum"):
        found = judge(check, "two-body-orbit", "exact", precessing(1e-12))
        assert {f.outcome for f in found.values()} == {"pass"}
    assert (
        judge("apsides", "two-body-orbit", "exact", precessing(1e-10))["laplace"].outcome == "fail"
    )


def test_vector_and_tensor_are_those_of_the_ellipse():
    anomaly = np.linspace(0, 6, 25)
    e = 0.6
    gm = 2.5
    r = np.stack([np.cos(anomaly) - e, 0.8 * np.sin(anomaly), 0 * anomaly], axis=1)
    v = (
        np.sqrt(gm)
        * np.stack([-np.sin(anomaly), 0.8 * np.cos(anomaly), 0 * anomaly], axis=1)
        / (1 - e * np.cos(anomaly))[:, None]
    )
    assert laplace(r, v, gm) == pytest.approx(np.tile([e, 0, 0], (25, 1)), abs=1e-14)
    place = r + np.array([e, 0, 0])
    rate = np.sqrt(3) * np.stack([-np.sin(anomaly), 0.8 * np.cos(anomaly), 0 * anomaly], axis=1)
    tensor = fradkin(place, rate, 2.0, 6.0)
    assert tensor == pytest.approx(np.tile(np.diag([1, 0.64, 0]) / 1.64, (25, 1, 1)), abs=1e-14)
    quarter = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    assert turned(np.array([[0.5, 0, 0], [0, 0.5, 0]])) == pytest.approx(np.pi / 2)
    assert turned(np.stack([tensor[0], quarter @ tensor[0] @ quarter.T])) == pytest.approx(
        np.pi / 2
    )


def judged(method, orbits, **given):
    """The finding after so many orbits, without any truth, the angle by which the apsides have
    turned, and the step [s].
    """
    period = float(discovery.case("two-body-orbit").at(**given).truth().scalars()["period"].mid)
    instance = discovery.case("two-body-orbit").at(
        **given, duration=repr(orbits * period), samples="64"
    )
    task = task_of(ENGINE, method, instance, no_truth("not asked for"), 3, ("apsides",))
    (found,) = record_of(task).findings
    return (
        found,
        float(re.search(r"precess by (\S+) rad", found.sentence)[1]),
        task.subject.levels[-1],
    )


@pytest.mark.parametrize(
    "given", [{"eccentricity": e} for e in ("0", "0.5", "0.9", "0.99")] + [{"stiffness": "2"}]
)
def test_over_ten_thousand_orbits_the_apsides_of_the_reference_do_not_turn(given):
    found, angle, _ = judged(
        "exact-harmonic" if "stiffness" in given else "exact-kepler", ORBITS, **given
    )
    assert found.outcome == "pass"
    assert found.value < 1e-12
    assert given.get("eccentricity") == "0" or angle < 1e-12


def test_what_a_method_turns_the_apsides_by_grows_as_orbits_and_the_square_of_the_step():
    turns = [
        (angle / orbits / h**2, h)
        for orbits in (10, 100)
        for _, angle, h in [judged("velocity-verlet", orbits)]
    ]
    assert turns[0][1] > 1.5 * turns[1][1]
    assert turns[1][0] == pytest.approx(turns[0][0], rel=0.05)  # angles are told to two digits
    assert turns[0][0] > 0.1


@pytest.mark.parametrize(
    ("case", "given"),
    [("pendulum", {}), ("harmonic-oscillator", {}), ("two-spheres", {"damping": "1"})],
)
def test_what_has_no_apsides_is_left_out(case, given):
    task = task_of(
        ENGINE,
        ENGINE.best(discovery.case(case).at(**given).problem).name,
        discovery.case(case).at(**given),
        no_truth(""),
        2,
    )
    assert "apsides" not in {check.name for check in task.checks}
