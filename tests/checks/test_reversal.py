"""The way back: orders of the defect, and chaos, which enlarges round-off, told apart from a motion
that has no way back.
"""

from dataclasses import replace

import numpy as np
import pytest
from msgspec.structs import replace as changed

from refdem.checks.reversal import CHECK, _defect, _meets_too_soon
from refdem.core import discovery
from refdem.core.check import Subject
from refdem.core.variant import Variant
from refdem.engines.reference import ENGINE
from refdem.faults.change import of_columns, scaled
from refdem.faults.fault import Fault
from refdem.faults.transparent import Transparent
from refdem.planning import plan
from refdem.planning.in_process import record_of, run_of, task_of, truth_of

WAYS_BACK = [
    (ENGINE, "rk4", "harmonic-oscillator", {}, 4, 5),
    (ENGINE, "rk4", "duffing", {"beta": "2"}, 4, 5),
    (ENGINE, "rk4-free-body", "free-rigid-body", {}, 4, 5),
    (Transparent(), "explicit-euler", "harmonic-oscillator", {}, 1, 1),
    (Transparent(), "euler", "harmonic-oscillator", {}, 1, 1),
]


@pytest.mark.parametrize(("engine", "method", "case", "given", "order", "expected"), WAYS_BACK)
def test_the_defect_falls_with_the_order_if_it_is_odd_and_one_more_if_it_is_even(
    engine, method, case, given, order, expected
):
    instance = discovery.case(case).at(**given)
    task = task_of(engine, method, instance, truth_of(instance), 3, ("reversal",))
    assert task.method.order == order
    found = []
    first = instance.problem.interval / (4 if order > 1 else 64)
    for h in (first, first / 2):
        there = run_of(engine, plan.request(task, Variant(h)))
        back = run_of(engine, plan.request(task, Variant(h, "reversed"), there.trajectory))
        found.append(_defect(task.subject, back.trajectory, "reversed"))
    assert np.log2(found[0] / found[1]) == pytest.approx(expected, abs=0.1)


CHAOS = {"theta0": "3,3", "duration": "5", "samples": "20"}


def test_chaos_enlarges_round_off_and_is_no_irreversibility():
    instance = discovery.case("double-pendulum").at(**CHAOS)
    truth = truth_of(instance)
    assert truth.growth()[-1] > 1000
    dragged = Fault(
        name="drag", kind="", sentence="", on=(), sees=("reversal", "reversed"), after=drag
    ).carrier(ENGINE)
    sound, lost = (
        task_of(engine, "rod-chain", instance, truth, 1, ("reversal",))
        for engine in (ENGINE, dragged)
    )
    plain = 2 * np.sqrt(2) * sound.subject.round_off(sound.subject.levels[-1])
    for finding in record_of(sound).findings:
        assert finding.outcome == "pass"
        assert finding.value > 3 * plain  # a bound without S would call it irreversible
    assert {f.quantity: f.outcome for f in record_of(lost).findings}["reversed"] == "fail"


def drag(request, run):
    """Velocities are a millionth too small wherever the run ends: what drag has taken on the
    way.
    """
    return of_columns(velocity=scaled(1 - 1e-6))(request, run)


@pytest.mark.parametrize(
    ("engine", "method", "bound"), [(ENGINE, "rk4", 0.25), (Transparent(), "euler", 0.15)]
)
def test_the_order_of_the_defect_may_lack_a_twentieth_of_it_or_15_hundredths(engine, method, bound):
    instance = discovery.case("harmonic-oscillator").at()
    record = record_of(task_of(engine, method, instance, truth_of(instance), 5, ("reversal",)))
    (finding,) = (found for found in record.findings if found.quantity == "order")
    assert finding.bound == pytest.approx(bound, rel=1e-12)


def lossy_on_the_way_back(start, part):
    """Velocities and spins are a part too small at the end of every run that does not begin at the
    start of the case.
    """

    def after(request, run):
        is_there = np.array_equal(
            request.problem.scene.bodies.position, start.position
        ) and np.array_equal(request.problem.scene.bodies.attitude, start.attitude)
        if is_there:
            return run
        return of_columns(velocity=scaled(1 - part), omega=scaled(1 - part))(request, run)

    return Fault(
        name="drag", kind="", sentence="", on=(), sees=("reversal", "reversed"), after=after
    )


@pytest.mark.parametrize(
    ("engine", "method", "case", "part", "least"),
    [
        ("rebound", "bs", "free-rigid-body", 3e-9, 3e-9),
        ("reference", "rk4", "hertz-spheres", 1e-4, 1e-4),
    ],
)
def test_the_way_back_may_add_what_the_way_there_is_seen_to_be_off_by(
    engine, method, case, part, least
):
    """Its claims allow 6e-8 to a tolerance of 1e-10, and 0.07 to steps across the end of a
    contact.
    """
    engine = discovery.engine(engine)
    instance = discovery.case(case).at()
    truth = truth_of(instance)
    lossy = lossy_on_the_way_back(instance.scene.bodies, part)
    records = [
        record_of(task_of(carrier, method, instance, truth, 4, ("reversal",)))
        for carrier in (engine, lossy.carrier(engine))
    ]
    sound, lost = ({f.quantity: f for f in record.findings} for record in records)
    assert sound["reversed"].outcome == "pass"
    assert sound["reversed"].bound < least
    assert lost["reversed"].outcome == "fail", lost["reversed"].sentence


