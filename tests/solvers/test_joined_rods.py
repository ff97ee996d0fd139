"""Points on rods that springs join: truth to round-off, springs that act as a gravity, order of
bodies, reversal, refusals.
"""

import numpy as np
import pytest
from msgspec.structs import replace

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.errors import EngineError
from refdem.planning.in_process import truth_of
from refdem.scene import Body, Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

G = 9.8125
CASE = discovery.case("coupled-pendulums")
SETTINGS = [
    {},
    {"masses": "1,3", "lengths": "1,1/2", "spring_length": "0", "stiffness": "5"},
    {"theta0": "1,-2", "thetadot0": "3,1"},
    {"masses": "1/100,1", "stiffness": "100", "spring_length": "1/2"},
]


@pytest.mark.parametrize("given", SETTINGS)
def test_two_pendulums_that_a_spring_joins_are_right_to_round_off(given):
    instance = CASE.at(**given)
    truth = truth_of(instance)
    assert ENGINE.best(instance.problem).name == "joined-rods"
    run, _ = ENGINE.run(Request(problem=instance.problem, method="joined-rods"))
    for name, values in instance.observe(run).items():
        error = np.abs(values[: truth.until] - truth.value(name)) / instance.quantities[name].scale
        assert np.all(error < 2e-14 * truth.growth())


def test_the_rods_pull_as_stepping_on_the_rods_says():
    problem = CASE.at(masses="1,3", theta0="3/4,-1", duration="4").problem
    series, _ = ENGINE.run(Request(problem=problem, method="joined-rods"))
    errors = []
    for parts in (64, 128):
        request = Request(problem=problem, method="rattle", step=problem.interval / parts)
        stepped, _ = ENGINE.run(request)
        errors.append(np.abs(stepped.channels["rod_force"] - series.channels["rod_force"]).max())
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


def hanging(*springs, angle=0.75, mass=2.0):
    """A point on a rod of 1 m, and springs."""
    bob = Body(mass=mass, position=(np.sin(angle), -np.cos(angle), 0.0))
    return Scene.of([bob], [Rod(a=0, length=1.0), *springs, UniformGravity(g=(0.0, -G, 0.0))])


def pulled(depth, stiffness):
    """A spring without length from the point to a place below the pivot."""
    return Spring(a=0, stiffness=stiffness, anchor_b=(0.0, -depth, 0.0))


def test_a_spring_to_a_place_below_the_pivot_is_as_much_gravity_as_its_stiffness_and_depth(solved):
    """Its moment is k D l sin(theta), and gravity's m g l sin(theta); at the pivot it has none."""
    times = np.linspace(0.0, 10.0, 11)
    depth, stiffness, mass = 3.0, 5.0, 2.0
    heavier = Scene.of(
        [Body(mass=mass, position=(np.sin(0.75), -np.cos(0.75), 0.0))],
        [Rod(a=0, length=1.0), UniformGravity(g=(0.0, -G - stiffness * depth / mass, 0.0))],
    )
    expected = solved(heavier, times, "rod-chain")
    run = solved(hanging(pulled(depth, stiffness), mass=mass), times, "joined-rods")
    np.testing.assert_allclose(run.position, expected.position, rtol=0, atol=1e-13)
    np.testing.assert_allclose(run.velocity, expected.velocity, rtol=0, atol=1e-12)
    # The spring pulls along the rod, too: k (D cos(theta) - l).
    down = -expected.position[:, 0, 1]
    extra = stiffness * (depth * down - 1.0) - stiffness * depth * down
    tension = expected.channels["rod_force"][:, 0] + extra
    np.testing.assert_allclose(run.channels["rod_force"][:, 0], tension, rtol=0, atol=1e-11)


def test_bodies_may_stand_in_another_order_than_their_rods(solved):
    scene = CASE.at(masses="1,3", theta0="3/4,-1/2").scene
    columns = zip(scene.bodies.mass[::-1], scene.bodies.position[::-1], strict=True)
    bodies = [Body(mass=float(mass), position=tuple(place)) for mass, place in columns]
    rods = [replace(rod, a=1 - rod.a) for rod in scene.all(Rod)]
    springs = [replace(spring, a=1, b=0) for spring in scene.all(Spring)]
    swapped = Scene.of(bodies, [*rods, *springs, *scene.all(UniformGravity)])
    plain = solved(scene, (0.0, 1.0, 2.0), "joined-rods")
    run = solved(swapped, (0.0, 1.0, 2.0), "joined-rods")
    np.testing.assert_allclose(run.position[:, ::-1], plain.position, rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        run.channels["rod_force"], plain.channels["rod_force"], rtol=0, atol=1e-12
    )


def test_the_motion_runs_back_to_its_start(solved):
    scene = CASE.at(theta0="3/4,-1/2").scene
    there = solved(scene, (0.0, 8.0), "joined-rods")
    bodies = [
        Body(mass=1.0, position=tuple(place), velocity=tuple(velocity))
        for place, velocity in zip(there.position[-1], there.velocity[-1], strict=True)
    ]
    back = solved(Scene.of(bodies, scene.elements), (8.0, 0.0), "joined-rods")
    np.testing.assert_allclose(back.position[-1], scene.bodies.position, rtol=0, atol=1e-12)


def reason(scene):
    """Why the method refuses a scene; None if it does not."""
    problem = Motion(scene, np.array([0.0, 1.0]))
    return ENGINE.unsupported(problem, ENGINE.method("joined-rods"))


def test_it_says_what_it_cannot_run():
    assert reason(CASE.at().scene) is None
    assert "spring" in reason(discovery.case("pendulum").at().scene)
    cubic = Spring(a=0, stiffness=1.0, cubic=2.0, anchor_b=(0.0, -3.0, 0.0))
    assert "not linear" in reason(hanging(cubic))
    double = discovery.case("double-pendulum").at().scene
    chained = Scene(double.bodies, (*double.elements, Spring(a=0, b=1, stiffness=1.0)))
    assert "joins two points" in reason(chained)
    stretched = Scene.of(
        [Body(mass=1.0, position=(2.0, 0.0, 0.0))], [Rod(a=0, length=1.0), pulled(3.0, 1.0)]
    )
    assert "starts 2.0 long" in reason(stretched)


def test_a_spring_that_shrinks_to_nothing_ends_the_motion_with_a_reason():
    instance = CASE.at(theta0="-1/2,1/2", spring_length="1/4", duration="4")
    assert truth_of(instance).until < len(instance.times)
    with pytest.raises(EngineError, match="shrinks to nothing"):
        ENGINE.run(Request(problem=instance.problem, method="joined-rods"))
