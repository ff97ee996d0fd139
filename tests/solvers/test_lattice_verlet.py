"""Verlet on a lattice: the way back is exact, the error has order two, and energy stays where it
was.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity


def oscillator(*more, x=1.0, v=0.25, **spring):
    return Scene.of(
        [Body(mass=2.0, position=(x, 0.0, 0.0), velocity=(v, 0.0, 0.0))],
        [Spring(a=0, b=-1, stiffness=3.0, **spring), *more],
    )


SCENES = {
    "harmonic": oscillator(),
    "hertz": oscillator(exponent=1.5),
    "duffing": oscillator(cubic=2.0, x=-0.75),
    "softening": oscillator(cubic=-1.0, x=0.5),  # beyond |x| = sqrt(3) its potential falls for ever
    "heavy": oscillator(UniformGravity(g=(-9.8125, 0.0, 0.0))),
}


@pytest.mark.parametrize("name", SCENES)
def test_the_way_back_ends_in_the_bits_of_the_start(solved, name):
    scene = SCENES[name]
    there = solved(scene, (0.0, 1024.0), "lattice-verlet", 2.0**-6)
    back = solved(
        scene.with_state(position=there.position[-1], velocity=-there.velocity[-1]),
        (0.0, 1024.0),
        "lattice-verlet",
        2.0**-6,
    )
    assert np.array_equal(back.position[-1], scene.bodies.position)
    assert np.array_equal(back.velocity[-1], -scene.bodies.velocity)
    assert not np.array_equal(there.position[-1], scene.bodies.position)


def test_error_falls_with_order_two(solved):
    times = np.arange(9) * 1.0
    exact = solved(SCENES["harmonic"], times, "exact-harmonic").position
    errors = [
        np.abs(solved(SCENES["harmonic"], times, "lattice-verlet", 2.0**-k).position - exact).max()
        for k in (5, 6, 7)
    ]
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(2.0, abs=0.02)


def test_energy_wanders_no_farther_than_roundings_of_the_lattice_add_up_to(solved):
    h = 2.0**-6
    scene = SCENES["harmonic"]
    run = solved(scene, np.arange(0, 2**14 + 1, 64.0), "lattice-verlet", h)
    x = run.position[:, 0, 0]
    v = run.velocity[:, 0, 0]
    square = 1.5
    kept = v * v + square * x * x * (
        1 - square * h * h / 4
    )  # what Verlet keeps of a harmonic oscillator
    assert np.abs(kept / kept[0] - 1).max() < 2.0**-53 * 12 * np.sqrt(
        2**21
    )  # 2^21 kicks and drifts, each off by half a unit


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (oscillator(Dashpot(a=0, b=-1, damping=0.1)), "more than a spring"),
        (oscillator(length=0.5), "length"),
        (oscillator(quadratic=1.0, x=0.5), "square"),
        (oscillator(cubic=-2.0, x=3.0), "no bound"),
        (oscillator(x=0.0, v=0.0), "rest"),
    ],
)
def test_what_has_no_lattice_is_refused(scene, reason):
    assert reason in ENGINE.unsupported_motion(
        Motion(scene, np.array([0.0, 1.0])), ENGINE.method("lattice-verlet")
    )


def test_a_case_runs_on_it():
    instance = discovery.case("harmonic-oscillator").at()
    assert ENGINE.unsupported(instance.problem, ENGINE.method("lattice-verlet")) is None
