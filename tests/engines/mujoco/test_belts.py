"""A belt in MuJoCo: `surfacevel` under a pressed sphere, compared with certified truth; a law that
fades is refused.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.engines.mujoco import options
from refdem.scene import Body, Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.slider import Slider

COULOMB = {"lambda0": "0", "lambda1": "0", "mu1": "2/5", "gamma": "0"}


@pytest.mark.parametrize(
    "given", [{"x0": "2"}, {"x0": "2", "belt": "-0.5"}, {"x0": "5", "belt": "0.25"}], ids=str
)
@pytest.mark.parametrize("method", ["rk4", "euler"])
def test_a_mass_on_a_belt_is_carried_and_let_go(played, given, method):
    instance = discovery.case("stick-slip").at(**COULOMB, **given, duration="8", samples="8")
    seen, _ = played(instance.scene, duration=8.0, samples=8, step=2.0**-10, method=method)
    truth = instance.truth()
    for row, t in enumerate(seen.t):
        assert seen.position[row, 0, 0] == pytest.approx(
            float(truth.at(Fraction(float(t)))["x"].mid), abs=5e-3
        )


def test_a_mass_that_sticks_is_the_nearer_to_rest_on_its_belt_the_shorter_the_step(played):
    """A contact of too large an impedance lifts it at short steps, and it slips by 1e-5."""
    instance = discovery.case("stick-slip").at(**COULOMB, x0="2", duration="6", samples="24")
    truth = instance.truth()
    errors = []
    for step in (2.0**-12, 2.0**-14):
        seen, _ = played(instance.scene, duration=6.0, samples=24, step=step, method="rk4")
        values = [float(truth.at(Fraction(float(t)))["v"].mid) for t in seen.t]
        errors.append(float(np.max(np.abs(seen.velocity[:, 0, 0] - values))))
    coarse, fine = errors
    # Order 2 while it slides and sticks: a quarter of the step, at most a quarter of the error.
    assert fine < coarse / 4 < 1e-7


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)])
def test_it_is_carried_at_the_speed_of_the_belt(played, axis):
    """From rest, friction 0.5 x 8 N takes 2 kg to 1 m/s in half a second."""
    belt = Slider(a=0, friction=0.5, normal_force=8.0, belt_velocity=1.0, axis=axis)
    seen, _ = played(Scene.of([Body(mass=2.0, position=(0.5, 0.0, 0.0))], [belt]), step=2.0**-10)
    along = seen.velocity[:, 0] @ np.array(axis)
    assert along[2] == pytest.approx(0.5, abs=2e-3)
    np.testing.assert_allclose(along[8:], 1.0, atol=1e-7)
    np.testing.assert_allclose(
        (seen.position[-1, 0] - seen.position[0, 0]) @ np.array(axis), 1.75, atol=1e-3
    )


@pytest.mark.parametrize(
    ("bodies", "elements", "words"),
    [
        (
            [Body(mass=1.0)],
            [Slider(a=0, normal_force=1.0, law="stribeck", mu0=0.4)],
            "depends on speed",
        ),
        (
            [Body(mass=1.0, velocity=(0.0, 1.0, 0.0))],
            [Slider(a=0, normal_force=1.0, friction=0.4, belt_velocity=1.0)],
            "other than along x",
        ),
    ],
    ids=str,
)
def test_the_missing_feature_is_named(engine, bodies, elements, words):
    problem = Motion(Scene.of(bodies, elements), np.linspace(0.0, 1.0, 5))
    assert words in (engine.unsupported_motion(problem, engine.methods[0]) or "")


def test_the_stribeck_law_is_refused_by_every_method(engine):
    problem = discovery.case("stick-slip").at().problem
    assert all(engine.unsupported_motion(problem, method) for method in engine.methods)


@pytest.mark.parametrize(("friction", "bound"), [("1/2", 1e-4), ("3/4", 1e-3), ("9/10", 1e-4)])
def test_a_block_slides_or_stays_and_does_not_hop(played, friction, bound):
    instance = discovery.case("block-on-slope").at(friction=friction, duration="1")
    seen, _ = played(instance.scene, duration=1.0, step=2.0**-10)
    slides = max(0.0, 9.8125 * (0.6 - 0.8 * float(Fraction(friction))))
    np.testing.assert_allclose(seen.position[:, 0, 0], slides * seen.t**2 / 2, atol=bound)
    assert np.abs(seen.position[:, 0, 1] - 0.125).max() < 8 * 9.8125 * 2.0**-20


def test_the_hard_contact_throws_up_what_slides(played, monkeypatch):
    """Why sliding contacts are soft: it leaves the ground at about mu v, and four times shorter
    steps do not mend it.
    """
    monkeypatch.setattr("refdem.engines.mujoco.contacts.rubs", lambda scene, law: False)
    scene = discovery.case("block-on-slope").at(friction="1/2", duration="1").scene
    heights = [
        played(scene, duration=1.0, step=2.0**-k, samples=64, method="euler")[0]
        .position[:, 0, 1]
        .max()
        - 0.125
        for k in (8, 10)
    ]
    assert min(heights) > 0.01


def test_shapes_in_touch_feel_each_other_from_the_first_step(played, monkeypatch):
    """What is put down stays; without the margin it falls for a step, and slides g sin(slope) h^2
    until friction has caught it.
    """
    monkeypatch.setattr("refdem.engines.mujoco.contacts.rubs", lambda scene, law: False)
    scene = discovery.case("block-on-slope").at(friction="9/10", duration="1").scene
    moved = np.abs(played(scene, duration=1.0, step=2.0**-8, method="euler")[0].position[-1, 0, 0])
    monkeypatch.setattr("refdem.engines.mujoco.solver.ROUNDING", 0.0)
    free = np.abs(played(scene, duration=1.0, step=2.0**-8, method="euler")[0].position[-1, 0, 0])
    assert moved < 1e-7
    assert free == pytest.approx(9.8125 * 0.6 * 2.0**-16, rel=0.05)


def test_a_scene_at_rest_on_the_level_keeps_the_hardest_contact():
    from refdem.engines.mujoco.contacts import rubs

    scene = discovery.case("newtons-first-law").at(member="stack").scene
    assert not rubs(scene, scene.all(Contact)[0])


@pytest.mark.parametrize(("friction", "least", "most"), [("3/4", 2.5, 5.0), ("0.76", 50.0, 500.0)])
def test_creep_where_friction_just_holds_is_what_noslip_leaves(
    played, monkeypatch, friction, least, most
):
    """Three times the iterations: a third of the creep where friction is needed whole (1/n), far
    less where some is to spare.
    """
    instance = discovery.case("block-on-slope").at(friction=friction, duration="1")
    creep = []
    for iterations in (30, 90):
        monkeypatch.setattr(options, "NOSLIP", iterations)
        seen, _ = played(instance.scene, duration=1.0, step=2.0**-10, method="euler")
        creep.append(float(seen.velocity[-1, 0, 0]))
    assert least < creep[0] / creep[1] < most
