"""Belts and friction that falls with the speed are beyond MuJoCo's sliders, and the refusal says so."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.scene import Body, Scene
from refdem.scene.elements.slider import Slider


@pytest.mark.parametrize(("slider", "words"), [
    (Slider(a=0, normal_force=1.0, law="stribeck", mu0=0.4), "depends on the speed"),
    (Slider(a=0, normal_force=1.0, friction=0.4, belt_velocity=1.0), "ground at rest"),
], ids=str)  # fmt: skip
def test_the_missing_feature_is_named(slider, words):
    engine = discovery.engine("mujoco")
    problem = Motion(Scene.of([Body(mass=1.0)], [slider]), np.linspace(0.0, 1.0, 5))
    assert words in (engine.refusal(problem, engine.methods[0]) or "")


def test_stick_slip_is_refused_by_every_method():
    engine, problem = discovery.engine("mujoco"), discovery.case("stick-slip").at().problem
    assert all(engine.refusal(problem, method) for method in engine.methods)
