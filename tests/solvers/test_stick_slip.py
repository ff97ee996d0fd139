"""Stick-slip in the reference: certified truth at every sample, events to the last bits, the
section, and what is refused.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import mechanical
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.engines.reference import ENGINE
from refdem.errors import UnsupportedError
from refdem.scene import Body, Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

METHOD = ENGINE.method("stick-slip")
SHORT = {"duration": "10", "samples": "20"}


def run(problem: Motion) -> Trajectory:
    """A run of the method."""
    return ENGINE.run(Request(problem=problem, method="stick-slip"))[0]


def belted(*more, axis=(1.0, 0.0, 0.0), length=0.0, b=-1, **body) -> Scene:
    """A point on a spring and a belt."""
    slider = Slider(
        a=0,
        b=b,
        normal_force=10.0,
        law="stribeck",
        mu0=0.4,
        mu1=0.1,
        lambda0=1.42,
        lambda1=0.01,
        belt_velocity=1.0,
        axis=axis,
    )
    return Scene.of(
        [Body(mass=1.0, **body)], [Spring(a=0, stiffness=1.0, length=length), slider, *more]
    )


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"friction_law": "linear", "gamma": "2", "eta": "5/4", "x0": "1", "v0": "2"},
        {"a": "4", "mu0": "0.3", "lambda0": "2", "belt": "-0.5", "gamma": "3", "eta": "1.6"},
        {"belt": "0", "gamma": "9", "x0": "2", "v0": "0"},
        {"lambda0": "0", "lambda1": "0", "mu1": "0.4", "gamma": "3"},
        {"eta": "0", "gamma": "-1"},
    ],
    ids=str,
)
def test_every_sample_agrees_with_certified_truth(given, largest_error):
    seen = run(discovery.case("stick-slip").at(**(SHORT | given)).problem)
    assert largest_error("stick-slip", seen, ("x", "v"), **(SHORT | given)) < 4e-14


def test_events_are_those_of_truth_to_the_last_bits():
    instance = discovery.case("stick-slip").at(duration="16", samples="8")
    scalars = instance.truth().scalars()
    events = run(instance.problem).events
    counts = {"stick": 0, "slip": 0}
    for event in events:
        counts[event.kind] += 1
        ball = scalars[f"{event.kind}_{counts[event.kind]}"]
        assert abs(event.time - float(ball.mid)) <= 12 * np.spacing(event.time)
    assert len(events) == len(scalars) == 4


def test_it_sticks_with_exactly_the_velocity_of_the_belt():
    seen = run(discovery.case("stick-slip").at(belt="0.3", duration="20", samples="512").problem)
    assert np.sum(seen.velocity[:, 0, 0] == 0.3) > 200


def test_energy_and_work_add_up():
    instance = discovery.case("stick-slip").at(duration="40")
    seen = run(instance.problem)
    total = mechanical(instance.scene, seen) + seen.channels["dissipated_work"]
    np.testing.assert_allclose(total, total[0], atol=2e-13)


def test_the_axis_may_point_anywhere():
    axis = np.array([2.0, -1.0, 2.0]) / 3
    straight = run(
        Motion(
            belted(Force(a=0, amplitude=0.5, frequency=1.2), position=(0.5, 0, 0)),
            np.linspace(0, 8, 9),
        )
    )
    tilted = belted(
        Force(a=0, amplitude=0.5, frequency=1.2, axis=tuple(axis)),
        axis=tuple(axis),
        position=tuple(0.5 * axis),
    )
    np.testing.assert_allclose(
        run(Motion(tilted, np.linspace(0, 8, 9))).position[:, 0] @ axis,
        straight.position[:, 0, 0],
        atol=1e-13,
    )


def test_the_section_tells_windows_from_chaos():
    instance = discovery.case("stick-slip").at(gamma="0.7")
    found = ENGINE.section(instance.problem, np.array([1.0, 1.2558, 1.5]), skip=100, keep=200)
    assert found.exponent.regimes()[1:].tolist() == ["chaotic", "periodic"]
    assert 0.02 < found.exponent.value[1] < 0.08
    assert all(places.min() > 0 and places.max() < 4 for places in found.places)
    assert len(np.unique(np.round(found.places[2], 6))) == 1
    assert len(np.unique(np.round(found.places[1], 6))) > 100


def test_the_default_drive_makes_no_chaos():
    found = ENGINE.section(
        discovery.case("stick-slip").at().problem, np.linspace(0.95, 1.35, 9), skip=60, keep=100
    )
    assert "chaotic" not in found.exponent.regimes()


def test_a_section_of_another_scene_is_refused():
    with pytest.raises(UnsupportedError, match="no section"):
        ENGINE.section(
            discovery.case("harmonic-oscillator").at().problem, np.array([1.0]), skip=1, keep=1
        )


@pytest.mark.parametrize(
    ("scene", "word"),
    [
        (belted(Dashpot(a=0, damping=0.1)), "dashpot"),
        (belted(length=1.0, position=(1.0, 0.0, 0.0)), "natural length 0"),
        (belted(UniformGravity(g=(0.0, -1.0, 0.0))), "along the slider"),
        (belted(position=(1.0, 0.5, 0.0)), "along the slider"),
        (
            belted(Force(a=0, amplitude=1.0), Force(a=0, amplitude=1.0)),
            "2 elements of kind force; expected at most one",
        ),
        (
            Scene.of([Body(mass=1.0)], [Spring(a=0, stiffness=1.0), Slider(a=0, normal_force=1.0)]),
            "does not hold",
        ),
    ],
    ids=str,
)
def test_what_it_cannot_do_is_refused_in_words(scene, word):
    assert word in (ENGINE.unsupported_motion(Motion(scene, np.linspace(0, 1, 3)), METHOD) or "")


def test_time_does_not_run_backwards():
    assert "backwards" in (
        ENGINE.unsupported_motion(Motion(belted(), np.linspace(1, 0, 3)), METHOD) or ""
    )
