"""The transparent engine is right before it carries faults: its orders, its events, its own
limits.
"""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.errors import UnsupportedError
from refdem.faults.correct_parts import CORRECT
from refdem.faults.events import sign_change
from refdem.faults.loads import loads
from refdem.faults.parts import Moving
from refdem.faults.settings import SETTINGS
from refdem.faults.steps import rates
from refdem.faults.transparent import Transparent
from refdem.faults.world import start_of, world_of
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.scene import Body, Scene
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.string_over_wheel import StringOverWheel
from refdem.scene.elements.uniform_gravity import UniformGravity


def run(case, method, halvings, **given):
    """The run at a step of interval / 2^halvings."""
    instance = discovery.case(case).at(**given)
    step = float(instance.times[1]) / 2**halvings
    return Transparent().run(Request(problem=instance.problem, method=method, step=step))[0]


@pytest.mark.parametrize(
    ("method", "order"),
    [
        ("euler", 1),
        ("drift-first", 1),
        ("explicit-euler", 1),
        ("verlet", 2),
        ("suzuki", 4),
        ("rk4", 4),
    ],
)
def test_an_oscillator_converges_to_the_cosine_with_the_claimed_order(method, order):
    worst = []
    for halvings in (2, 3):
        found = run("harmonic-oscillator", method, halvings, duration="8", samples="32")
        worst.append(np.max(np.abs(found.position[:, 0, 0] - np.cos(found.t))))
    assert np.log2(worst[0] / worst[1]) == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize("method", ["verlet", "suzuki", "rk4"])
def test_a_symmetric_top_precesses_at_the_rate_of_the_textbook(method):
    found = run(
        "free-rigid-body",
        method,
        4,
        inertia="1,1,3/2",
        omega_body="1/2,0,1",
        duration="6",
        samples="32",
    )
    rate = (1.5 - 1) / 1 * 1.0  # Landau and Lifshitz, Mechanics, section 36
    body = (
        discovery.case("free-rigid-body").at(inertia="1,1,3/2", omega_body="1/2,0,1").observe(found)
    )
    np.testing.assert_allclose(body["omega_body.x"], 0.5 * np.cos(rate * found.t), atol=1e-3)
    np.testing.assert_allclose(body["omega_body.z"], 1.0, atol=1e-5)


def test_a_torque_spins_a_body_up_in_the_stages_of_runge_kutta_as_in_a_kick():
    scene = discovery.case("free-rigid-body").at(inertia="1,2,5/2", omega_body="0,0,1").scene
    world = world_of(scene, float)
    pushed = CORRECT.with_(loads=lambda *given: replace(loads(*given), torque=[(1.0, 1.0, 1.0)]))
    rate = rates(Moving(world, pushed), start_of(scene, world, CORRECT.to_body))
    assert rate[3] == [(1.0, 1 / 2, 2 / 5)]  # no gyroscopic torque about a principal axis


def test_dry_friction_stops_at_the_turning_point_for_ever():
    found = run("coulomb-oscillator", "verlet", 4, duration="16", samples="64")
    late = found.t > 3 * np.pi + 0.01
    assert np.ptp(found.position[late, 0, 0]) == 0
    assert found.velocity[late].max() == 0
    assert found.position[-1, 0, 0] == pytest.approx(-0.1, abs=1e-3)
    assert found.channels["dissipated_work"][-1] == pytest.approx(
        0.495, abs=1e-3
    )  # half of 1 - 0.01


@pytest.mark.parametrize("cutoff", ["zero_overlap", "zero_force"])
def test_spheres_part_with_the_restitution_of_the_linear_law(cutoff):
    found = run("two-spheres", "verlet", 4, damping="1", cutoff=cutoff)
    b, w0 = 1.0, 16.0  # c/(2 m), sqrt(k/m) with m = 1/2, k = 128, c = 1
    w = np.sqrt(w0**2 - b**2)
    if cutoff == "zero_overlap":
        lasts = np.pi / w
    else:
        lasts = 2 * np.arccos(b / w0) / w
    apart = found.velocity[-1, 1, 0] - found.velocity[-1, 0, 0]
    assert apart == pytest.approx(np.exp(-b * lasts), abs=1e-4)


