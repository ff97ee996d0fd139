"""Dashpots, periodic forces and springs with a cube in MuJoCo, pymunk and REBOUND: against
formulas, at the order claimed, or refused.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.scene import Body, Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

POINT = Body(mass=2.0, position=(1.0, 0.0, 0.0))
SPRING = Spring(a=0, stiffness=2.0)
DAMPED = Scene.of([POINT], [SPRING, Dashpot(a=0, damping=0.8), UniformGravity(g=(0.5, 0.0, 0.0))])
CUBIC = Scene.of([POINT], [Spring(a=0, stiffness=2.0, cubic=-1.0)])
DRIVEN = Scene.of([POINT], [SPRING, Force(a=0, amplitude=3.0, frequency=2.0, phase=0.5)])
POL = Scene.of(
    [POINT],
    [
        SPRING,
        Dashpot(a=0, damping=-0.5, van_der_pol=0.75),
        Force(a=0, amplitude=3.0, frequency=2.0),
    ],
)
SQUARE = Scene.of(
    [POINT], [Spring(a=0, anchor_b=(-4.0, 0.0, 0.0), length=4.0, stiffness=2.0, quadratic=0.5)]
)


def played(engine, method, scene, step=None, tolerance=None, start=0.0, duration=8.0):
    """The trajectory of one method."""
    times = start + duration * np.arange(17) / 16
    problem = Motion(scene, times)
    adapter = discovery.engine(engine)
    assert adapter.unsupported(problem, adapter.method(method)) is None
    trajectory, _ = adapter.run(
        Request(problem=problem, method=method, step=step, tolerance=tolerance)
    )
    return trajectory


def fading(t):
    """x of DAMPED: about m g/k = 1/2 with delta = 0.2, w0 = 1."""
    w = np.sqrt(0.96)
    return 0.5 + 0.5 * np.exp(-0.2 * t) * (np.cos(w * t) + 0.2 / w * np.sin(w * t))


def swinging(t):
    """x of DRIVEN: w0 = 1, f0 = 3/2, and a start at rest at 1 when t is 0."""
    steady = 1.5 / (1 - 4.0)
    c = np.cos(0.5)
    s = np.sin(0.5)
    return steady * np.cos(2 * t + 0.5) + (1 - steady * c) * np.cos(t) + 2 * steady * s * np.sin(t)


DAMPED_METHODS = [
    ("mujoco", "rk4", 4),
    ("mujoco", "euler", 1),
    ("mujoco", "implicitfast", 1),
    ("pymunk", "semi-implicit-euler", 1),
]


@pytest.mark.parametrize(("engine", "method", "order"), DAMPED_METHODS)
def test_a_dashpot_damps_at_the_order_claimed(engine, method, order):
    errors = []
    for step in (2.0**-6, 2.0**-7):
        run = played(engine, method, DAMPED, step)
        errors.append(np.abs(run.position[:, 0, 0] - fading(run.t)).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)
    assert errors[1] < 1e-8 if order == 4 else errors[1] < 2.0**-7


def test_a_dashpot_in_rebound_is_exact_or_as_good_as_the_tolerance():
    for method, tolerance, bound in (("ias15", None, 1e-13), ("bs", 1e-10, 1e-8)):
        run = played("rebound", method, DAMPED, tolerance=tolerance)
        assert np.abs(run.position[:, 0, 0] - fading(run.t)).max() < bound


@pytest.mark.parametrize(
    ("method", "step", "tolerance", "bound"),
    [("ias15", None, None, 1e-13), ("bs", None, 1e-11, 1e-9)],
)
def test_a_periodic_force_reads_rebounds_clock_also_from_a_later_start(
    method, step, tolerance, bound
):
    run = played("rebound", method, DRIVEN, step, tolerance)
    assert np.abs(run.position[:, 0, 0] - swinging(run.t)).max() < bound
    late = Scene.of(
        [POINT], [SPRING, Force(a=0, amplitude=3.0, frequency=2.0, phase=0.5 - 2.0 * 64.0)]
    )
    delayed = played("rebound", method, late, step, tolerance, start=64.0)
    assert np.abs(delayed.position - run.position).max() < 100 * bound


@pytest.mark.parametrize(
    ("method", "order", "steps"),
    [("leapfrog", 2, (2.0**-5, 2.0**-6)), ("leapfrog-8", 8, (2.0**-1, 2.0**-2))],
)
def test_leapfrog_has_its_order_with_a_periodic_force(method, order, steps):
    errors = [
        np.abs(
            played("rebound", method, DRIVEN, step).position[:, 0, 0] - swinging(np.arange(17) / 2)
        ).max()
        for step in steps
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.3)


def test_a_periodic_force_in_pymunk_is_of_first_order_also_from_a_later_start():
    errors = []
    for step in (2.0**-7, 2.0**-8):
        run = played("pymunk", "semi-implicit-euler", DRIVEN, step)
        errors.append(np.abs(run.position[:, 0, 0] - swinging(run.t)).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(1, abs=0.1)
    assert errors[1] < 2.0**-5
    late = Scene.of(
        [POINT], [SPRING, Force(a=0, amplitude=3.0, frequency=2.0, phase=0.5 - 2.0 * 64.0)]
    )
    delayed = played("pymunk", "semi-implicit-euler", late, 2.0**-8, start=64.0)
    assert np.abs(delayed.position - run.position).max() < 1e-11


@pytest.mark.parametrize(
    ("method", "order", "steps"), [("rk4", 4, (2.0**-4, 2.0**-5)), ("euler", 1, (2.0**-7, 2.0**-8))]
)
def test_a_periodic_force_in_mujoco_is_taken_at_the_time_of_every_stage_also_from_a_later_start(
    method, order, steps
):
    runs = [played("mujoco", method, DRIVEN, step) for step in steps]
    errors = [np.abs(run.position[:, 0, 0] - swinging(run.t)).max() for run in runs]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)
    late = Scene.of(
        [POINT], [SPRING, Force(a=0, amplitude=3.0, frequency=2.0, phase=0.5 - 2.0 * 64.0)]
    )
    delayed = played("mujoco", method, late, steps[1], start=64.0)
    assert np.abs(delayed.position - runs[1].position).max() < 1e-11


@pytest.mark.parametrize("shape", [{}, {"inertia": (1.0, 2.0, 3.0), "omega": (0.3, 0.2, 0.1)}])
def test_a_periodic_force_alone_acts_along_its_axis_in_mujoco_and_is_gone_afterwards(shape):
    """Without springs and dampers MuJoCo leaves out all passive forces, unless it is told not
    to.
    """
    force = Force(a=0, amplitude=3.0, frequency=2.0, phase=0.5, axis=(0.0, 0.6, 0.8))
    body = Body(mass=2.0, position=(1.0, 0.0, 0.0), **shape)
    run = played("mujoco", "rk4", Scene.of([body], [force]), 2.0**-6)
    way = -3.0 / 8.0 * (np.cos(2 * run.t + 0.5) - np.cos(0.5)) - 0.75 * np.sin(0.5) * run.t
    assert run.position[:, 0] == pytest.approx(
        np.stack([1 + 0 * way, 0.6 * way, 0.8 * way], axis=1), abs=2e-8
    )
    after = played("mujoco", "rk4", Scene.of([body], []), 2.0**-6)
    assert np.ptp(after.position, axis=0).max() == 0


def test_springs_with_a_cube_and_a_square_are_those_of_the_reference():
    for scene, engine, method, step in (
        (CUBIC, "mujoco", "rk4", 2.0**-7),
        (CUBIC, "rebound", "ias15", None),
        (SQUARE, "mujoco", "rk4", 2.0**-7),
        (SQUARE, "rebound", "ias15", None),
    ):
        exact = played("reference", "taylor-oscillator", scene)
        run = played(engine, method, scene, step)
        assert run.position == pytest.approx(exact.position, abs=1e-8 if step else 1e-13)
        assert np.ptp(exact.position[:, 0, 0]) > 1.0


def test_van_der_pols_dashpot_and_a_drive_are_those_of_the_reference():
    exact = played("reference", "taylor-oscillator", POL)
    assert played("rebound", "ias15", POL).position == pytest.approx(exact.position, abs=1e-13)
    assert played("mujoco", "rk4", POL, 2.0**-7).position == pytest.approx(exact.position, abs=1e-8)


REFUSED = [
    (
        "mujoco",
        "rk4",
        Scene.of([POINT], [Force(a=0, amplitude=1.0), Rod(a=0, length=1.0)]),
        "beside rotating joints",
    ),
    (
        "mujoco",
        "rk4",
        Scene.of([POINT], [SPRING, Dashpot(a=0, damping=-0.5, anchor_a=(0.1, 0.0, 0.0))]),
        "off the centre",
    ),
    (
        "pymunk",
        "semi-implicit-euler",
        Scene.of([POINT, POINT], [Force(a=0, b=1, amplitude=1.0)]),
        "between bodies",
    ),
    (
        "pymunk",
        "semi-implicit-euler",
        Scene.of([POINT, POINT], [Dashpot(a=0, b=1, damping=1.0)]),
        "resists in all directions",
    ),
    ("rebound", "leapfrog", DAMPED, "dashpot"),
    (
        "rebound",
        "leapfrog-8",
        Scene.of([POINT], [Spring(a=0, stiffness=1.0, exponent=1.5)]),
        "smooth",
    ),
    ("rebound", "ias15", Scene.of([POINT], [Spring(a=0, stiffness=1.0, exponent=2.0)]), "smooth"),
    ("rebound", "whfast", DRIVEN, "attracting centre"),
]


@pytest.mark.parametrize(("engine", "method", "scene", "reason"), REFUSED)
def test_what_an_engine_cannot_say_is_refused(engine, method, scene, reason):
    adapter = discovery.engine(engine)
    assert reason in str(
        adapter.unsupported(Motion(scene, np.array([0.0, 1.0])), adapter.method(method))
    )
