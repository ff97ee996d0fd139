"""The force of every element that tells it agrees with its potential, its power and its torque.

Elements are drawn at random from the types of their fields, so that a new one is among them.
"""

from typing import Any

import numpy as np
import pytest

from refdem.scene import Body, Scene
from refdem.scene.acceleration import acceleration
from refdem.scene.dimension import Direction
from refdem.scene.element import Element, Field, Link, types_of
from refdem.scene.elements import KINDS

TELLING = {
    name: kind
    for name, kind in KINDS.items()
    if issubclass(kind, Field) or (issubclass(kind, Link) and kind.has_force)
}
# Both flanks of this field meet where k1 x1 = k2 x2, and x1 < 0.
GIVEN = {"piecewise_field": {"k1": 2.0, "k2": -1.0, "x1": -8.0, "x2": 16.0}}


def element_of(kind: type[Element], rng: np.random.Generator, b: int) -> Element:
    """An element between body 0 and body b, or the world, with numbers between 1/2 and 2."""
    fields: dict[str, Any] = {}
    for name, hint in types_of(kind).items():
        if name not in kind.__struct_fields__ or name.startswith("anchor") or name in ("a", "b"):
            continue
        if hint == Direction:
            axis = rng.normal(size=3)
            fields[name] = tuple((axis / np.linalg.norm(axis)).tolist())
        elif "float" in str(hint) and "tuple" in str(hint):
            fields[name] = tuple(rng.uniform(0.5, 2.0, 3).tolist())
        else:
            fields[name] = float(rng.uniform(0.5, 2.0))
    fields |= GIVEN.get(str(kind.__struct_config__.tag), {})
    if issubclass(kind, Link):
        fields |= {"a": 0, "b": b}
    return kind(**fields)


def scene_of(kind: type[Element], seed: int, b: int) -> Scene | None:
    """Two bodies at random with the element; None if it cannot be between them."""
    rng = np.random.default_rng(seed)
    bodies = [
        Body(mass=m, position=tuple(rng.normal(size=3)), velocity=tuple(rng.normal(size=3)))
        for m in (1.0, 3.0)
    ]
    element = element_of(kind, rng, b)
    if element.faults():
        return None
    return Scene.of(bodies, [element])


def forces_of(scene: Scene, position: np.ndarray) -> np.ndarray:
    """Forces (2, 3) [N] at t = 1/2 s with the velocities of the start."""
    of = acceleration(scene)(0.5, position, scene.bodies.velocity)
    return of * scene.bodies.mass[:, None]


SEEDS = range(3)
ENDS = (-1, 1)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("b", ENDS)
@pytest.mark.parametrize("kind", TELLING)
def test_a_force_does_the_work_that_potential_and_power_say(kind: str, b: int, seed: int) -> None:
    """F . v summed over the bodies is -dV/dt, plus the power of what has no potential."""
    scene = scene_of(TELLING[kind], seed, b)
    if scene is None:
        assert b == 1
        return
    r, v = scene.bodies.position, scene.bodies.velocity
    work = float(np.sum(forces_of(scene, r) * v))
    h = 1e-5
    places = np.array([r + h * v, r - h * v])
    after, before = scene.potential(places, np.tile(scene.bodies.attitude, (2, 1, 1)))
    power = scene.elements[0].power(np.array([0.5]), r[None], v[None])
    assert power is not None
    assert work == pytest.approx(float(power[0]) - (after - before) / (2 * h), abs=1e-7)


@pytest.mark.parametrize("b", ENDS)
@pytest.mark.parametrize("kind", TELLING)
def test_a_torque_about_the_origin_is_there_where_the_element_says_so(kind: str, b: int) -> None:
    """The angular momentum of a pair with a force along a fixed axis was said to be kept."""
    scenes = [scene for seed in SEEDS if (scene := scene_of(TELLING[kind], seed, b)) is not None]
    torques = []
    for scene in scenes:
        r = scene.bodies.position
        torque = np.sum(np.cross(r, forces_of(scene, r)), axis=0)
        torques.append(np.abs(torque).max())
        is_kept = scene.elements[0].torque_reason() is None
        assert is_kept == (np.abs(torque).max() < 1e-12)
    assert torques or b == 1


@pytest.mark.parametrize("kind", TELLING)
def test_a_force_that_reads_velocities_or_the_clock_says_so(kind: str) -> None:
    scene = scene_of(TELLING[kind], 0, -1)
    assert scene is not None
    r, v = scene.bodies.position, scene.bodies.velocity
    of = acceleration(scene)
    element = scene.elements[0]
    reads_velocity = not np.array_equal(of(0.5, r, v), of(0.5, r, 2.0 * v))
    assert reads_velocity == element.reads_velocity
    reads_clock = not np.array_equal(of(0.5, r, v), of(0.75, r, v))
    assert reads_clock == element.reads_clock
