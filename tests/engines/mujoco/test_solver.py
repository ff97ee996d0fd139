"""MuJoCo softens every constraint by at least mjMINVAL a kilogram: what is too heavy for that is
refused, and would be wrong.
"""

import sys

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.engines.mujoco import solver
from refdem.engines.mujoco.unsupported import heaviest, unsupported
from refdem.scene import Body, Scene, Sphere, box
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.uniform_gravity import UniformGravity

MODULE = sys.modules[unsupported.__module__]


def soft_pair(mass):
    """Two spheres of so many kg that touch, one of them coming at 1 m/s; k/m is 100/s^2 always."""
    own = {"mass": mass, "inertia": (0.4 * mass,) * 3, "shape": Sphere(radius=1.0)}
    bodies = [Body(**own), Body(**own, position=(2.0, 0.0, 0.0), velocity=(-1.0, 0.0, 0.0))]
    return Scene.of(bodies, [Contact(law="linear", stiffness=100.0 * mass)])


def test_a_contact_is_right_up_to_the_mass_at_which_it_is_refused_and_wrong_from_there_on(
    played, monkeypatch
):
    """Half of the speed is passed on by 1 - cos(w t), with w^2 = 2 k/m: the same at any mass."""
    passed_on = -0.5 * (1 - np.cos(np.sqrt(200.0) * 0.125))

    def lost(mass):
        trajectory, _ = played(soft_pair(mass), step=2.0**-13, duration=0.125)
        return trajectory.velocity[-1, 0, 0] / passed_on - 1

    # Two spheres have half of the mass of one as their effective mass.
    limit = heaviest(solver.ANY)
    assert lost(1.0) == pytest.approx(0.0, abs=1e-9)
    assert lost(1.99 * limit) == pytest.approx(0.0, abs=1e-9)
    heavy = Motion(soft_pair(2.01 * limit), np.arange(3) / 8)
    assert "mjMINVAL" in unsupported(heavy)
    monkeypatch.setattr(MODULE, "_of_soft_constraints", lambda scene: None)
    assert abs(lost(20 * limit)) > 0.1
    assert abs(lost(1e64)) == 1.0


def block_at_rest(mass):
    """A cube of so many kg at rest on the ground."""
    cube = Body(
        mass=mass,
        inertia=(mass / 6,) * 3,
        shape=box(1.0, 1.0, 1.0),
        position=(0.0, 0.0, 0.5),
    )
    law = Contact(law="rigid", friction=0.5)
    ground = Plane(normal=(0.0, 0.0, 1.0))
    return Scene.of([cube], [ground, law, UniformGravity(g=(0.0, 0.0, -9.8))])


def test_a_block_sinks_no_deeper_for_its_mass_up_to_that_at_which_it_is_refused(
    played, monkeypatch
):
    def sunk(mass):
        trajectory, _ = played(block_at_rest(mass), step=2.0**-10, duration=1.0)
        return abs(trajectory.position[-1, 0, 2] - 0.5)

    limit = heaviest(solver.HARDEST)
    assert sunk(0.99 * limit) == pytest.approx(sunk(1.0), rel=1e-3)
    heavy = Motion(block_at_rest(1.01 * limit), np.arange(3) / 8)
    assert "mjMINVAL" in unsupported(heavy)
    monkeypatch.setattr(MODULE, "_of_soft_constraints", lambda scene: None)
    assert sunk(100 * limit) > 10 * sunk(1.0)


@pytest.mark.parametrize(
    ("slider", "impedance"),
    [
        (Slider(a=0, friction=0.5, normal_force=1.0), solver.HARDEST),
        (Slider(a=0, friction=0.5, normal_force=1.0, belt_velocity=1.0), solver.BELT),
    ],
    ids=["joint", "belt"],
)
def test_dry_friction_of_too_much_mass_is_refused(engine, slider, impedance):
    def reason(mass):
        scene = Scene.of([Body(mass=mass, position=(1.0, 0.0, 0.0))], [slider])
        return unsupported(Motion(scene, np.arange(3) / 8))

    assert reason(0.99 * heaviest(impedance)) is None
    assert "mjMINVAL" in reason(1.01 * heaviest(impedance))


def test_the_heavy_spheres_of_a_prescribed_path_are_refused(engine):
    problem = discovery.case("impact-benchmarks").at(member="contact-path", friction="0").problem
    reasons = [engine.unsupported(problem, engine.method(name)) for name in ("rk4", "euler")]
    assert all("mjMINVAL" in reason for reason in reasons)


def test_what_is_round_slides_and_rolls_at_any_step_and_is_not_lifted(played):
    """With the ratio of impedances of MuJoCo's default what slides leaves the plane at steps below
    mu v d/g (here 1e-4 s), and hops; a finer step must be better, and stay down.
    """
    instance = discovery.case("rolling").at(duration="1/4", friction="1/2", samples="16")
    ends = []
    for step in (2.0**-10, 2.0**-13, 2.0**-16):
        trajectory, _ = played(instance.scene, step=step, duration=0.25)
        # While it slides; at first the contact takes on the weight.
        assert np.abs(trajectory.velocity[8:, 0, 1]).max() <= 1e-7
        ends.append(trajectory.velocity[-1, 0, 0])
    # It rolls at 5/7 of 4 m/s from t = 2 v/(7 mu g) = 0.233 s on.
    errors = np.abs(np.array(ends) - 20 / 7)
    assert errors[0] < 1e-2
    assert errors[2] < errors[1] < errors[0]