ELASTIC = {"restitution": "1", "offset": "-1/4,0", "masses": "1,3", "radii": "1/2,3/4"}
COLLISIONS = [
    ("reference", "impacts", "hard-spheres", ELASTIC),
    ("reference", "impacts", "newtons-cradle", {}),
    ("reference", "impacts", "bouncing-ball", {"restitution": "1", "velocity": "1,-1"}),
    ("pymunk", "semi-implicit-euler", "hard-spheres", ELASTIC),
    ("pymunk", "semi-implicit-euler", "hard-wall", {"restitution": "1"}),
    ("pymunk", "semi-implicit-euler", "bouncing-ball", {"restitution": "1", "velocity": "1,-1"}),
    ("reference", "exact-corner-impact", "corner-impact", {"restitution": "1"}),
    ("pymunk", "semi-implicit-euler", "corner-impact", {"restitution": "1"}),
    ("rebound", "leapfrog", "hard-spheres", ELASTIC),
    ("rebound", "leapfrog-uncut", "hard-spheres", ELASTIC),
    ("rebound", "leapfrog-line", "newtons-cradle", {}),
]


@pytest.mark.parametrize(("engine", "method", "case", "given"), COLLISIONS)
def test_impacts_that_lose_nothing_run_back_and_a_loss_on_the_way_back_is_seen(
    engine, method, case, given
):
    """Steps that see an impact late come back to their order; leapfrog claims to come back to
    round-off, and does so where no impact is late.
    """
    engine = discovery.engine(engine)
    instance = discovery.case(case).at(**given)
    truth = truth_of(instance)
    lossy = lossy_on_the_way_back(instance.scene.bodies, 0.75).carrier(engine)
    tasks = [task_of(one, method, instance, truth, 4, ("reversal",)) for one in (engine, lossy)]
    sound, lost = ({f.quantity: f for f in record_of(task).findings} for task in tasks)
    assert sound["reversed"].outcome == "pass", sound["reversed"].sentence
    assert lost["reversed"].outcome == "fail", lost["reversed"].sentence


def test_spheres_of_rebound_do_not_collide_in_negative_steps_and_the_check_says_so():
    engine = discovery.engine("rebound")
    instance = discovery.case("hard-spheres").at(**ELASTIC)
    task = task_of(engine, "leapfrog", instance, truth_of(instance), 4, ("reversal",))
    (backward,) = (f for f in record_of(task).findings if f.quantity == "backward")
    assert backward.outcome == "unsupported"
    assert backward.sentence == (
        "Steps backwards in time were not tried: the engine does not support collisions with"
        " negative steps (its search skips the pairs that then come nearer)."
    )


@pytest.mark.parametrize(
    ("case", "given", "reason"),
    [
        ("hard-spheres", {"restitution": "1", "friction": "1/4"}, "not reversible"),
        ("hard-spheres", {"restitution": "1/2"}, "not reversible"),
        ("corner-impact", {"restitution": "1/2"}, "not reversible"),
        ("newtons-first-law", {"member": "stack"}, "not reversible"),
        ("granular-gas", {"contact": "rigid", "restitution": "1", "n": "64"}, "alone are run back"),
    ],
)
def test_collisions_that_lose_energy_and_crowds_in_a_box_are_left_out_with_the_reason(
    case, given, reason
):
    instance = discovery.case(case).at(**given)
    method = ENGINE.best(instance.problem)
    why = CHECK.applies(Subject(instance, method, (0.0,), None))
    assert why is not None
    assert reason in why


def test_a_motion_that_is_certified_in_part_is_not_judged_on_its_way_back():
    """What errors grow to by the end is not known there: any bound would be that of a shorter
    motion.
    """
    instance = discovery.case("double-pendulum").at(**CHAOS)
    whole = truth_of(instance)
    part = changed(whole, until=len(instance.times) - 5)
    task = task_of(ENGINE, "rod-chain", instance, part, 1, ("reversal",))
    (finding,) = record_of(task).findings
    assert finding.outcome == "undecided"
    assert "no certified truth at the end" in finding.sentence


def test_steps_that_may_end_before_they_see_the_first_impact_decide_nothing():
    """The spheres of the way back meet a thousandth of a second before its end."""
    given = {"restitution": "1", "offset": "0,0", "distance": "1001/1000"}
    instance = discovery.case("hard-spheres").at(**given)
    truth = truth_of(instance)
    method = discovery.engine("reference").method("impacts")
    late = replace(method, control="step", order=1, locates_events=False)
    subject = Subject(instance, late, (1e-3,), truth)
    why = _meets_too_soon(subject, 1e-3, 0.0)
    assert why is not None
    assert "in the backward run the first impact" in why
    assert _meets_too_soon(subject, 4e-4, 0.0) is None
    assert _meets_too_soon(Subject(instance, method, (0.0,), truth), 0.0, 0.0) is None


def test_a_drag_too_small_for_the_largest_growth_shows_on_the_way_back_of_a_tumbling_body():
    """S is 2648 at the end of the last flip, and 140 for most of the way: with S of the end for
    each rounding and each of 12 columns the bound was 3.4e-8.
    """
    given = {"inertia": "3,2,1", "attitude": "1,2,-1,0.5", "direction": "3", "duration": "24"}
    instance = discovery.case("intermediate-axis").at(**given)
    truth = truth_of(instance)
    lossy = lossy_on_the_way_back(instance.scene.bodies, 5e-9)
    records = [
        record_of(task_of(carrier, "splitting-free-body", instance, truth, 4, ("reversal",)))
        for carrier in (ENGINE, lossy.carrier(ENGINE))
    ]
    sound, lost = ({f.quantity: f for f in record.findings} for record in records)
    assert sound["reversed"].outcome == "pass"
    assert sound["reversed"].bound < 1e-9
    assert lost["reversed"].outcome == "fail", lost["reversed"].sentence
