"""Runs made from truth itself, so that checks are tested without any solver or engine."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.engine import Method
from refdem.core.refinement import levels
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.variant import Variant
from refdem.truth.sampled import sampled
from tests.handmade import all_runs

METHODS = {
    "exact": Method(
        name="exact",
        summary="",
        control="exact",
        reversible=True,
        conserves=frozenset({"energy", "angular-momentum"}),
    ),
    "first": Method(name="first", summary="", control="step", order=1),
    "second": Method(name="second", summary="", control="step", order=2, symplectic=True),
    "fourth": Method(name="fourth", summary="", control="step", order=4),
}
_TRUTHS: dict[str, tuple] = {}


def subject(case: str, method: str, **given: str) -> Subject:
    """The subject of a case in one of METHODS, with its certified truth."""
    key = case + str(sorted(given.items()))
    if key not in _TRUTHS:
        instance = discovery.case(case).at(**given)
        _TRUTHS[key] = instance, sampled(instance.truth(), instance.times.tolist())
    instance, truth = _TRUTHS[key]
    return Subject(instance, METHODS[method], levels(instance, METHODS[method], 4, 1e9), truth)


def true_run(of: Subject, until: int | None = None) -> Trajectory:
    """The trajectory that truth itself is."""
    truth = of.truth
    bodies = of.instance.scene.bodies
    count = len(of.instance.times)
    n = len(bodies)
    columns = {
        name: np.repeat(getattr(bodies, name)[None], count, axis=0)
        for name in ("position", "velocity", "attitude", "omega")
    }
    plain = {"x": ("position", 0), "y": ("position", 1), "z": ("position", 2), "v": ("velocity", 0)}
    plain |= {"vx": ("velocity", 0), "vy": ("velocity", 1), "vz": ("velocity", 2)}
    for name in truth.values:
        head, _, axis = name.partition(".")
        if name in plain:
            column, index = plain[name]
            columns[column][:, 0, index] = truth.value(name)
        elif head in ("attitude", "omega"):
            columns[head][:, 0, ("wxyz" if head == "attitude" else "xyz").index(axis)] = (
                truth.value(name)
            )
        elif head[:-1] in ("r", "v", "omega") and head[-1] in "12" and n == 2:
            column = {"r": "position", "v": "velocity", "omega": "omega"}[head[:-1]]
            columns[column][:, int(head[-1]) - 1, "xyz".index(axis)] = truth.value(name)
    if "theta" in truth.values:
        theta = truth.value("theta")
        rate = truth.value("thetadot")
        length = of.instance.p.length
        columns["velocity"][:, 0, 0] = length * rate * np.cos(theta)
        columns["velocity"][:, 0, 1] = length * rate * np.sin(theta)
    return Trajectory(t=of.instance.times, **columns)


def denser(run: Trajectory, times: int) -> Trajectory:
    """A run with every sample repeated so many times."""
    names = ("t", "position", "velocity", "attitude", "omega")
    repeated = {name: np.repeat(getattr(run, name), times, axis=0) for name in names}
    return replace(run, **repeated)


def back(run: Trajectory, change: str) -> Trajectory:
    """A run on the way back: with velocities reversed, or with negative steps."""
    sign = 1.0
    if change == "reversed":
        sign = -1.0
    return replace(
        run,
        position=run.position[::-1],
        velocity=sign * run.velocity[::-1],
        attitude=run.attitude[::-1],
        omega=sign * run.omega[::-1],
    )


def findings(
    check: str,
    of: Subject,
    fault: Callable[[Trajectory, float], Trajectory] = lambda run, level: run,
):
    """What a check finds when every run it needs is the true one, spoiled by `fault(run,
    level)`.
    """
    found = discovery.check(check)
    reason = found.applies(of)
    assert reason is None, reason

    def made(variant: Variant) -> CompletedRun:
        run = true_run(of)
        if variant.change == "denser_output":
            run = denser(run, variant.amount)
        elif variant.goes_on:
            run = back(run, variant.change)
        if variant.change not in ("repeated", "denser_output"):
            run = fault(run, variant.level)
        return CompletedRun(run, Cost(seconds=0.0))

    runs = all_runs(found, of, made)
    return {finding.quantity: finding for finding in found.judge(of, runs)}


@pytest.fixture
def judge():
    """`judge(check, case, method, fault=..., **parameters)` -> findings by quantity."""

    def judged(check, case, method, fault=lambda run, level: run, **given):
        return findings(check, subject(case, method, **given), fault)

    return judged
