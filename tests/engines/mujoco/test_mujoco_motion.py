"""MuJoCo's motion of what it can say, against formulas and a Runge-Kutta of Euler's equations in
space axes.
"""

import numpy as np
import pytest

from refdem.mechanics.quaternion import matrix
from refdem.scene import Body, Scene, Sphere, box
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

INERTIA = np.array([1.0, 2.0, 2.5])
TURNED = (0.5**0.5, 0.0, 0.5**0.5, 0.0)


def tumbled(duration, steps, omega):
    """Rotation matrix and omega (space axes) of a free body that starts TURNED: R' = omega x R, L
    constant.
    """
    rotation = matrix(np.array(TURNED))
    momentum = rotation @ (INERTIA * (rotation.T @ omega))

    def rate(r):
        w = r @ ((r.T @ momentum) / INERTIA)
        return np.cross(w, r, axisb=0, axisc=0)

    h = duration / steps
    for _ in range(steps):
        k1 = rate(rotation)
        k2 = rate(rotation + h / 2 * k1)
        k3 = rate(rotation + h / 2 * k2)
        rotation = rotation + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(rotation + h * k3))
    return rotation, rotation @ ((rotation.T @ momentum) / INERTIA)


def test_a_turned_body_with_three_moments_tumbles_as_eulers_equations_say(played):
    omega = (0.9, 1.1, -1.3)
    scene = Scene.of(
        [
            Body(
                mass=2.0,
                inertia=tuple(INERTIA),
                attitude=TURNED,
                omega=omega,
                velocity=(1.0, -2.0, 0.5),
            )
        ]
    )
    run, _ = played(scene, step=2.0**-9)
    rotation, end = tumbled(2.0, 2000, np.array(omega))
    np.testing.assert_allclose(matrix(run.attitude[-1, 0]), rotation, atol=1e-9)
    np.testing.assert_allclose(run.omega[-1, 0], end, atol=1e-9)
    np.testing.assert_allclose(run.position[-1, 0], [2.0, -4.0, 1.0], atol=1e-12)


@pytest.mark.parametrize(
    ("method", "order", "powers"),
    [("rk4", 4, (4, 5, 6)), ("euler", 1, (9, 10)), ("implicitfast", 1, (9, 10))],
)
def test_the_attitude_of_a_tumbling_body_converges_at_the_order_claimed(
    played, method, order, powers
):
    """Fourth order since 4.0.0; second before."""
    scene = Scene.of(
        [Body(mass=2.0, inertia=tuple(INERTIA), attitude=TURNED, omega=(0.9, 1.1, -1.3))]
    )
    right, _ = tumbled(2.0, 2000, np.array([0.9, 1.1, -1.3]))
    runs = (played(scene, step=2.0**-k, method=method)[0] for k in powers)
    off = np.array([np.abs(matrix(run.attitude[-1, 0]) - right).max() for run in runs])
    np.testing.assert_allclose(np.log2(off[:-1] / off[1:]), order, atol=0.15)


def errors(played, scene, truth, method, powers):
    """Largest error of x at the end for steps 2**-power."""
    return np.array(
        [
            np.abs(played(scene, step=2.0**-k, method=method)[0].position[-1, 0, 0] - truth)
            for k in powers
        ]
    )


@pytest.mark.parametrize(
    ("method", "order", "powers"),
    [("rk4", 4, (4, 5, 6)), ("euler", 1, (6, 7, 8)), ("implicitfast", 1, (6, 7, 8))],
)
def test_an_oscillator_converges_at_the_order_claimed(played, method, order, powers):
    scene = Scene.of(
        [Body(mass=2.0, position=(1.5, 0.0, 0.0))],
        [Spring(a=0, stiffness=8.0, anchor_b=(0.5, 0.0, 0.0))],
    )
    off = errors(played, scene, 0.5 + np.cos(4.0), method, powers)
    np.testing.assert_allclose(np.log2(off[:-1] / off[1:]), order, atol=0.15)


def test_springs_of_length_and_cubic_springs_pull_as_written(played):
    """A spring at right angles to a displacement x: force k (sqrt(l^2 + x^2) - l0) along it; here
    at the start.
    """
    for exponent in (1, 3):
        spring = Spring(a=0, stiffness=5.0, length=1.0, exponent=exponent, anchor_b=(3.0, 4.0, 0.0))
        run, _ = played(
            Scene.of([Body(mass=1.0)], [spring]), step=2.0**-10, duration=2.0**-9, samples=2
        )
        np.testing.assert_allclose(
            run.velocity[-1, 0] / 2.0**-9,
            5.0 * 4.0**exponent * np.array([0.6, 0.8, 0.0]),
            rtol=2e-4,
        )


def test_a_spring_between_two_bodies_acts_on_both(played):
    bodies = [Body(mass=1.0, position=(-1.0, 0.0, 0.0)), Body(mass=3.0, position=(1.0, 0.0, 0.0))]
    run, _ = played(Scene.of(bodies, [Spring(a=0, b=1, stiffness=0.75, length=1.0)]))
    distance = run.position[:, 1, 0] - run.position[:, 0, 0]
    np.testing.assert_allclose(distance, 1.0 + np.cos(run.t), atol=1e-9)
    np.testing.assert_allclose(run.velocity[:, 0] + 3.0 * run.velocity[:, 1], 0.0, atol=1e-13)


