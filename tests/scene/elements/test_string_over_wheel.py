"""The string over a wheel: energy of the wheel, refusals, and how symmetries and JSON carry it."""

import numpy as np
import pytest

from refdem.core import balance, symmetry
from refdem.core.discovery import case
from refdem.core.trajectory import Trajectory
from refdem.errors import SceneError
from refdem.scene import Body, Scene
from refdem.scene.elements.string_over_wheel import StringOverWheel


def test_the_wheel_turns_with_the_string_and_its_energy_counts():
    scene = case("pendulum-wheel-mass").at(wheel_radius="1/2", wheel_inertia="3").scene
    velocity = np.array([[[1.0, 0.0, 0.0], [0.0, 4.0, 0.0]]])
    run = Trajectory.of_points(np.zeros(1), scene.bodies.position[None], velocity)
    assert balance.kinetic(scene, run) == pytest.approx(
        [0.5 * 1 + 0.5 * 1.5 * 16 + 0.5 * 3 * (4 / 0.5) ** 2]
    )


def test_symmetries_carry_centre_radius_and_inertia():
    instance = case("pendulum-wheel-mass").at()
    string = instance.scene.elements[0]
    shift = symmetry.Symmetry(shift=np.array([1.0, 2.0, 0.0]), units=(2.0, 3.0, 1.0), reverse=True)
    moved = shift.applied(instance.problem).scene.elements[0]
    assert (moved.a, moved.b, moved.centre) == (1, 0, (3.0, 6.0, 0.0))
    assert (moved.radius, moved.inertia) == pytest.approx((3 * string.radius, 18 * string.inertia))


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"radius": -1.0}, "radius"),
        ({"inertia": 1.0}, "a point does not turn"),
        ({"b": -1}, "the world"),
        ({"b": 0}, "two different"),
        ({"b": 2}, "joins bodies"),
    ],
)
def test_what_no_string_joins_is_refused(given, word):
    with pytest.raises(SceneError, match=word):
        Scene.of([Body(mass=1.0), Body(mass=1.0)], [StringOverWheel(**({"a": 0, "b": 1} | given))])
