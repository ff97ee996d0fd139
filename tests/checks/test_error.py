"""The error at the finest level is held to what the run still changed by, of steps and of
tolerances.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.checks.error import _cuts_steps
from refdem.core import discovery
from refdem.faults.change import of_elements, scaled
from refdem.faults.fault import Fault
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.scene.elements.contact import Contact


def off_by(part):
    """Velocities and spins go wrong in the course of time, at the end by a part, whatever the
    tolerance.
    """

    def after(request, run):
        grown = (1 + part * run.t / run.t[-1])[:, None, None]
        return replace(run, velocity=run.velocity * grown, omega=run.omega * grown)

    return Fault(name="off", kind="", sentence="", on=(), sees=("error", "omega"), after=after)


@pytest.mark.parametrize(("case", "part"), [("free-rigid-body", 1e-9), ("two-body-orbit", 5e-8)])
def test_what_no_tolerance_removes_is_seen_below_a_thousand_times_the_tolerance(case, part):
    """The claim alone allows 2.5e-9 and 1.3e-7 at a tolerance of 1e-10."""
    engine = discovery.engine("rebound")
    instance = discovery.case(case).at()
    truth = truth_of(instance)
    carriers = (engine, off_by(part).carrier(engine))
    sound, wrong = (
        record_of(task_of(carrier, "bs", instance, truth, 4, ("error",))) for carrier in carriers
    )
    assert {
        f.quantity: f.sentence for f in sound.findings if f.check == "error" and f.outcome != "pass"
    } == {}
    failed = [f for f in wrong.findings if f.check == "error" and f.outcome == "fail"]
    assert failed
    assert "implied by the last change of tolerance" in failed[0].sentence


@pytest.mark.parametrize(("part", "outcomes"), [(0.0, {"pass"}), (2e-8, {"pass", "fail"})])
def test_a_stiffness_that_is_wrong_by_a_hair_is_seen_where_steps_are_cut_at_contacts(
    part, outcomes
):
    """Cut steps leave the error C h^4 of a smooth motion, a fifteenth of its change at a halving.

    Sixteen times the whole change would allow five parts in 1e8.
    """
    hair = Fault(
        name="hair",
        kind="units",
        sentence="",
        on=(),
        sees=("error", "v1"),
        before=of_elements(Contact, stiffness=scaled(1 + part)),
    )
    instance = discovery.case("two-spheres").at(damping="1")
    carrier = hair.carrier(discovery.engine("reference"))
    record = record_of(task_of(carrier, "rk4", instance, truth_of(instance), 4, ("error",)))
    assert {finding.outcome for finding in record.findings} == outcomes


def test_a_method_that_may_straddle_a_kink_keeps_the_room_of_scattered_errors():
    instance = discovery.case("two-spheres").at(damping="1")
    reference = discovery.engine("reference")
    truth = truth_of(instance)

    def cuts(name):
        subject = task_of(reference, name, instance, truth, 4, ("error",)).subject
        silent = replace(subject, method=replace(subject.method, cuts_steps=False))
        return _cuts_steps(subject), _cuts_steps(silent)

    # Order 4 cannot be had across the kinks of a contact by steps that straddle them, order 2 can.
    assert cuts("rk4") == (True, True)
    assert cuts("velocity-verlet") == (True, False)


def drifted(by):
    """Places that go wrong in the course of time, at the end by `by` [m], at every step."""

    def after(request, run):
        position = run.position.copy()
        position[:, :, 0] += by * (run.t / run.t[-1])[:, None]
        return replace(run, position=position)

    return Fault(name="drift", kind="", sentence="", on=(), sees=("error", "x"), after=after)


@pytest.mark.parametrize(("by", "outcome"), [(0.0, "pass"), (0.015, "fail")])
def test_a_kink_of_higher_order_than_the_claim_does_not_widen_the_bound(by, outcome):
    """The force of the field has kinks and no jumps: Euler's first order does not scatter there.

    What the order claimed allows at the finest step is twice as much.
    """
    engine = drifted(by).carrier(discovery.engine("pymunk"))
    instance = discovery.case("asymmetric-field").at()
    task = task_of(engine, "semi-implicit-euler", instance, truth_of(instance), 4, ("error",))
    (found,) = (f for f in record_of(task).findings if f.quantity == "x")
    assert found.outcome == outcome


def turned_too_fast(part):
    """The component of omega along z is off by a part of the largest from the middle of a run."""

    def after(request, run):
        omega = run.omega.copy()
        omega[len(omega) // 2 :, :, 2] += part * np.max(np.abs(omega))
        return replace(run, omega=omega)

    return Fault(name="fast", kind="", sentence="", on=(), sees=("error", "omega.z"), after=after)


@pytest.mark.parametrize(("part", "outcome"), [(0.0, "pass"), (3e-5, "fail")])
def test_a_quantity_is_held_to_its_own_changes_and_not_to_the_largest_of_all(part, outcome):
    """Halvings change the attitude by more: its change would allow 6e-5 of the scale."""
    engine = discovery.engine("reference")
    instance = discovery.case("free-rigid-body").at()
    carrier = turned_too_fast(part).carrier(engine)
    record = record_of(
        task_of(carrier, "splitting-free-body", instance, truth_of(instance), 4, ("error",))
    )
    outcomes = {finding.quantity: finding.outcome for finding in record.findings}
    assert outcomes["omega.z"] == outcome
    assert outcomes["attitude"] == "pass"