def test_a_spring_to_an_anchor_on_a_turned_body_has_its_lever_arm(played):
    """Force 2 N along y (space) at the arm R(q) (0, 0, 1) = (1, 0, 0): torque 2 N m about z, the
    body's -x axis.
    """
    body = Body(mass=4.0, inertia=(1.0, 2.0, 2.5), attitude=TURNED)
    spring = Spring(
        a=0, stiffness=2.0, length=1.0, anchor_a=(0.0, 0.0, 1.0), anchor_b=(1.0, 2.0, 0.0)
    )
    run, _ = played(Scene.of([body], [spring]), step=2.0**-12, duration=2.0**-11, samples=2)
    np.testing.assert_allclose(run.velocity[-1, 0] * 2.0**11, [0.0, 0.5, 0.0], atol=1e-6)
    np.testing.assert_allclose(run.omega[-1, 0] * 2.0**11, [0.0, 0.0, 2.0], atol=1e-6)


def test_a_pendulum_returns_after_its_period_and_shows_its_tension(played):
    """4 K(sin(theta0/2))/w0 by the arithmetic-geometric mean; tension m (l thetadot^2 + g cos
    theta).
    """
    theta = 2.0
    length = 0.5
    g = 9.8
    a = 1.0
    b = np.cos(theta / 2)
    for _ in range(8):
        a, b = (a + b) / 2, np.sqrt(a * b)
    period = 2 * np.pi / (np.sqrt(g / length) * a)
    anchor = np.array([1.0, 2.0, 0.0])
    bob = Body(
        mass=3.0, position=tuple(anchor + length * np.array([np.sin(theta), -np.cos(theta), 0.0]))
    )
    scene = Scene.of(
        [bob], [Rod(a=0, length=length, anchor_b=tuple(anchor)), UniformGravity(g=(0.0, -g, 0.0))]
    )
    run, _ = played(scene, step=period / 4096, duration=period)
    np.testing.assert_allclose(run.position[-1], run.position[0], atol=1e-9)
    arm = run.position[:, 0] - anchor
    tension = 3.0 * (np.sum(run.velocity[:, 0] ** 2, axis=1) / length - g * arm[:, 1] / length)
    np.testing.assert_allclose(run.channels["rod_force"], tension, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(np.sum(arm**2, axis=1), length**2, rtol=1e-14)


def test_dry_friction_stops_a_sliding_body_where_work_says_and_holds_it(played):
    """x'' = -f/m: it stops after v^2 m/(2 f) = 1 m at t = 1; a pull below the limit does not move
    it.
    """
    scene = Scene.of(
        [Body(mass=2.0, velocity=(2.0, 0.0, 0.0))], [Slider(a=0, friction=0.5, normal_force=8.0)]
    )
    run, _ = played(scene, duration=4.0, step=2.0**-10, method="euler")
    assert abs(run.position[-1, 0, 0] - 1.0) < 2e-3
    assert np.abs(run.velocity[6:]).max() < 1e-15
    pulled = Scene.of(
        [Body(mass=2.0)],
        [Slider(a=0, friction=0.5, normal_force=8.0), UniformGravity(g=(1.9, 0.0, 0.0))],
    )
    assert np.abs(played(pulled, duration=4.0)[0].position).max() < 1e-14


def pressed(position, velocity, stiffness, damping, mass):
    """Relative velocity after two unit-distance spheres part: m r'' = n max(k d + c d', 0), d = 1 -
    |r|, by Runge-Kutta.
    """

    def rate(state):
        r, v = state
        n = r / np.linalg.norm(r)
        overlap = 1.0 - np.linalg.norm(r)
        closing = -v @ n
        return np.array(
            [
                v,
                (
                    n * max(stiffness * overlap + damping * closing, 0.0) / mass
                    if overlap > 0
                    else 0 * n
                ),
            ]
        )

    state = np.array([position, velocity])
    h = 2.0**-13
    for _ in range(4096):
        k1 = rate(state)
        k2 = rate(state + h / 2 * k1)
        k3 = rate(state + h / 2 * k2)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(state + h * k3))
    return state[1]


