"""The slider's laws, what they say of themselves, and their units."""

import numpy as np
import pytest

from refdem.scene import Body, Scene
from refdem.scene.dimension import Dimension
from refdem.scene.elements.slider import Slider


def test_the_coefficient_follows_the_law():
    numbers = {"mu0": 0.4, "mu1": 0.1, "lambda0": 1.5, "lambda1": 0.25}
    assert Slider(a=0, normal_force=2.0, friction=0.3).coefficient(7.0) == 0.3
    assert Slider(a=0, normal_force=2.0, law="stribeck", **numbers).coefficient(
        2.0
    ) == pytest.approx(0.3 / 4 + 0.1 + 1.0)
    assert Slider(a=0, normal_force=2.0, law="stribeck_linear", **numbers).coefficient(
        2.0
    ) == pytest.approx(0.3 / 4 + 0.1 + 0.5)
    at_rest = Slider(a=0, normal_force=2.0, law="stribeck", **numbers).coefficient(np.zeros(2))
    np.testing.assert_allclose(at_rest, 0.4)


def test_features_name_the_law_and_the_belt():
    assert Slider(a=0, normal_force=1.0).features() == {"slider", "friction"}
    belted = Slider(a=0, normal_force=1.0, law="stribeck", mu0=0.4, belt_velocity=-0.5)
    assert belted.features() == {"slider", "friction", "slider:stribeck", "slider:belt"}
    assert belted.drives
    assert not belted.is_plain


def test_the_unit_of_the_last_term_follows_the_law():
    assert Slider(a=0, normal_force=1.0, law="stribeck").dimension("lambda1") == Dimension(0, -2, 2)
    assert Slider(a=0, normal_force=1.0, law="stribeck_linear").dimension("lambda1") == Dimension(
        0, -1, 1
    )
    assert Slider(a=0, normal_force=1.0).dimension("belt_velocity") == Dimension(0, 1, -1)


def test_negative_numbers_are_faults_and_a_belt_may_run_either_way():
    assert Slider(a=0, normal_force=1.0, belt_velocity=-2.0).faults() == []
    assert "mu1" in Slider(a=0, normal_force=1.0, mu1=-0.1).faults()[0]


def test_it_survives_json():
    scene = Scene.of(
        [Body(mass=1.0)],
        [Slider(a=0, normal_force=1.0, law="stribeck_linear", mu0=0.4, belt_velocity=1.0)],
    )
    assert Scene.from_json(scene.to_json()).elements == scene.elements