def test_a_contact_that_sticks_and_slides_converges_with_order_two():
    given = SETTINGS["tumbling-spheres"].parameters("tumbling-spheres", 1)
    runs = [run("two-spheres", "verlet", halvings, **given).omega for halvings in (2, 3, 4)]
    changes = [np.max(np.abs(b - a)) for a, b in pairwise(runs)]
    assert np.log2(changes[0] / changes[1]) == pytest.approx(2, abs=0.15)


def test_rods_keep_their_length_to_the_last_bits():
    found = run("pendulum", "verlet", 3)
    np.testing.assert_allclose(np.linalg.norm(found.position, axis=-1), 1.0, atol=4e-16 * 8)
    assert np.max(np.abs(np.sum(found.position * found.velocity, axis=-1))) < 1e-14


@pytest.mark.parametrize(
    ("case", "given"),
    [
        (
            "double-pendulum",
            {"theta0": "1/2,-1/2", "masses": "3,1/2", "duration": "2", "samples": "16"},
        ),
        ("heavy-top", {"spin": "6", "phidot0": "1", "duration": "2", "samples": "16"}),
        (
            "pendulum-wheel-mass",
            {
                "counter_mass": "3",
                "wheel_radius": "0",
                "wheel_inertia": "0",
                "duration": "1",
                "samples": "16",
            },
        ),
    ],
)
def test_constraints_converge_with_order_two(case, given):
    runs = [run(case, "verlet", halvings, **given).velocity for halvings in (3, 4, 5)]
    changes = [np.max(np.abs(b - a)) for a, b in pairwise(runs)]
    assert np.log2(changes[0] / changes[1]) == pytest.approx(2, abs=0.1)


def test_a_spring_that_slides_in_space_converges_with_order_two():
    """Where the direction of sliding turns: a return straight to the limit, or a spring projected
    to its plane, would be of order 1.
    """
    given = SETTINGS["tumbling-spheres"].parameters("tumbling-spheres", 3)
    runs = [run("two-spheres", "verlet", halvings, **given).omega for halvings in (6, 7, 8)]
    changes = [np.max(np.abs(b - a)) for a, b in pairwise(runs)]
    assert np.log2(changes[0] / changes[1]) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize(("name", "most"), [("line", 15), ("cube", 17), ("jump", 55)])
def test_a_margin_is_located_with_few_evaluations_and_never_more_than_bisection_takes(name, most):
    margin = {
        "line": lambda x: 0.3 - x,
        "cube": lambda x: 0.7**3 - x**3,
        "jump": lambda x: 1.0 if x < 0.3 else -1.0,
    }[name]
    seen = []
    found = sign_change(lambda x: seen.append(x) or margin(x), margin(0.0), margin(1.0), 2.0**-53)
    assert margin(found) < 0 <= margin(found - 2.0**-51)
    assert len(seen) <= most


def test_single_precision_is_single():
    found = run("harmonic-oscillator", "verlet-single", 3)
    np.testing.assert_array_equal(found.position, found.position.astype(np.float32))
    assert np.any(run("harmonic-oscillator", "verlet", 3).position != found.position)


def test_it_says_what_it_cannot_do():
    engine = Transparent()
    method = Transparent().method("verlet")
    two = [Body(mass=1.0), Body(mass=1.0, position=(1.0, 0.0, 0.0))]
    times = np.array([0.0, 1.0])
    for elements, word in (
        ([Rod(a=0, b=1, length=1.0, anchor_b=(0.5, 0.0, 0.0))], "rod"),
        ([Spring(a=0, b=1, anchor_a=(0.5, 0.0, 0.0), stiffness=1.0)], "spring"),
        ([StringOverWheel(a=0, b=1, radius=0.5)], "a string over a wheel that has a size"),
        ([BallJoint(a=0, anchor_a=(0.0, 1.0, 1.0))], "a joint off the principal axes"),
    ):
        assert word in engine.unsupported_motion(Motion(Scene.of(two, elements), times), method)
    assert (
        engine.unsupported_motion(
            discovery.case("double-pendulum").at().problem, engine.method("rk4")
        )
        == "the method has no constraints"
    )
    blocks = discovery.case("newtons-first-law").at(member="block").problem
    assert "rigid" in engine.unsupported_motion(blocks, method)
    sliding = discovery.case("coulomb-oscillator").at().problem
    reason = engine.unsupported_motion(sliding, engine.method("rk4"))
    assert reason.startswith("the method finds no events")