@pytest.mark.parametrize("across", [0.0, 1.0])
def test_a_damped_collision_bounces_as_the_linear_law_says(played, across):
    """Unequal masses and radii, along a slant; head-on also exp(-b t), t = 2 arccos(b/w0)/w
    (Schwager and Poeschel 2007).
    """
    k = 400.0
    c = 6.0
    m1 = 1.0
    m2 = 3.0
    normal = np.array([0.6, 0.8, 0.0])
    first = 3 * normal + across * np.array([-0.8, 0.6, 0.0])
    spheres = [
        Body(
            mass=m1, position=tuple(-0.4 * normal), velocity=tuple(first), shape=Sphere(radius=0.4)
        ),
        Body(
            mass=m2, position=tuple(0.6 * normal), velocity=tuple(-normal), shape=Sphere(radius=0.6)
        ),
    ]
    scene = Scene.of(spheres, [Contact(law="linear", stiffness=k, damping=c, cutoff="zero_force")])
    expected = pressed(normal, -normal - first, k, c, m1 * m2 / (m1 + m2))
    for method in ("rk4", "implicitfast"):
        run, _ = played(scene, step=2.0**-14, duration=0.5, method=method)
        np.testing.assert_allclose(run.velocity[-1, 1] - run.velocity[-1, 0], expected, atol=4e-3)
        np.testing.assert_allclose(
            m1 * run.velocity[:, 0] + m2 * run.velocity[:, 1],
            np.tile(m1 * first - m2 * normal, (17, 1)),
            atol=1e-13,
        )
    if not across:
        b = c * (m1 + m2) / (2 * m1 * m2)
        w0 = np.sqrt(k * (m1 + m2) / (m1 * m2))
        restitution = np.exp(-b * 2 * np.arccos(b / w0) / np.sqrt(w0**2 - b**2))
        assert abs(expected @ normal / (4 * restitution) - 1) < 1e-3


def test_an_undamped_collision_across_a_slope_keeps_the_sliding_velocity(played):
    spheres = [
        Body(
            mass=1.0, position=(-0.5, 0.0, 0.0), velocity=(2.0, 0.0, 0.0), shape=Sphere(radius=0.5)
        ),
        Body(mass=1.0, position=(0.5, 0.0, 0.0), shape=Sphere(radius=0.5)),
    ]
    run, _ = played(
        Scene.of(spheres, [Contact(law="linear", stiffness=900.0)]), step=2.0**-14, duration=0.5
    )
    np.testing.assert_allclose(run.velocity[-1, :, 0], [0.0, 2.0], atol=4e-3)


@pytest.mark.parametrize(
    "normal",
    [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.6, 0.0, -0.8), (0.0, 0.8, 0.6), (-1.0, 0.0, 0.0)],
)
def test_a_sphere_rests_on_a_plane_of_any_direction_as_deep_as_the_softest_constraint_needs(
    played, normal
):
    """Depth g (1 - 0.9999) (2 h)^2: what the largest impedance and the shortest time constant of
    MuJoCo leave.
    """
    n = np.array(normal)
    h = 2.0**-8
    ball = Body(
        mass=2.0, inertia=(0.2, 0.2, 0.2), position=tuple(0.5 * n), shape=Sphere(radius=0.5)
    )
    scene = Scene.of(
        [ball],
        [
            Plane(normal=normal),
            Contact(law="rigid", friction=0.3),
            UniformGravity(g=tuple(-10.0 * n)),
        ],
    )
    run, _ = played(scene, step=h, duration=4.0)
    depth = 0.5 - run.position[-1, 0] @ n
    assert abs(depth / (10.0 * 1e-4 * (2 * h) ** 2) - 1) < 1e-3


def test_a_stack_of_boxes_stands(played):
    blocks = [
        Body(
            mass=1.0,
            inertia=(0.2, 0.2, 0.2),
            position=(0.0, 0.0, 0.25 + 0.5 * i),
            shape=box(1.0, 1.0, 0.5),
        )
        for i in range(2)
    ]
    scene = Scene.of(
        blocks, [Plane(), Contact(law="rigid", friction=0.5), UniformGravity(g=(0.0, 0.0, -9.8))]
    )
    run, _ = played(scene, duration=4.0, method="implicitfast")
    assert np.abs(run.position[-1] - run.position[0]).max() < 1e-5


def test_a_fixed_body_stays_and_is_hit(played):
    wall = Body(mass=1.0, position=(0.5, 0.0, 0.0), shape=Sphere(radius=0.5), fixed=True)
    ball = Body(
        mass=1.0, position=(-0.5, 0.0, 0.0), velocity=(1.0, 0.0, 0.0), shape=Sphere(radius=0.5)
    )
    run, _ = played(
        Scene.of([wall, ball], [Contact(law="linear", stiffness=900.0)]),
        step=2.0**-13,
        duration=0.5,
    )
    assert np.abs(run.velocity[:, 0]).max() == 0
    assert abs(run.velocity[-1, 1, 0] + 1.0) < 4e-3


def test_a_small_light_pendulum_swings_as_a_large_one_though_mujoco_wants_some_inertia(played):
    """m l^2 = 1e-8 kg m^2, next to which MuJoCo's least inertia of 1e-15 would slow the swing by
    5e-8 of its rate.
    """
    ends = []
    for mass, length, g in ((1.0, 1.0, 1.0), (0.01, 0.001, 0.001)):
        bob = Body(mass=mass, position=(length * np.sin(1.0), -length * np.cos(1.0), 0.0))
        run, _ = played(
            Scene.of([bob], [Rod(a=0, length=length), UniformGravity(g=(0.0, -g, 0.0))]),
            step=2.0**-7,
            duration=16.0,
        )
        ends.append(run.position[-1, 0] / length)
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-11)
