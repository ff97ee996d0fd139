"""Chains of rods in angles: certified truth, RATTLE's rod forces, the work of a moved pivot, what
stands upright, refusals.
"""

import msgspec
import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import mechanical
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene
from refdem.scene.elements.moving_anchor import MovingAnchor
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

DOWN = UniformGravity(g=(0.0, -9.8125, 0.0))
T = np.linspace(0.0, 1.0, 9)


def case_scene(name, **given):
    return discovery.case(name).at(**given).scene


@pytest.mark.parametrize(
    "given", [{}, {"masses": "2,1/3", "lengths": "1/2,3/2", "theta0": "-1,2", "thetadot0": "3,-1"}]
)
def test_double_pendulum_is_right_to_round_off(solved, largest_error, given):
    run = solved(case_scene("double-pendulum", **given), 0.25 * np.arange(5), "rod-chain")
    assert (
        largest_error(
            "double-pendulum", run, ("theta1", "thetadot1", "theta2", "thetadot2"), **given
        )
        < 1e-13
    )


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"length": "3", "gravity": "9.81", "drive_amplitude": "1", "drive": "7", "thetadot0": "1"},
    ],
)
def test_a_moved_pivot_is_right_to_round_off(solved, largest_error, given):
    run = solved(case_scene("kapitza-pendulum", **given), 0.25 * np.arange(9), "rod-chain")
    assert largest_error("kapitza-pendulum", run, ("thetadot",), **given) < 1e-13


def test_one_rod_is_the_closed_form_of_the_pendulum_with_its_force(solved):
    scene = case_scene("pendulum", theta0="3", thetadot0="1")
    chain, closed = (solved(scene, T, method) for method in ("rod-chain", "exact-pendulum"))
    assert chain.position == pytest.approx(closed.position, abs=1e-13)
    assert chain.channels["rod_force"] == pytest.approx(closed.channels["rod_force"], abs=1e-11)


def three():
    """Three bobs that fold over each other."""
    angles = np.array([1.0, -2.0, 3.0])
    lengths = np.array([1.0, 0.5, 0.75])
    rates = np.array([0.5, 3.0, -2.0])
    places = np.cumsum(
        lengths[:, None] * np.stack([np.sin(angles), -np.cos(angles), 0 * angles], 1), axis=0
    )
    speeds = np.cumsum(
        (lengths * rates)[:, None] * np.stack([np.cos(angles), np.sin(angles), 0 * angles], 1),
        axis=0,
    )
    bobs = [
        Body(mass=m, position=tuple(r), velocity=tuple(v))
        for m, r, v in zip((1.0, 3.0, 0.5), places.tolist(), speeds.tolist(), strict=True)
    ]
    return Scene.of(bobs, [*(Rod(a=i, b=i - 1, length=float(lengths[i])) for i in range(3)), DOWN])


def test_a_chain_of_three_and_its_forces_are_what_rattle_tends_to(solved):
    chain = solved(three(), T, "rod-chain")
    errors = []
    for steps in (256, 512):
        stepped = solved(three(), T, "rattle", T[1] / steps)
        errors.append(
            [
                np.abs(chain.position - stepped.position).max(),
                np.abs(chain.channels["rod_force"] - stepped.channels["rod_force"]).max(),
            ]
        )
    assert np.divide(*errors) == pytest.approx([4.0, 4.0], rel=0.02)
    assert max(errors[1]) < 1e-2


def test_order_of_bodies_and_of_rods_does_not_matter(solved):
    scene = three()
    bodies = scene.bodies.single()
    (first, second, third, down) = scene.elements
    turned = Scene.of(
        bodies[::-1],
        [
            down,
            Rod(a=1, b=0, length=third.length),
            Rod(a=2, b=1, length=second.length),
            msgspec.structs.replace(first, a=2),
        ],
    )
    plain = solved(scene, T, "rod-chain")
    other = solved(turned, T, "rod-chain")
    assert np.array_equal(plain.position, other.position[:, ::-1])
    assert plain.channels["rod_force"] == pytest.approx(
        other.channels["rod_force"][:, ::-1], rel=1e-12
    )


def test_backwards_and_forwards_meet(solved):
    forward = solved(three(), T, "rod-chain")
    state = {"position": forward.position[-1], "velocity": forward.velocity[-1]}
    back = solved(three().with_state(**state), T[::-1], "rod-chain")
    assert back.position[-1] == pytest.approx(forward.position[0], abs=1e-12)


def shaken(**anchor):
    """A bob that hangs on a rod of length 1 below a pivot of mass 2 that shakes."""
    given = {
        "amplitude": 0.25,
        "frequency": 8.0,
        "axis": (0.6, 0.8, 0.0),
        "anchor_b": (1.0, 2.0, 0.0),
    } | anchor
    moved = MovingAnchor(a=0, **given)
    place = moved.place(np.zeros(1))[0]
    velocity = moved.velocity(np.zeros(1))[0]
    bob = Body(
        mass=0.5,
        position=tuple(np.add(place, (0.6, -0.8, 0.0))),
        velocity=tuple(np.add(velocity, (0.8, 0.6, 0.0))),
    )
    return Scene.of(
        [Body(mass=2.0, position=tuple(place), velocity=tuple(velocity)), bob],
        [moved, Rod(a=1, b=0, length=1.0), DOWN],
    )


