"""The moved pivot: place and velocity by its law, its clock, what it refuses."""

import numpy as np
import pytest

from refdem.errors import SceneError
from refdem.scene import Body, Scene
from refdem.scene.elements.moving_anchor import MovingAnchor

ANCHOR = MovingAnchor(
    a=0, anchor_b=(1.0, 2.0, 3.0), amplitude=0.5, frequency=4.0, phase=0.3, axis=(0.6, 0.0, 0.8)
)
T = np.array([0.0, 0.7, 5.0])


def test_the_velocity_is_the_slope_of_the_place():
    h = 1e-6
    slope = (ANCHOR.place(T + h) - ANCHOR.place(T - h)) / (2 * h)
    assert ANCHOR.velocity(T) == pytest.approx(slope, abs=1e-8)
    assert ANCHOR.place(T)[0] == pytest.approx([1 + 0.3 * np.cos(0.3), 2.0, 3 + 0.4 * np.cos(0.3)])


def test_a_motion_that_begins_later_has_the_same_pivot():
    assert ANCHOR.delayed(2.0).place(T + 2.0) == pytest.approx(ANCHOR.place(T), abs=1e-14)
    assert ANCHOR.delayed(0.0) is ANCHOR


def test_it_drives_from_outside_and_is_a_constraint():
    scene = Scene.of([Body(mass=1.0)], [MovingAnchor(a=0, amplitude=0.0, frequency=1.0)])
    assert scene.is_driven()
    assert not scene.is_conservative()
    assert not scene.is_isolated()
    assert {"moving_anchor", "constraint"} <= scene.features


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"frequency": -1.0}, "frequency"),
        ({"axis": (1.0, 1.0, 0.0)}, "axis"),
        ({"b": 1}, "law of time"),
        ({"anchor_a": (1.0, 0.0, 0.0)}, "anchor_a"),
    ],
)
def test_what_is_no_law_of_time_is_refused(change, word):
    with pytest.raises(SceneError, match=word):
        Scene.of(
            [Body(mass=1.0)] * 2,
            [MovingAnchor(**({"a": 0, "amplitude": 1.0, "frequency": 1.0} | change))],
        )
