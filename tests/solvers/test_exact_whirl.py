"""The closed form of a mass on a shaft against truth in all regimes, with loads that truth does not
know, backwards, and what it refuses.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.acceleration import acceleration
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

CASE = discovery.case("whirling-shaft")
METHOD = ENGINE.method("exact-whirl")
SETTINGS = [
    {},
    {"turning": "2"},
    {"turning": "3"},
    {"turning": "-300"},
    {"turning": "0", "outer_damping": "3", "inner_damping": "5"},
    {"turning": "1e-12", "outer_damping": "3", "inner_damping": "5"},
    {"inner_damping": "400"},
    {"inner_damping": "4000", "turning": "1/100"},
    {"x0": "0,0", "v0": "3,-1", "mass": "1e6"},
]


@pytest.mark.parametrize("given", SETTINGS, ids=str)
def test_the_motion_is_that_of_truth_to_rounding(given: dict[str, str]) -> None:
    instance = CASE.at(**given)
    run, _ = ENGINE.run(Request(problem=instance.problem, method="exact-whirl"))
    truth = instance.truth()
    observed = instance.observe(run)
    for index, t in enumerate(instance.times):
        exact = truth.at(Fraction(float(t)))
        grown = truth.sensitivity(Fraction(float(t)))
        for name, quantity in instance.quantities.items():
            error = abs(observed[name][index] - float(exact[name].mid)) / quantity.scale
            # 40 rad, or e-folds, of exponents that are rounded once each.
            assert error < 4e-15 * grown


LOADED = Scene.of(
    [Body(mass=2.0, position=(1.0, 0.5, 0.0), velocity=(0.25, -1.0, 0.0))],
    [
        Spring(a=0, stiffness=8.0, anchor_b=(0.5, -0.25, 0.0)),
        Dashpot(a=0, damping=0.5),
        RotatingDashpot(a=0, damping=1.0, rate=(0.0, 0.0, 5.0), anchor_b=(-1.0, 2.0, 0.0)),
        RotatingDashpot(a=0, damping=0.25, rate=(0.0, 0.0, -2.0), anchor_b=(0.0, 1.0, 0.0)),
        UniformGravity(g=(0.5, -3.0, 0.0)),
    ],
)


def run_of(scene: Scene, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    problem = Motion(scene, times)
    assert ENGINE.unsupported(problem, METHOD) is None
    run, _ = ENGINE.run(Request(problem=problem, method="exact-whirl"))
    return run.position, run.velocity


def test_loads_and_axes_elsewhere_give_the_accelerations_of_the_scene() -> None:
    """Central differences over h: of order h^2 w^2, and rounding 1e-16/h."""
    times = np.linspace(0.0, 5.0, 200001)
    position, velocity = run_of(LOADED, times)
    h = times[1] - times[0]
    found = (velocity[2:] - velocity[:-2]) / (2 * h)
    rates = (position[2:] - position[:-2]) / (2 * h)
    accelerations = acceleration(LOADED)
    for index in range(0, len(found), 20000):
        expected = accelerations(0.0, position[index + 1], velocity[index + 1])
        np.testing.assert_allclose(found[index], expected, atol=1e-7)
        np.testing.assert_allclose(rates[index], velocity[index + 1], atol=1e-7)


def test_the_motion_runs_back_to_where_it_began() -> None:
    position, velocity = run_of(LOADED, np.array([0.0, 4.0]))
    end = Body(mass=2.0, position=tuple(position[1, 0]), velocity=tuple(velocity[1, 0]))
    back, speed = run_of(Scene.of([end], LOADED.elements), np.array([4.0, 0.0]))
    np.testing.assert_allclose(back[1], LOADED.bodies.position, atol=1e-13)
    np.testing.assert_allclose(speed[1], LOADED.bodies.velocity, atol=1e-13)


@pytest.mark.parametrize(
    ("elements", "reason"),
    [
        ([Spring(a=0, stiffness=1.0, length=1.0)], "natural length 0"),
        ([Spring(a=0, stiffness=1.0, cubic=1.0)], "natural length 0"),
        ([Spring(a=0, stiffness=-1.0)], "natural length 0"),
        (
            [Spring(a=0, stiffness=1.0), Dashpot(a=0, damping=1.0, van_der_pol=1.0)],
            "the dashpot is not linear",
        ),
        (
            [Spring(a=0, stiffness=1.0), UniformGravity(g=(0.0, 0.0, -1.0))],
            "the motion is not in the plane x-y",
        ),
    ],
)
def test_what_is_not_linear_or_not_in_the_plane_is_refused(elements: list, reason: str) -> None:  # type: ignore[type-arg]
    body = Body(mass=1.0, position=(1.0, 0.0, 0.0))
    fluid = RotatingDashpot(a=0, damping=1.0, rate=(0.0, 0.0, 1.0))
    problem = Motion(Scene.of([body], [*elements, fluid]), np.array([0.0, 1.0]))
    assert reason in str(ENGINE.unsupported(problem, METHOD))
