"""The reference refuses a motion before it runs, or not at all: motions that end where their scene
has no law for what follows.
"""

import ast
from pathlib import Path

import numpy as np
import pytest

from refdem import solvers
from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

FILES = sorted(Path(solvers.__file__).parent.glob("*.py"))
DRAWS = 40


def of(method, scene, times):
    """The reason why a method refuses a motion, or None."""
    return ENGINE.unsupported_motion(Motion(scene, np.asarray(times, float)), ENGINE.method(method))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_no_solver_refuses_while_it_runs(path):
    raised = {
        name.id
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Raise) and node.exc is not None
        for name in ast.walk(node.exc)
        if isinstance(name, ast.Name)
    }
    assert "UnsupportedError" not in raised


def wheels(rng):
    """Pendulums on a wheel with numbers within a factor of 2 of the defaults, for 20 tau."""
    case = discovery.case("pendulum-wheel-mass")
    drawn = ("mass", "counter_mass", "wheel_radius", "r0", "theta0")
    given = {}
    for parameter in case.parameters:
        if parameter.name in drawn:
            value = float(parameter.parsed(parameter.default)) * 2.0 ** rng.uniform(-1.0, 1.0)
            given[parameter.name] = f"{value:.3g}"
    return case.at(**given).problem


def springs(rng):
    """A point on a spring with a quadratic and a cubic part of any sign, relaxed away from its
    anchor, and a dashpot.
    """
    quadratic, cubic = rng.uniform(-1.0, 1.0, 2)
    spring = Spring(
        a=0, stiffness=1.0, length=rng.uniform(0.5, 4.0), quadratic=quadratic, cubic=cubic
    )
    place = spring.length + rng.uniform(-0.4, 0.8)
    point = Body(mass=1.0, position=(place, 0.0, 0.0), velocity=(rng.uniform(-1.0, 1.0), 0.0, 0.0))
    scene = Scene.of([point], [spring, Dashpot(a=0, damping=rng.uniform(0.0, 0.5))])
    return Motion(scene, np.linspace(0.0, rng.choice([-10.0, 10.0]), 21))


@pytest.mark.parametrize("draw", [wheels, springs], ids=lambda draw: draw.__name__)
def test_drawn_motions_are_refused_before_the_run_or_run_to_the_end(draw):
    rng = np.random.default_rng(7)
    refused = 0
    for _ in range(DRAWS):
        problem = draw(rng)
        for method in ENGINE.methods:
            if method.control != "exact":
                continue
            reason = ENGINE.unsupported(problem, method)
            if reason is None:
                run, _ = ENGINE.run(Request(problem=problem, method=method.name))
                assert np.isfinite(run.position).all()
            elif "before t = " in reason:
                refused += 1
    assert 0 < refused < DRAWS


def test_the_time_told_is_that_of_the_end():
    # x'' = x^3 from x = 1 with x' = 1/sqrt(2) is x = 1/(1 - t/sqrt(2)): infinite at t = sqrt(2).
    spring = Spring(a=0, stiffness=0.0, cubic=-1.0)
    point = Body(mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.5**0.5, 0.0, 0.0))
    scene = Scene.of([point], [spring])
    assert of("taylor-oscillator", scene, np.linspace(0.0, 1.375, 12)) is None
    reason = of("taylor-oscillator", scene, np.linspace(0.0, 3.0, 25))
    assert reason == "the motion goes to infinity before t = 1.5 s"


def anchored(x0, damping=0.0):
    """A point of 1 kg on a damped spring of 1 N/m and a length of 1 m, x0 from its anchor."""
    spring = Spring(a=0, stiffness=1.0, length=1.0)
    dashpot = Dashpot(a=0, damping=damping)
    return Scene.of([Body(mass=1.0, position=(x0, 0.0, 0.0))], [spring, dashpot])


@pytest.mark.parametrize("method", ["exact-linear", "taylor-oscillator"])
@pytest.mark.parametrize(("x0", "passes"), [(1.99, False), (2.0001, True), (2.5, True)])
def test_an_anchor_that_is_passed_between_two_samples_is_seen(method, x0, passes):
    # Without loss to speak of the point comes to 1 - (x0 - 1) = 2 - x0 from its anchor.
    scene = anchored(x0, damping=1e-9)
    samples = [0.0, 2 * np.pi, 4 * np.pi]
    reason = of(method, scene, samples)
    assert ("passes the anchor" in str(reason)) == passes
    assert of(method, scene, [0.0, 2.25]) is None
    backwards = of(method, scene, [0.0, -2 * np.pi])
    assert ("passes the anchor" in str(backwards)) == passes


def test_an_anchor_is_passed_by_a_spring_with_a_length_alone():
    spring = Spring(a=0, stiffness=1.0)
    scene = Scene.of(
        [Body(mass=1.0, position=(2.5, 0.0, 0.0))], [spring, Dashpot(a=0, damping=0.1)]
    )
    assert of("exact-linear", scene, [0.0, 10.0]) is None


def machine(r0, u):
    """A pendulum that hangs straight down, drawn up at -u against a counterweight of a third."""
    from refdem.scene.elements.string_over_wheel import StringOverWheel

    bob = Body(mass=3.0, position=(0.0, -r0, 0.0), velocity=(0.0, -u, 0.0))
    counter = Body(mass=1.0, position=(0.0, -5.0, 0.0), velocity=(0.0, u, 0.0))
    gravity = UniformGravity(g=(0.0, -8.0, 0.0))
    return Scene.of([bob, counter], [StringOverWheel(a=0, b=1, radius=0.0), gravity])


def test_a_pendulum_that_goes_past_its_wheel_between_two_samples_is_refused():
    # u' = (3 - 1) 8/4 = 4 m/s^2: it rises by u^2/8 = 2 m and is back after 2 s.
    assert of("string-wheel", machine(2.125, -4.0), [0.0, 2.0]) is None
    reason = of("string-wheel", machine(1.875, -4.0), [0.0, 2.0])
    assert reason == "contact with the wheel: the pendulum is drawn onto it before t = 2 s"
