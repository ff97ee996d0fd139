"""A string over a wheel: certified truth, energy, a machine at rest, Atwood's acceleration, sides
of the wheel, refusals.
"""

import msgspec
import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import mechanical
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.errors import UnsupportedError
from refdem.scene import Body, Scene
from refdem.scene.elements.string_over_wheel import StringOverWheel
from refdem.scene.elements.uniform_gravity import UniformGravity

T = np.linspace(0.0, 1.0, 9)
QUANTITIES = ("r", "rdot", "thetadot")
SETS = [
    {},
    {"wheel_radius": "0", "wheel_inertia": "0", "counter_mass": "3"},
    {
        "wheel_radius": "1/3",
        "wheel_inertia": "1/5",
        "mass": "2",
        "counter_mass": "7/3",
        "theta0": "-1",
        "rdot0": "1/2",
        "thetadot0": "2",
    },
]


def machine(**given):
    return discovery.case("pendulum-wheel-mass").at(**given).scene


@pytest.mark.parametrize("given", SETS)
def test_motion_is_right_to_round_off(solved, largest_error, given):
    run = solved(machine(**given), 0.25 * np.arange(5), "string-wheel")
    assert largest_error("pendulum-wheel-mass", run, QUANTITIES, **given) < 1e-13


@pytest.mark.parametrize("given", SETS)
def test_energy_with_that_of_the_wheel_stays(solved, given):
    scene = machine(**given)
    run = solved(scene, np.linspace(0.0, 5.0, 33), "string-wheel")
    energy = mechanical(scene, run)
    assert np.ptp(energy) < 1e-12
    wheel = scene.elements[0]
    without = energy - wheel.kinetic(scene, run.velocity)
    assert bool(np.ptp(without) > 1e-2) is (wheel.inertia > 0)


def hanging(pendulum=1.0, counter=1.0, speed=0.0, **wheel):
    """Straight down on both sides."""
    string = StringOverWheel(a=0, b=1, **({"radius": 0.5, "inertia": 0.25} | wheel))
    bodies = [
        Body(mass=pendulum, position=(string.radius, -2.0, 0.0), velocity=(0.0, -speed, 0.0)),
        Body(mass=counter, position=(-string.radius, -1.0, 0.0), velocity=(0.0, speed, 0.0)),
    ]
    return Scene.of(bodies, [string, UniformGravity(g=(0.0, -8.0, 0.0))])


def test_equal_masses_stay_where_they_are(solved):
    run = solved(hanging(), (0.0, 100.0), "string-wheel")
    assert np.array_equal(run.position[1], run.position[0])


def test_unequal_masses_that_hang_straight_fall_with_the_acceleration_of_atwoods_machine(solved):
    # (m - M) g/(m + M + J/R^2) = (3 - 1) 8/(3 + 1 + 1) = 3.2
    run = solved(hanging(pendulum=3.0), T, "string-wheel")
    assert run.position[:, 0, 1] == pytest.approx(-2.0 - 1.6 * T**2, abs=1e-14)
    assert run.position[:, 1, 1] == pytest.approx(-1.0 + 1.6 * T**2, abs=1e-14)
    assert run.velocity[:, 1, 1] == pytest.approx(3.2 * T, abs=1e-14)


def test_the_string_keeps_its_length_round_the_wheel(solved):
    scene = machine(**SETS[2])
    run = solved(scene, np.linspace(0.0, 3.0, 49), "string-wheel")
    x = run.position[:, 0, 0]
    y = run.position[:, 0, 1]
    r = np.sqrt(x**2 + y**2 - 1 / 9)
    contact = np.unwrap(
        np.arctan2(y, x) + np.arctan2(r, 1 / 3)
    )  # where the string leaves the wheel
    length = r - contact / 3 - run.position[:, 1, 1]
    assert length == pytest.approx(np.full(49, length[0]), abs=1e-13)