def test_a_contact_without_a_spring_that_comes_to_stick_is_refused_in_the_run():
    instance = discovery.case("two-spheres").at(damping="0", angle="1/4", friction="1")
    request = Request(problem=instance.problem, method="verlet", step=float(instance.times[1]) / 4)
    with pytest.raises(UnsupportedError, match="stick"):
        Transparent().run(request)


def test_the_parts_are_its_own_and_a_run_leaves_nothing_behind():
    first, second = (run("pendulum", "verlet", 2) for _ in range(2))
    np.testing.assert_array_equal(first.position, second.position)
    engine = Transparent(replace(Transparent().parts, kicked=lambda v, force, mass, h: v))
    assert engine.parts.kicked is not Transparent().parts.kicked


def test_a_defect_that_cancels_on_the_way_back_has_no_order_to_lack():
    """On a closed ellipse the first-order defect of symplectic Euler cancels to 5e-9; what is left
    falls with no clean order.
    """
    instance = discovery.case("two-body-orbit").at(stiffness="1")
    record = record_of(
        task_of(Transparent(), "euler", instance, truth_of(instance), 3, ("reversal",))
    )
    assert {finding.quantity: finding.outcome for finding in record.findings} == {
        "reversed": "pass"
    }


@pytest.mark.parametrize(
    "given",
    [{}, {"spin": "20"}, {"slope": "3/4", "speed": "-2"}, {"slope": "2", "speed": "-4"}],
    ids=str,
)
def test_a_body_slides_and_rolls_as_truth_says_at_any_step(given):
    """Forces are constant in each phase, which a step of order 2 that is cut at its end does
    exactly.
    """
    instance = discovery.case("rolling").at(**given)
    truth = instance.truth()
    last = Fraction(float(instance.times[-1]))
    told = truth.at(last)
    for halvings in (0, 3):
        found = run("rolling", "verlet", halvings, **given)
        seen = instance.observe(found)
        for name, quantity in instance.quantities.items():
            error = abs(seen[name][-1] - float(told[name].mid))
            assert error <= 1e-12 * truth.sensitivity(last) * quantity.scale
        assert len(found.events) == ("roll_time" in truth.scalars())


def test_a_slip_that_turns_is_refused():
    engine = Transparent()
    scene = discovery.case("rolling").at(slope="1/2").scene
    turning = replace(scene.bodies, velocity=np.array([[1.0, 0.0, 1.0]]))
    problem = Motion(Scene(turning, scene.elements), np.array([0.0, 1.0]))
    assert engine.unsupported_motion(problem, engine.method("verlet")) == "a slip that turns"


def test_only_methods_that_leave_a_fixed_body_where_it_is_take_one():
    scene = Scene.of([Body(mass=1.0), Body(mass=1.0, fixed=True)], [UniformGravity(g=(0, 0, -1))])
    motion = Motion(scene, np.array([0.0, 1.0]))
    engine = Transparent()
    taking = [method for method in engine.methods if engine.unsupported(motion, method) is None]
    assert {method.name for method in taking} > {"verlet"}
    for method in taking:
        run, _ = engine.run(Request(problem=motion, method=method.name, step=0.25))
        assert run.position[-1, 1].tolist() == [0.0, 0.0, 0.0]
        assert run.position[-1, 0, 2] < -0.3


@pytest.mark.parametrize("method", ["verlet", "verlet-single"])
def test_a_box_comes_back_from_its_impact_in_negative_steps(method):
    instance = discovery.case("corner-impact").at(restitution="1")
    task = task_of(Transparent(), method, instance, truth_of(instance), 3, ("reversal",))
    outcomes = {one.quantity: one.outcome for one in record_of(task).findings}
    assert outcomes == {"reversed": "pass", "backward": "pass"}


@pytest.mark.parametrize("method", ["verlet", "rk4"])
def test_a_clock_that_is_summed_over_steps_that_are_no_dyadic_numbers_is_no_broken_symmetry(method):
    """Other units of time round every sum of the clock in another way, which a drive reads."""
    instance = discovery.case("driven-oscillator").at(duration="1000/3", samples="64")
    task = task_of(Transparent(), method, instance, truth_of(instance), 3)
    found = {f.quantity: f for f in record_of(task).findings if f.check == "symmetry"}
    assert found["rescaled"].value > 1e-11
    assert found["rescaled"].outcome == "pass"
