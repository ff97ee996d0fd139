"""Round-off of rods and of overlaps: far from the origin it is that of the places, and where only a
force holds a rod it adds up.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import linear, momentum_scale
from refdem.core.check import CompletedRun, Subject
from refdem.core.engine import Method
from refdem.core.problem import Request
from refdem.core.refinement import sweeping
from refdem.core.trajectory import Cost
from refdem.core.variant import Variant

EXACT = Method(
    name="exact", summary="", control="exact", conserves=frozenset({"energy", "constraint"})
)
HELD = Method(name="held", summary="", control="tolerance", conserves=frozenset({"energy"}))
FAR = "1001,0,0,1000,1,0,1000,0,1,999,-1/2,0"


def outcome(case, method, of, fault=lambda run: run, **given):
    """The subject of a case and the run of the reference's `method`, spoiled."""
    instance = discovery.case(case).at(**given)
    engine = discovery.engine("reference")
    if of.control == "exact":
        level = 0.0
    else:
        level = 1e-10
    run, _ = engine.run(Request(problem=instance.problem, method=method))
    return Subject(instance, of, (level,), None), {
        Variant(level): CompletedRun(fault(run), Cost(seconds=0.0))
    }


def stretched(size):
    return lambda run: replace(
        run, position=run.position * np.where(run.t > 0, 1 + size, 1.0)[:, None, None]
    )


@pytest.mark.parametrize(
    ("fault", "expected"), [(stretched(0.0), "pass"), (stretched(3e-11), "fail")]
)
def test_rods_far_from_the_origin_are_as_long_as_places_can_say(fault, expected):
    subject, runs = outcome("rigid-cluster", "exact-rigid-cluster", EXACT, fault, positions=FAR)
    found = discovery.check("constraint").judge(subject, runs)
    assert {finding.quantity: finding.outcome for finding in found}["length"] == expected


def test_a_cluster_far_from_the_origin_keeps_its_momentum():
    subject, runs = outcome("rigid-cluster", "exact-rigid-cluster", EXACT, positions=FAR)
    total = linear(subject.instance.scene, runs[Variant(0.0)].trajectory)
    assert np.abs(total - total[0]).max() < subject.round_off(0.0) * momentum_scale(
        subject.instance
    )


def drawn_out(size):
    """A rod that grows evenly to 1 + size times its length."""
    return lambda run: replace(
        run, position=run.position * (1 + size * run.t / run.t[-1])[:, None, None]
    )


@pytest.mark.parametrize(("size", "expected"), [(1e-13, "pass"), (1e-11, "fail")])
def test_the_energy_of_a_rod_that_only_its_force_holds(size, expected):
    subject, runs = outcome("pendulum", "exact-pendulum", HELD, drawn_out(size), theta0="1/8")
    balance, *_ = discovery.check("energy").judge(subject, runs)
    assert balance.outcome == expected, balance.sentence


def test_a_method_that_claims_its_rods_is_held_to_round_off():
    subject, runs = outcome(
        "pendulum",
        "exact-pendulum",
        replace(HELD, conserves=EXACT.conserves),
        drawn_out(1e-13),
        theta0="1/8",
    )
    balance, *_ = discovery.check("energy").judge(subject, runs)
    assert balance.outcome == "fail"


def test_sweeps_over_rods_that_share_bodies_round_more():
    stepped = Method(name="stepped", summary="", control="step", order=2)
    cluster, pendulum = (discovery.case(name).at() for name in ("rigid-cluster", "pendulum"))
    assert sweeping(pendulum, stepped) == sweeping(cluster, EXACT) == 1.0
    assert sweeping(cluster, stepped) == pytest.approx(np.sqrt(53 * 3 / 10))


@pytest.mark.parametrize(("digits", "expected"), [(np.float32, "pass"), (np.float16, "fail")])
def test_overlaps_of_single_precision_are_as_good_as_places_are(digits, expected):
    single = Method(
        name="single",
        summary="",
        control="exact",
        precision="single",
        conserves=frozenset({"energy"}),
    )
    given = {"stiffness": "1e8", "damping": "0"}
    subject, runs = outcome("two-spheres", "contact-events", single, rounded(digits), **given)
    balance, *_ = discovery.check("energy").judge(subject, runs)
    assert balance.outcome == expected, balance.sentence


def rounded(digits):
    """Places and velocities in fewer digits, as a code of that precision has them."""

    def fault(run):
        position, velocity = (
            (x / np.abs(x).max()).astype(digits).astype(float) * np.abs(x).max()
            for x in (run.position, run.velocity)
        )
        return replace(run, position=position, velocity=velocity)

    return fault


@pytest.mark.parametrize(("roundings", "expected"), [(0.8, "pass"), (8.0, "fail")])
def test_a_sphere_that_spins_steadily_in_single_precision_is_stretched_alike_at_every_step(
    roundings, expected
):
    """Measured: 0.8 roundings a step, all of one sign."""
    steps = 4096
    single = Method(
        name="m",
        summary="",
        control="step",
        order=2,
        precision="single",
        conserves=frozenset({"angular-momentum"}),
    )
    given = {"inertia": "1,1,1", "omega_body": "0.3,0.5,0.7"}
    instance = discovery.case("free-rigid-body").at(**given)
    engine = discovery.engine("reference")
    level = float(instance.times[-1]) / steps
    run, _ = engine.run(Request(problem=instance.problem, method="exact-free-body"))
    stretched_by = 1 + roundings * 2.0**-24 * steps * run.t / run.t[-1]
    run = replace(run, omega=run.omega * stretched_by[:, None, None])
    subject = Subject(instance, single, (level,), None)
    found = discovery.check("angular-momentum").judge(
        subject, {Variant(level): CompletedRun(run, Cost(seconds=0.0))}
    )
    assert {finding.quantity: finding.outcome for finding in found}["spin"] == expected
