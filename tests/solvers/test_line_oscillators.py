"""Oscillators on a line in closed form and by Taylor series: against certified truth, each other,
and on lines of any direction.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.errors import UnsupportedError
from refdem.scene import Body, Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

ULPS = 2.0**-52
SHORT = np.array([0.0, 0.7, 3.1, 9.6, 23.0])

LINEAR = [
    ("viscous-oscillator", {"delta": "0.01", "gravity": "3"}, 24),
    ("viscous-oscillator", {"delta": "1"}, 8),
    ("viscous-oscillator", {"delta": "0.9999999", "v0": "-3"}, 8),
    ("viscous-oscillator", {"delta": "40", "v0": "2"}, 8),
    ("driven-oscillator", {"delta": "0", "mass": "3", "stiffness": "2.7", "drive": "0.9487"}, 64),
    ("driven-oscillator", {"delta": "0"}, 64),
    ("driven-oscillator", {"delta": "0", "drive": "1.0000001"}, 64),
    ("driven-oscillator", {"delta": "1e-7", "drive": "0.5", "gravity": "-2"}, 64),
    ("driven-oscillator", {"delta": "0.4999", "drive": "3"}, 16),
    ("driven-oscillator", {"delta": "0.5001", "drive": "3"}, 16),
    ("driven-oscillator", {"delta": "1", "drive": "1/3"}, 16),
    ("driven-oscillator", {"delta": "1.0000001", "drive": "0"}, 16),
    ("driven-oscillator", {"delta": "7", "drive": "5"}, 16),
]
POWERS = [("1", "1"), ("3/2", "1"), ("2", "-1.7"), ("3", "0.01"), ("2.7", "30"), ("9", "1.5")]
POLYNOMIAL = [
    ("duffing", {}),
    ("duffing", {"alpha": "-1", "amplitude": "1/2"}),
    ("duffing", {"alpha": "-1", "beta": "3", "amplitude": "2"}),
    ("duffing", {"beta": "-0.9"}),
    ("driven-duffing", {"drive": "2"}),
    ("quadratic-response", {"eps": "-1/4", "x0": "1/2"}),
    ("van-der-pol", {"p": "2/5"}),
    ("van-der-pol", {"mu": "4", "p": "0"}),
]


@pytest.mark.parametrize(("case", "given", "ulps"), LINEAR)
def test_linear_motion_is_right_to_some_ulps(solved, largest_error, case, given, ulps):
    trajectory = solved(discovery.case(case).at(**given).scene, SHORT, "exact-linear")
    assert largest_error(case, trajectory, ("x", "v"), **given) < ulps * ULPS


@pytest.mark.parametrize(("case", "given", "ulps"), LINEAR)
def test_series_and_closed_form_agree_also_from_a_later_start(solved, case, given, ulps):
    scene = discovery.case(case).at(**given).scene
    series, closed = (
        solved(scene, SHORT + 16.0, method) for method in ("taylor-oscillator", "exact-linear")
    )
    for name in ("position", "velocity"):
        a = getattr(series, name)
        b = getattr(closed, name)
        assert a == pytest.approx(b, abs=4 * ulps * ULPS * max(1.0, np.abs(b).max()))


@pytest.mark.parametrize(("exponent", "amplitude"), POWERS)
def test_power_laws_are_right_to_some_ulps_of_their_phase(
    solved, largest_error, exponent, amplitude
):
    given = {"exponent": exponent, "amplitude": amplitude, "mass": "3"}
    instance = discovery.case("power-oscillator").at(**given)
    times = SHORT * instance.scales.tau
    trajectory = solved(
        instance.scene, times, "exact-power" if exponent != "1" else "exact-harmonic"
    )
    growth = max(instance.truth().sensitivities([Fraction(t) for t in times]))
    assert largest_error("power-oscillator", trajectory, ("x", "v"), **given) < 8 * growth * ULPS


@pytest.mark.parametrize("exponent", [1.25, 1.5, 2.0, 3.0, 7.5])
def test_a_power_law_goes_on_from_any_of_its_states_and_back(solved, exponent):
    def from_state(position, velocity, times):
        return solved(
            Scene.of(
                [Body(mass=2.0, position=position, velocity=velocity)],
                [Spring(a=0, stiffness=3.0, exponent=exponent)],
            ),
            times,
            "exact-power",
        )

    whole = from_state((1.25, 0.0, 0.0), (0.0, 0.0, 0.0), SHORT)
    for row in range(1, len(SHORT) - 1):
        rest = from_state(tuple(whole.position[row, 0]), tuple(whole.velocity[row, 0]), SHORT[row:])
        assert rest.position == pytest.approx(whole.position[row:], abs=5e-14)
        back = from_state(
            tuple(whole.position[row, 0]),
            tuple(whole.velocity[row, 0]),
            SHORT[: row + 1][::-1].copy(),
        )
        assert back.position[-1, 0] == pytest.approx((1.25, 0.0, 0.0), abs=4e-14)
        assert back.velocity[-1, 0] == pytest.approx((0.0, 0.0, 0.0), abs=1e-13)


def test_a_power_law_at_rest_at_its_centre_stays(solved):
    still = solved(
        Scene.of([Body(mass=1.0)], [Spring(a=0, stiffness=3.0, exponent=1.5)]), SHORT, "exact-power"
    )
    assert not still.position.any()
    assert not still.velocity.any()


@pytest.mark.parametrize(("case", "given"), POLYNOMIAL)
def test_series_are_at_round_off_times_the_sensitivity(solved, largest_error, case, given):
    instance = discovery.case(case).at(**given)
    times = np.array([0.0, 0.21, 0.5, 1.0]) * min(8.0, instance.scales.duration)
    trajectory = solved(instance.scene, times, "taylor-oscillator")
    growth = max(instance.truth().sensitivities([Fraction(t) for t in times]))
    assert largest_error(case, trajectory, ("x", "v"), **given) < 8 * growth * ULPS


@pytest.mark.parametrize(("case", "given"), POLYNOMIAL)
def test_energy_and_work_balance_whatever_drives(solved, case, given):
    scene = discovery.case(case).at(**given).scene
    trajectory = solved(scene, SHORT, "taylor-oscillator")
    energy = 0.5 * trajectory.velocity[:, 0, 0] ** 2 + scene.potential(
        trajectory.position, trajectory.attitude
    )
    total = energy + trajectory.channels.get("dissipated_work", np.zeros(len(SHORT)))
    assert np.ptp(total) < 2e-14 * (np.abs(energy).max() + 1.0)


def along(axis, origin, place, speed):
    """Everything at once on a line: a spring with length, square and cube, a dashpot of van der
    Pol's, weight, two drives.
    """
    axis = np.array(axis)
    origin = np.array(origin)
    elements = [
        Spring(a=0, anchor_b=tuple(origin), length=4.0, stiffness=3.0, quadratic=0.25, cubic=0.5),
        Dashpot(a=0, anchor_b=tuple(origin + axis), damping=0.125, van_der_pol=0.0625),
        UniformGravity(g=tuple(0.75 * axis)),
        Force(a=0, amplitude=1.5, frequency=2.0, phase=0.5, axis=tuple(axis)),
        Force(a=0, amplitude=0.5, frequency=0.75, axis=tuple(-axis)),
    ]
    start = {"position": tuple(origin + (4.0 + place) * axis), "velocity": tuple(speed * axis)}
    return Scene.of([Body(mass=2.0, **start)], elements)


def test_a_line_in_space_is_as_good_as_any_other(solved):
    flat = solved(along((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.5, -1.0), SHORT, "taylor-oscillator")
    axis = np.array((2.0, -1.0, 2.0)) / 3.0
    origin = np.array((5.0, 1.0, -3.0))
    turned = solved(along(axis, origin, 0.5, -1.0), SHORT, "taylor-oscillator")
    assert turned.position[:, 0] == pytest.approx(
        origin + flat.position[:, 0, :1] * axis, abs=2e-13
    )
    assert turned.velocity[:, 0] == pytest.approx(flat.velocity[:, 0, :1] * axis, abs=2e-13)


def test_series_solve_the_equation_of_motion_as_the_scene_has_it(solved):
    """Finite differences of the series against forces written out once more, with nothing of the
    solver's.
    """
    h = 2.0**-9
    at = 1.375
    run = solved(
        along((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.5, -1.0),
        [0.0, at - h, at, at + h],
        "taylor-oscillator",
    )
    x = run.position[2, 0, 0]
    v = run.velocity[2, 0, 0]
    s = x - 4.0
    force = -3.0 * s - 0.25 * s**2 - 0.5 * s**3 - (0.125 + 0.0625 * (x - 1.0) ** 2) * v
    force += 2.0 * 0.75 + 1.5 * np.cos(2.0 * at + 0.5) - 0.5 * np.cos(0.75 * at)
    assert (run.velocity[3, 0, 0] - run.velocity[1, 0, 0]) / (2 * h) == pytest.approx(
        force / 2.0, rel=1e-4
    )
    assert (run.position[3, 0, 0] - run.position[1, 0, 0]) / (2 * h) == pytest.approx(v, rel=1e-4)


def test_more_samples_change_nothing(solved):
    scene = discovery.case("van-der-pol").at().scene
    few, many = (
        solved(scene, np.arange(n * 16 + 1) * (0.5 / n), "taylor-oscillator") for n in (1, 4)
    )
    assert np.array_equal(few.position, many.position[::4])
    assert np.array_equal(few.velocity, many.velocity[::4])


def test_motion_that_goes_to_infinity_or_past_its_anchor_is_not_supported(solved):
    softening = Scene.of(
        [Body(mass=1.0, position=(2.0, 0.0, 0.0))], [Spring(a=0, stiffness=1.0, cubic=-1.0)]
    )
    with pytest.raises(UnsupportedError, match="goes to infinity before"):
        solved(softening, SHORT, "taylor-oscillator")
    passing = Scene.of(
        [Body(mass=1.0, position=(2.0, 0.0, 0.0))],
        [Spring(a=0, length=0.5, stiffness=1.0, quadratic=0.125)],
    )
    with pytest.raises(UnsupportedError, match="anchor"):
        solved(passing, SHORT, "taylor-oscillator")


POINT = {"mass": 1.0, "position": (1.0, 0.0, 0.0)}
REFUSED = [
    (
        "exact-linear",
        [Spring(a=0, stiffness=1.0, exponent=2.0), Dashpot(a=0, damping=1.0)],
        {},
        "not linear",
    ),
    (
        "exact-linear",
        [Spring(a=0, stiffness=1.0), Dashpot(a=0, van_der_pol=1.0)],
        {},
        "dashpot is not linear",
    ),
    ("exact-linear", [Spring(a=0, stiffness=-1.0), Dashpot(a=0, damping=1.0)], {}, "not linear"),
    ("exact-linear", [Spring(a=0, stiffness=1.0)], {}, "harmonic"),
    (
        "exact-linear",
        [Spring(a=0, stiffness=1.0), Dashpot(a=0, damping=1.0)],
        {"velocity": (0.0, 1.0, 0.0)},
        "one line",
    ),
    (
        "exact-linear",
        [Spring(a=0, stiffness=1.0), Force(a=0, amplitude=1.0, axis=(0.0, 1.0, 0.0))],
        {},
        "one line",
    ),
    ("exact-power", [Spring(a=0, stiffness=1.0, exponent=0.5)], {}, "above 1"),
    (
        "exact-power",
        [Spring(a=0, stiffness=1.0, exponent=2.0), UniformGravity(g=(1.0, 0.0, 0.0))],
        {},
        "uniform_gravity; expected only spring",
    ),
    ("taylor-oscillator", [Spring(a=0, stiffness=1.0, exponent=1.5)], {}, "no polynomial"),
    (
        "taylor-oscillator",
        [Spring(a=0, stiffness=1.0, quadratic=1.0)],
        {},
        "no polynomial of the place",
    ),
    (
        "taylor-oscillator",
        [Spring(a=0, stiffness=1.0, cubic=1.0)] * 2,
        {},
        "2 elements of kind spring",
    ),
    ("velocity-verlet", [Spring(a=0, stiffness=1.0), Force(a=0, amplitude=1.0)], {}, "force"),
    ("rk4", [Spring(a=0, stiffness=1.0), Dashpot(a=0, damping=1.0)], {}, "dashpot"),
    ("equilibrium", [Spring(a=0, stiffness=1.0), Force(a=0, amplitude=1.0)], {}, "force"),
]


@pytest.mark.parametrize(("method", "elements", "more", "reason"), REFUSED)
def test_what_is_not_an_oscillator_of_the_kind_is_refused(method, elements, more, reason):
    problem = Motion(Scene.of([Body(**(POINT | more))], elements), np.array([0.0, 1.0]))
    assert reason in str(ENGINE.unsupported_motion(problem, ENGINE.method(method)))


@pytest.mark.parametrize(("method", "order"), [("velocity-verlet", 2), ("rk4", 4)])
def test_stepped_methods_have_their_order_on_springs_with_a_square_and_a_cube(
    solved, method, order
):
    scene = Scene.of(
        [Body(mass=2.0, position=(5.0, 0.0, 0.0))],
        [
            Spring(
                a=0, anchor_b=(1.0, 0.0, 0.0), length=3.0, stiffness=2.0, quadratic=0.5, cubic=0.25
            )
        ],
    )
    times = np.arange(5) * 0.75
    exact = solved(scene, times, "taylor-oscillator")
    errors = [
        np.abs(solved(scene, times, method, 0.75 / n).position - exact.position).max()
        for n in (64, 128)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


def test_the_square_of_a_stretch_turns_round_at_the_anchor_in_every_method_that_takes_it():
    """Without a length the stretch is the distance |x|: the force is -(k x + q x |x|)."""
    spring = Spring(a=0, b=-1, stiffness=3.0, quadratic=1.0)
    start = Body(mass=2.0, position=(0.5, 0.0, 0.0), velocity=(0.25, 0.0, 0.0))
    motion = Motion(Scene.of([start], [spring]), np.arange(9.0))

    def energy(trajectory):
        x = trajectory.position[:, 0, 0]
        v = trajectory.velocity[:, 0, 0]
        return v**2 + 3.0 * x**2 / 2 + np.abs(x) ** 3 / 3

    able = [method for method in ENGINE.methods if ENGINE.unsupported(motion, method) is None]
    assert {method.name for method in able} >= {"velocity-verlet", "rk4"}
    for method in able:
        if method.control == "step":
            step = 2.0**-10
        else:
            step = None
        trajectory, _ = ENGINE.run(Request(problem=motion, method=method.name, step=step))
        assert trajectory.position[:, 0, 0].min() < -0.25, method.name
        assert energy(trajectory) == pytest.approx(energy(trajectory)[0], rel=1e-5), method.name
