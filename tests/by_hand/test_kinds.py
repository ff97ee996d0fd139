"""Findings on billiards, outlines in phase space and gases of rough spheres, and the runs that
checks ask for, as numbers that are computed on paper.
"""

from math import pi, sqrt, tanh
from types import SimpleNamespace

import numpy as np
import pytest

from refdem.checks import bounces, determinism, lyapunov, phase_area, roughness, top
from refdem.core import discovery
from refdem.core.case import EnsembleCase
from refdem.core.check import CompletedRun, Subject
from refdem.core.ensemble import Ensemble
from refdem.core.maps import Logistic, RectangleBilliard
from refdem.core.parameters import Parameter, Parameters
from refdem.core.problem import Iteration
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.variant import Variant
from refdem.scene import Body, Sphere
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from tests.handmade import U, findings, instance, method, near, standing, truth

TIMES = (0.0, 2.0, 4.0, 6.0, 8.0)
ROUND_OFF = 8 * U * 16
POINT = Body(mass=2.0, position=(3.0, 0.0, 0.0))
LIKE = {"rel": 1e-9}


def asked(problem, length=4.0):
    """A subject that is no more than a question and a length."""
    of = SimpleNamespace(problem=problem, scales=SimpleNamespace(length=length))
    return SimpleNamespace(instance=of, method=method("exact"), finest=Variant(0.0))


def test_every_bounce_is_on_the_wall_at_unit_speed_and_goes_inwards_to_eight_roundings():
    table = RectangleBilliard(width=4.0, height=2.0)
    subject = asked(Iteration(table, np.array([0.0, 0.0, 0.6, 0.8]), 3))
    assert bounces.CHECK.applies(subject) is None
    assert (
        bounces.CHECK.applies(asked(Iteration(Logistic(eta=3.0), np.array([0.5]), 3))) is not None
    )
    position = np.array([[9.0, 9.0], [0.75, 1.0], [2.0, 0.5], [1.0, -1.25]])
    direction = np.array([[9.0, 9.0], [0.6, -0.8], [-1.2, -0.9], [0.8, -0.6]])
    run = Trajectory.of_values(np.arange(4.0), {"position": position, "direction": direction})
    found = findings(bounces.CHECK, subject, run)
    # The start is no bounce; the second goes at 3/2, the third is 1/4 outside and goes outwards.
    assert found["speed"].value == near(0.5, rel=1e-14)
    assert found["wall"].value == 0.25 / 4
    assert found["inward"].value == near(0.6, rel=1e-14)
    # The image of (-6/5, -9/10) in the lower wall is (-6/5, 9/10); it goes on along (4/5, -3/5).
    assert found["reflection"].value == near(2.5, rel=1e-14)
    # |vx| is 6/5 in place of 3/5 at n = 2; that is more of its bound than what |vy| changes.
    assert found["kept.x"].value == near(0.6, rel=1e-14)
    assert found["kept.x"].bound == 2 * 8 * U
    assert found["kept.y"].value == near(0.2, rel=1e-14)
    local = [finding.bound for name, finding in found.items() if "kept" not in name]
    assert local == [8 * U] * 4


class Outline(EnsembleCase):
    """An outline that the test says."""

    id = "outline"
    title = statement = latex = source = ""
    parameters = ()

    def __init__(self, x, v):
        self.columns = x, v

    def problem(self, p):
        raise NotImplementedError

    def starts(self, p, outline):
        raise NotImplementedError

    def scales(self, p):
        raise NotImplementedError

    def quantities(self, p):
        return ()

    def observe(self, p, trajectory):
        return {}

    def truth(self, p):
        raise NotImplementedError

    def outline(self, p, trajectory):
        return self.columns


