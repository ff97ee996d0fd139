"""Rods one below the other as nested hinges: against the reference, in any order of bodies, with
their forces; what stays refused.
"""

import msgspec
import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.engines.mujoco.unsupported import unsupported
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

TIMES = np.linspace(0.0, 1.0, 9)
DOWN = UniformGravity(g=(0.0, -9.8125, 0.0))


def chain(reverse=False):
    """Three bobs below (0.5, 1, 0), and one more beside them; the bodies in one order or the
    other.
    """
    angles = np.array([1.0, -2.0, 3.0])
    lengths = np.array([1.0, 0.5, 0.75])
    rates = np.array([0.5, 3.0, -2.0])
    places = np.add(
        np.cumsum(
            lengths[:, None] * np.stack([np.sin(angles), -np.cos(angles), 0 * angles], 1), axis=0
        ),
        (0.5, 1.0, 0.0),
    )
    speeds = np.cumsum(
        (lengths * rates)[:, None] * np.stack([np.cos(angles), np.sin(angles), 0 * angles], 1),
        axis=0,
    )
    bobs = [
        Body(mass=m, position=tuple(r), velocity=tuple(v))
        for m, r, v in zip((1.0, 3.0, 0.5), places.tolist(), speeds.tolist(), strict=True)
    ]
    rods = [
        Rod(
            a=i,
            b=i - 1,
            length=float(lengths[i]),
            anchor_b=(0.5, 1.0, 0.0) if i == 0 else (0.0, 0.0, 0.0),
        )
        for i in range(3)
    ]
    bodies = [*bobs, Body(mass=2.0, position=(3.0, 0.0, 0.0))]
    elements = [
        *rods,
        Rod(a=3, length=1.0, anchor_b=(3.0, 1.0, 0.0)),
        DOWN,
    ]
    if not reverse:
        return Scene.of(bodies, elements)
    turned = [
        msgspec.structs.replace(rod, a=3 - rod.a, b=3 - rod.b if rod.b >= 0 else -1)
        for rod in elements[:4]
    ]
    return Scene.of(bodies[::-1], [DOWN, *turned[::-1]])


@pytest.mark.parametrize("reverse", [False, True])
def test_motion_and_forces_are_those_of_the_reference(engine, reverse):
    problem = Motion(chain(reverse), TIMES)
    run, _ = engine.run(Request(problem=problem, method="rk4", step=1 / 8192))
    if not reverse:
        bobs = [0, 1, 2]
    else:
        bobs = [3, 2, 1]
    exact, _ = ENGINE.run(Request(problem=Motion(_alone(), TIMES), method="rod-chain"))
    assert np.abs(run.position[:, bobs] - exact.position).max() < 3e-10
    assert np.abs(run.velocity[:, bobs] - exact.velocity).max() < 4e-9
    if not reverse:
        forces = run.channels["rod_force"][:, :3]
    else:
        forces = run.channels["rod_force"][:, :0:-1]
    assert np.abs(forces - exact.channels["rod_force"]).max() < 1e-7


def _alone():
    """The chain without the bob beside it."""
    scene = chain()
    return Scene.of(scene.bodies.single()[:3], [*scene.elements[:3], DOWN])


def changed(number, **fields):
    scene = chain()
    return Scene(
        scene.bodies,
        tuple(
            msgspec.structs.replace(e, **fields) if i == number else e
            for i, e in enumerate(scene.elements)
        ),
    )


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (chain(), None),
        (changed(0, b=2, anchor_b=(0.0, 0.0, 0.0)), "soft constraints"),
        (Scene(chain().bodies, (*chain().elements, Rod(a=2, b=3, length=1.0))), "soft constraints"),
        (changed(1, length=2.0), "off the rod"),
        (changed(1, anchor_b=(0.1, 0.0, 0.0)), "centre"),
    ],
)
def test_rods_that_are_no_chain_from_the_world_are_refused(scene, reason):
    said = unsupported(Motion(scene, TIMES))
    assert said is None if reason is None else reason in str(said)
