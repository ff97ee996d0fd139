"""A dashpot whose fluid turns: its power, what it brings in, what is refused, its pictures."""

import numpy as np
import pytest

from refdem.core.problem import Motion
from refdem.core.symmetry import Symmetry
from refdem.errors import SceneError
from refdem.scene import Body, Scene
from refdem.scene.elements.rotating_dashpot import RotatingDashpot

FLUID = RotatingDashpot(a=0, damping=0.5, rate=(0.0, 0.0, 3.0), anchor_b=(1.0, 0.0, 0.0))


def power(element: RotatingDashpot, place: list[float], velocity: list[float]) -> float:
    found = element.power(np.zeros(1), np.array([[place]]), np.array([[velocity]]))
    return float(found[0])


def test_what_moves_with_the_fluid_gets_nothing_and_what_is_slower_is_pushed() -> None:
    """At (1, 2) beside the axis the fluid moves with W (-2, 0): v = (-2, 0) is pushed by c 4."""
    assert power(FLUID, [2.0, 2.0, 0.0], [-6.0, 3.0, 0.0]) == 0.0
    assert power(FLUID, [1.0, 2.0, 0.0], [-2.0, 0.0, 0.0]) == 0.5 * 4.0 * 2.0
    assert power(FLUID, [1.0, 0.0, 0.0], [-2.0, 1.0, 0.0]) == -0.5 * 5.0


def test_it_drives_only_where_it_turns_and_is_a_dashpot_from_outside() -> None:
    assert FLUID.drives
    assert FLUID.external
    assert not FLUID.conservative
    assert RotatingDashpot(a=0, damping=0.0).conservative
    assert not RotatingDashpot(a=0, damping=0.5).drives
    assert not RotatingDashpot(a=0, damping=0.0, rate=(0.0, 0.0, 1.0)).drives
    assert FLUID.features() == {"rotating_dashpot", "dashpot"}


@pytest.mark.parametrize(
    ("fields", "fault"),
    [
        ({"damping": -1.0}, "damping is -1.0, expected >= 0"),
        ({"damping": 1.0, "b": 1}, "b is 1, expected -1"),
        ({"damping": 1.0, "anchor_a": (1.0, 0.0, 0.0)}, "anchor_a is not 0"),
    ],
)
def test_what_is_no_fluid_about_a_point_is_refused(fields: dict[str, object], fault: str) -> None:
    with pytest.raises(SceneError, match=fault):
        Scene.of([Body(mass=1.0), Body(mass=1.0)], [RotatingDashpot(a=0, **fields)])  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("rate", "dimension"),
    [((0.0, 0.0, 0.0), 1), ((0.0, 0.0, 3.0), 2), ((1.0, 0.0, 0.0), 3)],
)
def test_a_fluid_that_turns_takes_a_motion_along_a_line_out_of_it(
    rate: tuple[float, float, float], dimension: int
) -> None:
    body = Body(mass=1.0, position=(1.0, 0.0, 0.0))
    scene = Scene.of([body], [RotatingDashpot(a=0, damping=1.0, rate=rate)])
    assert f"dimension:{dimension}" in scene.features


def test_its_picture_turns_as_bodies_do() -> None:
    """A mirror turns it the other way; a quarter turn about z takes (1, 2, 3) to (-2, 1, 3)."""
    scene = Scene.of([Body(mass=1.0)], [RotatingDashpot(a=0, damping=2.0, rate=(1.0, 2.0, 3.0))])
    motion = Motion(scene, np.array([0.0, 1.0]))

    def rate(by: Symmetry) -> tuple[float, ...]:
        (element,) = by.applied(motion).scene.all(RotatingDashpot)
        return element.rate

    assert rate(Symmetry(mirrored=True)) == (1.0, -2.0, -3.0)
    quarter = np.array([1.0, 0.0, 0.0, 1.0]) / np.sqrt(2.0)
    np.testing.assert_allclose(rate(Symmetry(turn=quarter)), [-2.0, 1.0, 3.0], atol=1e-15)
    assert rate(Symmetry(units=(3.0, 5.0, 4.0))) == (0.25, 0.5, 0.75)
