"""An engine in which nothing moves, and one in which everything goes a per cent too far, fail in
every case that moves.
"""

from collections import defaultdict

import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.core.static_problems import Static
from refdem.faults.catalogue import chosen
from refdem.planning import plan
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.planning.specification import named

KEPT_BY_REST = {
    "angular-momentum": "what stands still keeps it",
    "momentum": "what stands still keeps it",
    "energy": "what stands still keeps it",
    "energy-return": "nothing is gained there or back",
    "constraint": "rods of a body that stands keep their length",
    "top": "the joint stays closed, L stays",
    "apsides": "vectors of the orbit are constants of the state",
    "bounces": "the speed of a start that is repeated stays",
    "contact-channels": "channels and state are of the same row",
    "determinism": "it is the same every time",
    "quaternion-norm": "the first attitude is a unit quaternion",
    "reversal": "it comes back to the start",
    "symmetry": "a scene that stands still is the same in every frame",
    "rest": "where the scene rests it is right",
    "stop": "it does not creep",
    "flips": "a body whose truth never flips",
    "lyapunov": "neighbours that stand still do not part: a regular motion",
    "cooling": "temperatures that are constant, distributions that stay",
    "phase-area": "the first outline keeps its area",
    "rigid-impact": "no impulse at all is in the cone of friction; the restitution fails",
}
"""Checks of which a frozen run may pass some quantity, because it obeys that law."""

KEPT_BY_STRETCHING = {
    "angular-momentum": "of bodies on which nothing acts: straight lines stay straight",
    "momentum": "it stays zero in sum",
    "energy": (
        "free flight has no energy to be wrong; with friction only a rise is looked for; others"
        " fail in one of the quantities"
    ),
    "bounces": "directions still point inwards",
    "contact-channels": "channels are stretched with the state",
    "determinism": "it is the same every time",
    "quaternion-norm": "a longer turn is a turn",
    "reversal": "the way back starts where the stretched way ended: free flight comes back",
    "symmetry": "it is a per cent too far in every frame",
    "rest": "where nothing moves a per cent of it is nothing",
    "stop": (
        "it does not creep, and a stop between two samples is not known to a per cent of the time"
    ),
    "flips": "a number of flips",
    "lyapunov": "a distance that is a per cent larger changes an exponent by ln(1.01)/T",
    "cooling": "statistics of so few collisions are not known to a per cent",
    "roughness": "statistics of so few collisions are not known to a per cent",
    "limit": "kinked motions and those at round-off have none",
    "contact-line": "on a level plane both of its parts are a per cent larger: their sum stays",
    "rigid-impact": (
        "both parts of the impulse, and the speeds before and after, are a per cent larger: their"
        " ratios are right"
    ),
}
"""Checks of which a run that goes a per cent too far may pass some quantity, because it obeys that
law.
"""

ALIKE_AT_ALL_STEPS = "order/growth"
"""A quantity that either run may pass: an error that is the same at every step does not grow as the
step falls. That it does not fall is the quantity `state`.
"""
RESTING = ("block-on-slope", "newtons-first-law")
KEEPS = {"frozen": KEPT_BY_REST, "one-per-cent": KEPT_BY_STRETCHING}


MOST_GRAINS = 1000
"""Of a gas: its laws are no others where it has more."""


def instances():
    """The instances of campaign main that are judged by all checks, in their order; a large gas
    with fewer grains.
    """
    every = [instance for instance, only in plan.instances(named("main")) if not only]
    return [fewer_grains(instance) for instance in every]


def fewer_grains(instance):
    """The same instance, of a gas one with MOST_GRAINS at the most."""
    if instance.case.id != "granular-gas" or instance.p["n"] <= MOST_GRAINS:
        return instance
    return instance.case.at(**{**instance.p.given, "n": str(MOST_GRAINS)})


def moves(instance, truth):
    """Something in the certified truth changes; what nobody can certify moves."""
    known = list(truth.values.values())
    return not known or any(max(values) > min(values) for values in known if values)


@pytest.fixture(scope="module")
def reference():
    return discovery.engine("reference")


@pytest.fixture(scope="module")
def truths():
    """Certified samples by label, proved once for both faults."""
    return defaultdict(dict)


@pytest.mark.parametrize("fault", ["frozen", "one-per-cent"])
@pytest.mark.parametrize("instance", instances(), ids=lambda instance: instance.label)
def test_a_motion_that_is_not_the_true_one_is_seen(reference, truths, instance, fault):
    if fault == "frozen" and isinstance(instance.problem, Static):
        return  # a question without time has one answer: nothing can be frozen
    if instance.label not in truths:
        truths[instance.label] = truth_of(instance)
    truth = truths[instance.label]
    method = next(
        m for m in reference.methods if reference.unsupported(instance.problem, m) is None
    )
    (spoiled,) = chosen([fault])
    record = record_of(task_of(spoiled.carrier(reference), method.name, instance, truth, 3))
    failed = {finding.check for finding in record.findings if finding.outcome in ("fail", "error")}
    is_gas = instance.case.id == "granular-gas"
    is_static = isinstance(instance.problem, Static)
    if not moves(instance, truth) and not is_gas and not is_static:
        # Where nothing moves, nothing frozen and no per cent of nothing is wrong.
        assert failed == set()
        return
    if not is_static:
        assert "error" in failed or (is_gas and failed), f"passes: {record.findings}"
    passed = [finding for finding in record.findings if finding.outcome == "pass"]
    blind = [
        f"{f.check}/{f.quantity}: {f.sentence}"
        for f in passed
        if f.check not in (*KEEPS[fault], "error")
        and f"{f.check}/{f.quantity}" != ALIKE_AT_ALL_STEPS
    ]
    assert blind == []
    if isinstance(instance.problem, Motion):
        moved = [
            f"{f.quantity}: {f.sentence}"
            for f in passed
            if f.check == "error" and f.sharpness is not None
        ]
        assert moved == [] or fault == "one-per-cent"