def test_the_pendulum_may_hang_on_either_side(solved):
    scene = machine(**SETS[2])
    flipped = Scene.of(
        [
            msgspec.structs.replace(
                b,
                position=(-b.position[0], *b.position[1:]),
                velocity=(-b.velocity[0], *b.velocity[1:]),
            )
            for b in scene.bodies.single()
        ],
        scene.elements,
    )
    plain = solved(scene, T, "string-wheel")
    other = solved(flipped, T, "string-wheel")
    assert other.position == pytest.approx(plain.position * [-1.0, 1.0, 1.0], abs=1e-15)


def test_backwards_and_forwards_meet(solved):
    scene = machine()
    forward = solved(scene, T, "string-wheel")
    back = solved(
        scene.with_state(position=forward.position[-1], velocity=forward.velocity[-1]),
        T[::-1],
        "string-wheel",
    )
    assert back.position[-1] == pytest.approx(forward.position[0], abs=1e-13)


def test_a_pendulum_drawn_onto_the_wheel_is_an_error_with_its_time():
    from refdem.core.problem import Request

    with pytest.raises(UnsupportedError, match=r"contact with the wheel: .*before t = 0\.6"):
        ENGINE.run(
            Request(
                problem=Motion(machine(counter_mass="3"), np.linspace(0.0, 1.0, 6)),
                method="string-wheel",
            )
        )


def test_a_pendulum_drawn_straight_up_onto_the_wheel_is_an_error_too():
    from refdem.core.problem import Request

    instance = discovery.case("pendulum-wheel-mass").at(mass="1/3", theta0="0", samples="16")
    with pytest.raises(UnsupportedError, match=r"before t = 0\."):
        ENGINE.run(Request(problem=instance.problem, method="string-wheel"))


def changed(scene, *, element=None, **columns):
    if columns:
        bodies = scene.bodies.with_state(**columns)
    else:
        bodies = scene.bodies
    return Scene(bodies, (element or scene.elements[0], *scene.elements[1:]))


STILL = hanging()


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (STILL, None),
        (hanging(speed=1.0), None),
        (Scene(STILL.bodies, STILL.elements[:1]), "no gravity"),
        (Scene(STILL.bodies, STILL.elements[1:]), "no elements of kind string_over_wheel"),
        (
            changed(STILL, position=np.add(STILL.bodies.position, [(0, 0, 0), (0.1, 0, 0)])),
            "straight down",
        ),
        (changed(STILL, velocity=np.array([(0.0, 0, 0), (1.0, 0, 0)])), "straight down"),
        (changed(STILL, velocity=np.array([(0.0, 1, 0), (0.0, 1, 0)])), "do not share"),
        (changed(STILL, position=np.array([(0.25, 0, 0), (-0.5, -1, 0)])), "on the wheel"),
        (changed(STILL, velocity=np.array([(0.0, 0, 1), (0.0, 0, 0)])), "plane"),
    ],
)
def test_what_does_not_fit_the_string_is_refused(scene, reason):
    unsupported = ENGINE.unsupported_motion(Motion(scene, T), ENGINE.method("string-wheel"))
    assert unsupported is None if reason is None else reason in str(unsupported)


@pytest.mark.parametrize(("share", "fits"), [(0.9e-9, True), (1.2e-9, False)])
def test_a_start_may_be_off_by_a_billionth_of_the_lengths_of_the_string(share, fits):
    # From the wheel to the pendulum 2 m, the radius 1/2 m, and from the axis to the counterweight.
    extent = 2.0 + 0.5 + np.hypot(0.5, 1.0)
    off = [(0.0, 0.0, 0.0), (share * extent, 0.0, 0.0)]
    scene = changed(STILL, position=np.add(STILL.bodies.position, off))
    unsupported = ENGINE.unsupported_motion(Motion(scene, T), ENGINE.method("string-wheel"))
    assert (unsupported is None) == fits
