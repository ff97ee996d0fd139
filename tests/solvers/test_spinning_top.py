"""A body on a ball joint: certified truth, a compound pendulum, free bodies, backwards,
refusals.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Body, Scene
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

T = np.linspace(0.0, 1.0, 5)
SETS = [
    {},
    {
        "theta0": "2",
        "phidot0": "-1",
        "thetadot0": "1/2",
        "spin": "-9",
        "inertia": "2,1/3",
        "mass": "3/2",
    },
]


def hung(
    inertia=(1.0, 2.0, 2.5),
    omega=(0.0, 0.0, 0.0),
    turn=0.0,
    anchor=(0.0, 0.0, 0.0),
    gravity=(0.0, 0.0, 0.0),
):
    """A body whose centre is 0.5 along its own third axis from the joint, turned about x."""
    axis = np.array([0.0, -np.sin(turn), np.cos(turn)])
    attitude = (np.cos(turn / 2), np.sin(turn / 2), 0.0, 0.0)
    state = {
        "position": tuple(anchor + 0.5 * axis),
        "velocity": tuple(np.cross(omega, 0.5 * axis)),
        "attitude": attitude,
        "omega": omega,
    }
    joint = BallJoint(a=0, anchor_a=(0.0, 0.0, -0.5), anchor_b=anchor)
    return Scene.of([Body(mass=2.0, inertia=inertia, **state)], [joint, UniformGravity(g=gravity)])


@pytest.mark.parametrize("given", SETS)
def test_tilt_and_its_rate_are_right_to_round_off(solved, largest_error, given):
    run = solved(discovery.case("heavy-top").at(**given).scene, T, "spinning-top")
    assert largest_error("heavy-top", run, ("theta", "thetadot"), **given) < 1e-13


def test_swinging_about_one_axis_it_is_a_compound_pendulum(solved):
    # J_x about the joint 1 + 2/4 = 1.5, m g l = 8: a pendulum of length J/(m l) = 1.5
    run = solved(
        hung(turn=2.0, gravity=(0.0, 0.0, -8.0), anchor=(1.0, 2.0, 3.0)), T, "spinning-top"
    )
    bob = Body(mass=1.0, position=(1.5 * np.sin(np.pi - 2.0), -1.5 * np.cos(np.pi - 2.0), 0.0))
    simple = solved(
        Scene.of([bob], [Rod(a=0, length=1.5), UniformGravity(g=(0.0, -8.0, 0.0))]),
        T,
        "exact-pendulum",
    )
    swing = (run.position[:, 0] - [1.0, 2.0, 3.0]) / 0.5
    assert -swing[:, 1] == pytest.approx(simple.position[:, 0, 0] / 1.5, abs=1e-13)
    assert swing[:, 2] == pytest.approx(simple.position[:, 0, 1] / 1.5, abs=1e-13)


def test_without_gravity_it_is_the_free_body_with_its_moments_about_the_joint(solved):
    run = solved(hung(omega=(0.9, 1.1, 1.3)), T, "spinning-top")
    free = Scene.of([Body(mass=1.0, inertia=(1.5, 2.5, 2.5), omega=(0.9, 1.1, 1.3))])
    assert run.attitude == pytest.approx(solved(free, T, "exact-free-body").attitude, abs=1e-14)


def test_upright_it_stays_to_the_last_bit(solved):
    run = solved(hung(gravity=(0.0, 0.0, -8.0)), (0.0, 10.0), "spinning-top")
    assert np.array_equal(run.position[1], run.position[0])


def drawn_tops(number):
    """Tops with moments and spin up to threefold from the defaults, thick and thin, any tilt."""
    rng = np.random.default_rng(18)
    for _ in range(number):
        transverse = 0.5 * 3.0 ** rng.uniform(-0.5, 1.0)
        # About the centre the axial moment is at most the sum of the transverse ones.
        thickest = 1.9 * (transverse - 0.25)
        axial = min(0.25 * 3.0 ** rng.uniform(-1.0, 1.5), thickest)
        spin = 20.0 * 3.0 ** rng.uniform(-1.0, 1.0)
        theta0 = rng.uniform(0.1, 3.0)
        yield {
            "inertia": f"{transverse:.4g},{axial:.4g}",
            "spin": f"{spin:.4g}",
            "theta0": f"{theta0:.3g}",
        }


def test_drawn_tops_keep_the_angular_momentum_about_the_vertical(solved):
    # Seen: 1e-14 of |L| where the step looks at omega, 1e-12 where at the attitude alone, since
    # omega turns in body axes with the spin and the attitude with half of it.
    for given in drawn_tops(40):
        instance = discovery.case("heavy-top").at(**given)
        transverse, axial = (float(moment) for moment in given["inertia"].split(","))
        run = solved(instance.scene, instance.problem.times, "spinning-top")
        omega_body = rotated(conjugate(run.attitude[:, 0]), run.omega[:, 0])
        about_tip = rotated(run.attitude[:, 0], omega_body * [transverse, transverse, axial])
        size = np.linalg.norm(about_tip[0])
        assert np.abs(about_tip[:, 2] - about_tip[0, 2]).max() < 1e-13 * size, given


def test_backwards_and_forwards_meet(solved):
    scene = discovery.case("heavy-top").at().scene
    run = solved(scene, T, "spinning-top")
    end = {name: getattr(run, name)[-1] for name in ("position", "velocity", "attitude", "omega")}
    back = solved(scene.with_state(**end), T[::-1], "spinning-top")
    assert back.attitude[-1] == pytest.approx(run.attitude[0], abs=1e-13)


TOP = hung(omega=(0.0, 0.0, 3.0))


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (TOP, None),
        (TOP.with_state(position=TOP.bodies.position + 0.1), "open at the start"),
        (TOP.with_state(velocity=TOP.bodies.velocity + 0.1), "moves at the start"),
        (Scene(TOP.bodies, (BallJoint(a=0, anchor_a=(0.1, 0.0, -0.5)),)), "principal axis"),
        (Scene(TOP.bodies, TOP.elements[1:]), "no elements of kind ball_joint"),
        (Scene(TOP.bodies, (*TOP.elements, Rod(a=0, length=0.5))), "rod"),
        (hung(inertia=(0.0, 0.0, 0.0)), "no inertia"),
    ],
)
def test_what_is_no_top_is_refused(scene, reason):
    unsupported = ENGINE.unsupported_motion(Motion(scene, T), ENGINE.method("spinning-top"))
    assert unsupported is None if reason is None else reason in str(unsupported)
