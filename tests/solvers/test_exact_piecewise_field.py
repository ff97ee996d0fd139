"""A piecewise linear field in closed form: against certified truth, there and back, turned in
space.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE

STARTS = [
    {},
    {"x0": "3/4", "v0": "-1"},
    {"x0": "1", "v0": "-3", "samples": "200"},
    {"x0": "-1/2", "v0": "0"},
    {"x0": "-1/2", "v0": "-3/4", "mass": "2"},
    {"x0": "1", "v0": "-1/8"},
    {"x1": "-1/100", "x2": "100", "x0": "-1", "v0": "3"},
]


@pytest.mark.parametrize("given", STARTS)
def test_it_agrees_with_certified_truth(given, largest_error):
    seen = ENGINE.run(
        Request(
            problem=discovery.case("asymmetric-field").at(**given).problem, method="exact-piecewise"
        )
    )[0]
    assert largest_error("asymmetric-field", seen, ("x", "v"), **given) < 2e-14


def test_what_is_gained_forward_is_lost_backward():
    instance = discovery.case("asymmetric-field").at()
    there = ENGINE.run(Request(problem=instance.problem, method="exact-piecewise"))[0]
    scene = instance.scene.with_state(position=there.position[-1], velocity=-there.velocity[-1])
    back = ENGINE.run(Request(problem=Motion(scene, instance.times), method="exact-piecewise"))[0]
    assert there.velocity[-1, 0, 0] ** 2 == pytest.approx(1 + 2 * 0.75, rel=1e-14)
    assert np.abs(back.position[-1] - instance.scene.bodies.position).max() < 1e-14
    assert back.velocity[-1, 0, 0] == pytest.approx(-1.0, rel=1e-14)


def test_at_rest_at_the_far_edge_it_stays():
    instance = discovery.case("asymmetric-field").at(x0="1/4")
    scene = instance.scene.with_state(
        position=np.array([[0.5, 0.0, 0.0]]), velocity=np.zeros((1, 3))
    )
    seen = ENGINE.run(Request(problem=Motion(scene, instance.times), method="exact-piecewise"))[0]
    assert np.ptp(seen.position) == 0.5
    assert not seen.velocity.any()


def test_motion_across_the_axis_is_refused():
    instance = discovery.case("asymmetric-field").at()
    scene = instance.scene.with_state(velocity=np.array([[1.0, 1.0, 0.0]]))
    assert "across" in ENGINE.unsupported_motion(
        Motion(scene, instance.times), ENGINE.method("exact-piecewise")
    )
