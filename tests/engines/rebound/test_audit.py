"""The audit of defaults says what the installed REBOUND comes with and what the adapter sets."""

import numpy as np
import pytest
import rebound

from refdem.core.problem import Motion, Request
from refdem.engines.rebound import ENGINE
from refdem.engines.rebound.fields import fields_of
from refdem.engines.rebound.simulation import simulation_of
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring

POINT = Body(mass=7.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 1.0, 0.0))


def made(scene: Scene, method: str, **control: float) -> rebound.Simulation:
    """The simulation of a run of 4 samples in 2 s."""
    request = Request(problem=Motion(scene, np.linspace(0.0, 2.0, 5)), method=method, **control)
    return simulation_of(request, fields_of(scene))[0]


def test_rebound_comes_with_what_the_audit_says():
    sim = rebound.Simulation()
    assert (sim.gravity, sim.G, sim.softening, sim.testparticle_type, sim.dt) == (
        "basic",
        1.0,
        0.0,
        0,
        0.001,
    )
    assert (
        sim.collision,
        sim.boundary,
        sim.exact_finish_time,
        sim.force_is_velocity_dependent,
    ) == ("none", "none", 1, 0)
    assert (str(sim.integrator), sim.integrator.epsilon, sim.integrator.min_dt) == (
        "ias15",
        1e-9,
        0.0,
    )
    assert "PRS23" in repr(sim.integrator)
    sim.integrator = "whfast"
    assert (sim.integrator.safe_mode, sim.integrator.corrector) == (1, 0)
    sim.integrator = "leapfrog"
    assert sim.integrator.order == 2
    sim.integrator = "bs"
    assert (
        sim.integrator.eps_rel,
        sim.integrator.eps_abs,
        sim.integrator.min_dt,
        sim.integrator.max_dt,
    ) == (1e-8, 1e-8, 0.0, 0.0)


def test_a_central_field_is_a_first_particle_and_bodies_are_test_particles():
    sim = made(Scene.of([POINT], [CentralField(gm=3.0)]), "whfast")
    assert (sim.gravity, sim.N, sim.N_active, sim.testparticle_type) == ("basic", 2, 1, 0)
    assert (sim.particles[0].m, sim.particles[1].m, sim.dt) == (3.0, 0.0, 0.5)


def test_bodies_do_not_attract_each_other_without_one():
    sim = made(Scene.of([POINT], [Spring(a=0, stiffness=1.0)]), "leapfrog-8", step=0.125)
    assert (sim.gravity, sim.N, sim.integrator.order, sim.dt) == ("none", 1, 8, 0.125)


@pytest.mark.parametrize(
    ("element", "mode", "velocities"),
    [
        (Spring(a=0, stiffness=1.0), "GLOBAL", 0),
        (Rod(a=0, length=1.0), "GLOBAL", 1),
        (CentralField(gm=1.0), "PRS23", 0),
    ],
)
def test_ias15_takes_its_steps_from_all_particles_where_there_are_springs_or_rods(
    element, mode, velocities
):
    sim = made(Scene.of([POINT], [element]), "ias15")
    assert f"adaptive_mode={mode}" in repr(sim.integrator)
    assert sim.force_is_velocity_dependent == velocities


def test_bs_gets_the_tolerance_twice():
    sim = made(Scene.of([POINT]), "bs", tolerance=1e-5)
    assert (sim.integrator.eps_rel, sim.integrator.eps_abs) == (1e-5, 1e-5)


def test_every_setting_is_named_once():
    names = [line.setting for line in ENGINE.audit]
    assert len(names) == len(set(names))


@pytest.mark.parametrize(("method", "search"), [("leapfrog", "direct"), ("leapfrog-line", "line")])
def test_hard_spheres_are_rebound_s_own_collisions_and_nothing_else_collides(method, search):
    comes_with = rebound.Simulation()
    assert comes_with.minimum_collision_velocity == 0.0
    balls = [
        Body(mass=1.0, position=(3.0 * n, 0.0, 0.0), shape=Sphere(radius=0.5 + n)) for n in (0, 1)
    ]
    sim = made(Scene.of(balls, [Contact(law="rigid", restitution=0.5)]), method, step=0.25)
    assert sim.collision == search
    assert sim.rand_seed == 1
    assert [particle.r for particle in sim.particles] == [0.5, 1.5]
    soft = made(Scene.of(balls, [Contact(law="linear", stiffness=1.0)]), "leapfrog", step=0.25)
    assert soft.collision == "none"