def area_of(x, v, area, elements=(), **known):
    """The finding on the area that an outline encloses."""
    motion = instance([POINT], elements, times=TIMES)
    starts = np.zeros((1, 1, 3))
    asked_for = Ensemble(motion.scene, motion.times, starts, starts)
    of = SimpleNamespace(case=Outline(x, v), p=None, problem=asked_for, times=motion.times)
    subject = SimpleNamespace(
        instance=of,
        truth=truth(TIMES, {"area": area}, **known),
        truth_reason="",
        levels=(2.0**-3,),
        finest=Variant(2.0**-3),
        round_off=lambda level: ROUND_OFF,
    )
    assert phase_area.CHECK.applies(subject) is None
    run = {subject.finest: CompletedRun(standing(motion), Cost(seconds=0.0))}
    (found,) = phase_area.CHECK.judge(subject, run)
    return found


def circle(count=64, radius=1.0):
    """Points round a circle (T, count), their area, and the polygon's error."""
    turn = 2 * pi * np.arange(count) / count
    x = np.tile(radius * np.cos(turn), (5, 1))
    v = np.tile(radius * np.sin(turn), (5, 1))

    def polygon(corners):
        return radius**2 * corners / 2 * np.sin(2 * pi / corners)

    return x, v, polygon(count), polygon(count // 2) - polygon(count // 4)


@pytest.mark.parametrize(
    ("elements", "share"),
    [
        ((), 0.45),
        ((Spring(a=0, b=-1, stiffness=1.0),), 0.45),
        ((Slider(a=0, friction=0.5, normal_force=1.0),), 4.0),
    ],
)
def test_an_area_is_held_to_the_error_of_its_polygon_and_round_off(elements, share):
    x, v, area, difference = circle(256)
    true = [2.0, 2.0, 2.0, 2.5, 2.0]
    found = area_of(x, v, true, elements, radius=0.125, growth=[1, 1, 1, 3.0, 1])
    # In units of the first area; the radius of truth is no error.
    assert found.value == near((area - 2.0 - 0.125) / 2, **LIKE)
    length = 4.0
    rounding = 8 * ROUND_OFF * (length + length)
    assert found.bound == near((share * difference + rounding) / 2, **LIKE)
    assert found.sharpness == near(found.bound, rel=1e-6)


def test_an_outline_that_stretches_is_judged_while_its_polygon_is_fine():
    x, v, area, _ = circle(256)
    x[3:] *= np.where(np.arange(256) % 4 == 2, 3.0, 1.0)
    found = area_of(x, v, [area] * 5)
    assert found.outcome == "pass"
    assert len(found.series.t) == 3
    x[1:] *= np.where(np.arange(256) % 4 == 2, 3.0, 1.0)
    assert area_of(x, v, [area] * 5).outcome == "undecided"


def rough_gas(spins, energy=1.0, n=101, frequency=2.0, t0=4.0, radius=0.25, stiffness=2.0**20):
    """Findings on a gas of rough spheres whose spins have this size (T,) and nothing else moves."""
    inertia = 0.4 * 2.0 * radius**2
    law = Contact(
        law="linear", stiffness=stiffness, friction=1000.0, tangential_stiffness=stiffness / 3.5
    )
    balls = [
        Body(
            mass=2.0,
            inertia=(inertia,) * 3,
            position=(float(k), 0, 0),
            velocity=(0, 3.0, 0),
            shape=Sphere(radius=radius),
        )
        for k in range(n)
    ]
    of = instance(
        balls,
        (law, PeriodicBox(size=200.0)),
        times=(0.0, 1.0, 2.0),
        quantities={"temperature": 1.0},
    )
    initial = Parameter(name="t0", default=str(t0), unit="J", doc="initial temperature")
    of = type(of)(of.case, Parameters((initial,), {}))
    known = truth(of.times, {}, scalars={"collision_frequency": (frequency, 0.0)})
    subject = Subject(of, method(), (2.0**-3,), known)
    omega = np.zeros((3, n, 3))
    omega[:, :, 0] = np.array(spins)[:, None]
    velocity = np.array(standing(of).velocity)
    velocity[2] *= energy
    return subject, findings(roughness.CHECK, subject, standing(of, omega=omega, velocity=velocity))


def test_spins_of_a_rough_gas_gain_what_kinetic_theory_says():
    subject, found = rough_gas([0.0, 5.0, 6.0])
    assert roughness.CHECK.applies(subject) is None
    n, inertia, t0, frequency = 101, 0.4 * 2.0 / 16, 4.0, 2.0
    q = 0.4
    rate = 4 / 3 * frequency * q / (1 + q) ** 2
    t = np.array([0.0, 1.0, 2.0])
    phase = rate * t / sqrt(2) + np.arctanh(1 / sqrt(2))
    u = np.array([1 / (sqrt(2) * tanh(value)) for value in phase])
    rotational = t0 * (1 - u**2)
    # sum J w^2 of n bodies over 3 n degrees of freedom.
    observed = inertia * np.array([0.0, 25.0, 36.0]) / 3
    mean = (np.diff(1 / (u * 2)) / np.diff(np.log(1 / u))) ** -1
    counted = np.concatenate([[0.0], np.cumsum(50 * frequency / 2.0 * mean)])
    softness = frequency * pi * sqrt(2.0 / (2 * 2.0**20))
    stored = softness + 4 * sqrt(softness / n)
    allowed = 4 * rotational / t0 * np.sqrt(2 / np.maximum(counted, 1)) + 0.01 + stored
    values = np.abs(observed - rotational) / t0
    worst = int(np.argmax(values / allowed))
    assert found["spin"].value == near(values[worst], **LIKE)
    assert found["spin"].bound == near(allowed[worst], **LIKE)
    assert found["energy"].bound == near(stored, **LIKE)


def test_a_rough_gas_keeps_its_energy():
    _, found = rough_gas([0.0, 0.0, 0.0], energy=1.1)
    assert found["energy"].value == near(0.21, **LIKE)


def test_a_rough_gas_is_judged_where_collisions_are_binary_and_many():
    _, soft = rough_gas([0.0] * 3, stiffness=100.0)
    assert "collisions are not binary" in soft["energy"].sentence
    _, few = rough_gas([0.0] * 3, n=10)
    assert "30 are needed" in few["spin"].sentence


@pytest.mark.parametrize(
    ("factor", "friction", "spin", "applies"),
    [
        (1.0, 1000.0, 0.0, True),
        (1.0, 100.0, 0.0, True),
        (1.0, 99.0, 0.0, False),
        (1 + 0.9e-6, 1000.0, 0.0, True),
        (1 + 1.1e-6, 1000.0, 0.0, False),
        (1.0, 1000.0, 1e-9, False),
    ],
)
def test_contacts_of_a_rough_gas_reverse_their_slip_and_never_slide(
    factor, friction, spin, applies
):
    law = Contact(
        law="linear", stiffness=70.0, friction=friction, tangential_stiffness=20.0 * factor
    )
    ball = Body(mass=2.0, inertia=(0.8,) * 3, shape=Sphere(radius=1.0), omega=(0, 0, spin))
    of = instance([ball], (law, PeriodicBox(size=9.0)), quantities={"temperature": 1.0})
    said = roughness.CHECK.applies(Subject(of, method(), (0.1,), None))
    assert (said is None) == applies


# Runs that checks ask for


@pytest.mark.parametrize(
    ("levels", "control", "chosen", "is_dense"),
    [
        # Samples are 2 s apart: four steps in each are of 1/2 s.
        ((1.0, 0.5, 0.25), "step", 0.5, True),
        ((1.0, 0.51), "step", 0.51, False),
        ((0.4, 0.2), "step", 0.4, True),
        ((0.9, 0.8), "tolerance", 0.9, True),
    ],
)
def test_determinism_is_seen_at_the_coarsest_level_with_four_steps_a_sample(
    levels, control, chosen, is_dense
):
    of = instance([POINT])
    dense = (Variant(chosen, "denser_output", 4),) * is_dense
    subject = Subject(of, method(control, threads=True), levels, None)
    assert determinism.CHECK.needs(subject) == (
        Variant(chosen),
        Variant(chosen, "repeated"),
        *dense,
        Variant(chosen, "threads", 2),
    )
    single = Subject(of, method(control), levels, None)
    assert determinism.CHECK.needs(single)[2:] == dense


def test_runs_of_one_request_differ_by_their_largest_number_at_samples_of_both():
    of = instance([POINT])
    dense = instance([POINT], times=tuple(0.5 * k for k in range(17)))
    base = standing(of)

    def run(variant):
        if variant.change == "denser_output":
            values = np.array(standing(dense).velocity)
            values[3] = 9.0
            values[8, 0, 1] = -0.25
            return standing(dense, velocity=values)
        values = np.array(base.position)
        if variant.change == "repeated":
            values[2, 0, 0] -= 0.5
        return standing(of, position=values)

    found = findings(determinism.CHECK, Subject(of, method(), (0.25,), None), run)
    assert {name: (f.value, f.bound) for name, f in found.items()} == {
        "repeated": (0.5, 0.0),
        "output-rate": (0.25, 0.0),
    }


@pytest.mark.parametrize(
    ("claims", "is_chaotic", "reason"),
    [
        ({}, True, None),
        ({}, None, "does not declare"),
        ({"control": "tolerance"}, True, "perturb neighbouring trajectories"),
        ({"precision": "single"}, True, "perturb neighbouring trajectories"),
        ({"control": "exact"}, True, None),
        ({}, False, "only after 100 tau"),
    ],
)
def test_neighbours_are_compared_in_double_precision_where_the_class_is_declared(
    claims, is_chaotic, reason
):
    of = instance([POINT], is_chaotic=is_chaotic)
    said = lyapunov.CHECK.applies(Subject(of, method(**claims), (0.1,), None))
    assert (said is None) if reason is None else (reason in said)
    assert lyapunov.CHECK.needs(Subject(of, method(), (0.2, 0.1), None)) == (
        Variant(0.1),
        Variant(0.1, "perturbed", 2**26),
    )


def test_without_gravity_the_axis_of_a_top_is_z():
    body = Body(
        mass=2.0,
        inertia=(3.0, 3.0, 1.0),
        velocity=(0.0, 5.0, 0.0),
        omega=(1.0, 0, 4.0),
        position=(0.75, 0, 1.0),
    )
    joint = BallJoint(a=0, b=-1, anchor_a=(0.0, 0.0, -1.25))
    of = instance([body], (joint,))
    spins = top._spins(of.scene, standing(of))
    np.testing.assert_allclose(spins["L_z"], [4.0 + 2 * 0.75 * 5] * 5, rtol=1e-14)
    offset = BallJoint(a=0, b=-1, anchor_a=(0.5, 0.0, -1.25))
    assert set(top._spins(instance([body], (offset,)).scene, standing(of))) == {"L_z"}
    flat = Body(mass=2.0, inertia=(3.0, 3.5, 1.0), position=(0, 0, 1.25))
    assert set(top._spins(instance([flat], (joint,)).scene, standing(of))) == {"L_z"}


def test_the_moment_about_the_line_of_contact_falls_with_the_order_where_it_is_not_claimed():
    law = Contact(law="rigid", friction=0.25)
    ball = Body(
        mass=2.0,
        inertia=(0.8,) * 3,
        position=(0, 0, 1.0),
        velocity=(6.0, 0, 0),
        shape=Sphere(radius=1.0),
    )
    of = instance([ball], (law, Plane(), UniformGravity(g=(0, 0, -10.0))), times=TIMES)
    check = discovery.check("contact-line")
    levels = (2.0**-3, 2.0**-4, 2.0**-5)

    def run(variant):
        spin = np.zeros((5, 1, 3))
        spin[1:, 0, 1] = 0.015 if variant.level == levels[0] else 0.0015
        return standing(of, omega=spin)

    claims = method(order_with={"contact": 1})
    found = findings(check, Subject(of, claims, levels, None), run)["moment"]
    # J w = 0.0012 of m R v = 12; a contact has room 64; two octaves at order 1.
    assert found.value == near(0.8 * 0.0015 / 12, **LIKE)
    steps = U * 8 / levels[-1]
    expected = 64 * (0.8 * 0.015 / 12) / 4 + 20 * (ROUND_OFF + steps)
    assert found.bound == near(expected, **LIKE)