@pytest.mark.parametrize("anchor", [{}, {"phase": 1.0}, {"amplitude": -0.125, "frequency": 3.0}])
def test_work_of_the_pivot_is_the_energy_gained(solved, anchor):
    scene = shaken(**anchor)
    run = solved(scene, T, "rod-chain")
    kinetic = 0.5 * np.sum(scene.bodies.mass[:, None] * run.velocity**2, axis=(1, 2))
    energy = kinetic + scene.potential(run.position, run.attitude)
    assert np.ptp(energy) > 0.1
    assert energy - energy[0] == pytest.approx(-run.channels["dissipated_work"], abs=1e-13)


@pytest.mark.parametrize("drive", [10.0, 300.0, 3e3, 3e4])
def test_work_of_a_fast_pivot_is_the_energy_gained(solved, drive):
    # The pivot shakes by 3/drive, at a speed of 3 m/s: the angle sees little of it, its work all.
    # Seen: 8e-15 of the energies, and up to 7e-10 where the angles alone decide the steps.
    scene = case_scene(
        "kapitza-pendulum", drive=f"{drive:g}", drive_amplitude=f"{3.0 / drive:.17g}"
    )
    times = np.linspace(0.0, 40 * 2 * np.pi / drive, 97)
    run = solved(scene, times, "rod-chain")
    energy = mechanical(scene, run)
    work = run.channels["dissipated_work"]
    assert np.ptp(work) > 1.0
    assert np.abs(energy - energy[0] + work).max() < 1e-13 * np.abs(energy).max()


def test_a_pivot_follows_the_clock_of_the_scene(solved):
    scene = shaken()
    moved, *others = scene.elements
    late = Scene.of(scene.bodies.single(), [moved.delayed(64.0), *others])
    assert late.elements[0].phase == -512.0
    assert solved(late, T + 64.0, "rod-chain").position == pytest.approx(
        solved(scene, T, "rod-chain").position, abs=1e-12
    )


def test_an_accelerated_pivot_without_gravity_pulls_with_mass_times_acceleration(solved):
    moved = MovingAnchor(a=0, amplitude=0.25, frequency=8.0, axis=(0.0, 1.0, 0.0))
    scene = Scene.of(
        [Body(mass=1.0, position=(0.0, 0.25, 0.0)), Body(mass=3.0, position=(0.0, -0.75, 0.0))],
        [moved, Rod(a=1, b=0, length=1.0)],
    )
    run = solved(scene, T, "rod-chain")
    assert run.channels["rod_force"][:, 0] == pytest.approx(
        -3.0 * 0.25 * 64.0 * np.cos(8.0 * T), abs=1e-12
    )


def test_what_stands_upright_stays_to_the_last_bit(solved):
    scene = Scene.of(
        [Body(mass=1.0, position=(0.0, 1.0, 0.0)), Body(mass=2.0, position=(0.0, 3.0, 0.0))],
        [Rod(a=0, length=1.0), Rod(a=1, b=0, length=2.0), DOWN],
    )
    run = solved(scene, (0.0, 10.0, 100.0), "rod-chain")
    assert np.array_equal(run.position, np.repeat(run.position[:1], 3, axis=0))
    assert run.channels["rod_force"][-1] == pytest.approx([-3 * 9.8125, -2 * 9.8125], rel=1e-15)


def changed(scene, *, elements=None, **columns):
    if columns:
        bodies = scene.bodies.with_state(**columns)
    else:
        bodies = scene.bodies
    return Scene(bodies, tuple(elements or scene.elements))


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (three(), None),
        (shaken(), None),
        (changed(three(), elements=[*three().elements, Spring(a=0, stiffness=1.0)]), "spring"),
        (changed(three(), velocity=np.add(three().bodies.velocity, (0.0, 0.0, 1.0))), "plane"),
        (changed(three(), velocity=three().bodies.velocity * [[1], [1], [0]]), "speed along"),
        (changed(three(), position=three().bodies.position * 1.01), "long"),
        (
            changed(three(), elements=[*three().elements, Rod(a=2, length=1.0)]),
            "one below the other",
        ),
        (changed(three(), elements=three().elements[1:]), "one below the other"),
        (changed(shaken(), velocity=np.zeros((2, 3))), None),
        (changed(shaken(phase=1.0), velocity=np.zeros((2, 3))), "law of time"),
        (
            changed(shaken(), position=np.add(shaken().bodies.position, (0.1, 0.0, 0.0))),
            "law of time",
        ),
        (Scene.of([Body(mass=1.0)], [DOWN]), "no elements of kind rod"),
    ],
)
def test_what_is_no_planar_chain_is_refused(scene, reason):
    unsupported = ENGINE.unsupported_motion(Motion(scene, T), ENGINE.method("rod-chain"))
    assert unsupported is None if reason is None else reason in str(unsupported)
