"""Forces that Chipmunk asks for in every step, against certified truth: soft contacts and springs,
fields and dashpots.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core.balance import angular, linear
from refdem.core.problem import Motion
from refdem.engines.pymunk import ENGINE
from refdem.engines.pymunk import run as running
from refdem.engines.pymunk.callbacks import CONTACT
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.plane import Plane
from tests.engines.accuracy import STRENGTHS, largest_error, misread

METHOD = ENGINE.methods[0]
OBLIQUE = {"damping": "0", "angle": "1/2", "masses": "1,3", "radii": "1/2,3/4"}
DAMPED = {"damping": "1"}
SPINNING = DAMPED | {
    "angle": "-3/4",
    "masses": "1,1/8",
    "spins": "0,0,1,0,0,-2",
    "cutoff": "zero_force",
}
SETTINGS = [
    ("two-spheres", {}),
    ("two-spheres", DAMPED),
    ("two-spheres", DAMPED | {"cutoff": "zero_force"}),
    ("two-spheres", {"cutoff": "zero_force", "damping": "8"}),
    ("two-spheres", OBLIQUE),
    ("two-spheres", SPINNING),
    ("hertz-spheres", {}),
    ("hertz-spheres", {"effective_mass": "2", "closing_speed": "1/8"}),
    ("power-oscillator", {}),
    ("power-oscillator", {"exponent": "3", "stiffness": "2", "amplitude": "3/4"}),
    ("duffing", {"beta": "-1/4", "duration": "4"}),
    ("quadratic-response", {"duration": "4"}),
    ("van-der-pol", {"mu": "3/4", "duration": "4"}),
    ("two-body-orbit", {"eccentricity": "1/4", "gm": "2", "duration": "4"}),
    ("asymmetric-field", {}),
    ("asymmetric-field", {"v0": "-1", "x0": "5/4"}),
]


@pytest.mark.parametrize(("case", "given"), SETTINGS, ids=str)
def test_a_force_by_callback_is_that_of_certified_truth_at_first_order(case, given):
    """A jump of the force between two steps scatters the observed order, so that two halvings are
    looked at together.
    """
    coarse = largest_error(ENGINE, METHOD, case, given, 256)
    fine = largest_error(ENGINE, METHOD, case, given, 1024)
    assert fine < 1e-2
    assert np.log2(coarse / fine) / 2 == pytest.approx(1, abs=0.35)


OF_LAWS = STRENGTHS | {CONTACT: (1, 3)}


def plant(monkeypatch, factor, strengths=OF_LAWS):
    """Runs in which the strengths of every law are `factor` times what they should be."""
    right = running.space_of

    def planted(scene, **given):
        space, bodies, laws = right(scene, **given)
        wrong = [
            replace(law, numbers=misread(law.numbers, strengths[law.kind], factor)) for law in laws
        ]
        return space, bodies, wrong

    monkeypatch.setattr(running, "space_of", planted)


@pytest.mark.parametrize("factor", [-1.0, 0.5])
@pytest.mark.parametrize(
    ("case", "given"),
    [
        ("two-body-orbit", {"duration": "4"}),
        ("asymmetric-field", {}),
        ("van-der-pol", {"mu": "3/4", "duration": "4"}),
        ("quadratic-response", {"duration": "4"}),
        ("two-spheres", OBLIQUE),
        ("two-spheres", DAMPED),
        ("hertz-spheres", {}),
        ("duffing", {"duration": "1/2"}),
    ],
)
def test_a_wrong_sign_or_factor_of_a_force_shows(monkeypatch, case, given, factor):
    plant(monkeypatch, factor)
    assert largest_error(ENGINE, METHOD, case, given, 1024) > 2e-2


def test_a_dashpot_that_is_never_switched_on_shows(monkeypatch):
    plant(monkeypatch, 0.0, {CONTACT: (3,)})
    assert largest_error(ENGINE, METHOD, "two-spheres", DAMPED, 1024) > 3e-2


def meeting(count, **law):
    """Discs in a row, of unequal masses and radii, that spin and run into each other off centre."""
    bodies = [
        Body(
            mass=1.0 + n,
            inertia=(0.1 * (1 + n),) * 3,
            position=(1.3 * n, 0.2 * n * n, 0.0),
            velocity=(1.0 - n, 0.1 * n, 0.0),
            omega=(0.0, 0.0, 2.0 - n),
            shape=Sphere(radius=0.5 + 0.05 * n),
        )
        for n in range(count)
    ]
    return Scene.of(bodies, [Contact(stiffness=500.0, **law)])


@pytest.mark.parametrize("count", [2, 3, 4])
@pytest.mark.parametrize(
    "law", [{"law": "linear"}, {"law": "linear", "damping": 3.0}, {"law": "hertz"}]
)
def test_soft_contacts_keep_momentum_and_angular_momentum_to_round_off(run, count, law):
    scene = meeting(count, **law)
    assert METHOD.keeps("momentum", scene.features)
    assert METHOD.keeps("angular-momentum", scene.features)
    moved = run(scene, 2.0, 32, 2.0**-8)
    exchanged = np.abs(moved.velocity - moved.velocity[0]).max()
    assert exchanged > 0.5
    total = linear(scene, moved)
    assert np.abs(total - total[0]).max() < 1e-13
    turn = angular(scene, moved)["total"]
    assert np.abs(turn - turn[0]).max() < 1e-12


def test_a_dashpot_on_a_body_that_turns_leaves_its_turning_alone(run):
    body = Body(mass=2.0, inertia=(1.0,) * 3, velocity=(1.0, 0.0, 0.0), omega=(0.0, 0.0, 0.75))
    moved = run(Scene.of([body], [Dashpot(a=0, damping=0.5)]), 2.0, 8, 2.0**-12)
    np.testing.assert_allclose(moved.velocity[:, 0, 0], np.exp(-0.25 * moved.t), atol=1e-3)
    assert np.ptp(moved.omega[:, 0, 2]) == 0


@pytest.mark.parametrize(
    ("law", "more", "words"),
    [
        (
            {"friction": 0.25},
            [],
            "the engine does not support friction of a contact that has a stiffness",
        ),
        (
            {},
            [Plane(normal=(0.0, 1.0, 0.0))],
            "the engine does not support a soft contact with a wall",
        ),
    ],
)
def test_what_a_spring_cannot_say_of_a_contact_is_refused(law, more, words):
    scene = meeting(2, law="linear", **law)
    problem = Motion(Scene.of(scene.bodies.single(), [*scene.elements, *more]), np.arange(3) / 2)
    assert words in str(ENGINE.unsupported_motion(problem, METHOD))
