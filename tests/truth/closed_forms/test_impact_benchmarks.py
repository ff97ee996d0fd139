"""Impact benchmarks: sliding formulas, limits of sticking, phases by their closed forms, stored
peak forces, what each law keeps.
"""

from fractions import Fraction
from functools import cache
from math import cos, pi, sin, sqrt, tan

import numpy as np
import pytest

from refdem.core import discovery
from refdem.errors import UsageError

MU = 0.092
KN = 1.72e7
KT = 1.48e7
TINY = Fraction(1, 10**30)


@cache
def found(member, **given):
    instance = discovery.case("impact-benchmarks").at(member=member, **given)
    return instance, instance.truth()


def scalars(member, **given):
    return {name: ball.mid for name, ball in found(member, **given)[1].scalars().items()}


def end(member, **given):
    instance, truth = found(member, **given)
    return {name: ball.mid for name, ball in truth.at(Fraction(float(instance.times[-1]))).items()}


@pytest.mark.parametrize(("material", "force"), [("limestone", 7108), ("glass", 10697)])
def test_peak_forces_of_two_spheres_are_those_that_others_store(material, force):
    # Kratos stores 7108 N; glass by 4/3 E* sqrt(R*) d^(3/2) on a pocket calculator
    assert float(scalars("co-1", material=material)["max_force"]) == pytest.approx(force, rel=1e-3)


@pytest.mark.parametrize(
    ("material", "force"), [("magnesium-alloy", 7233), ("aluminium-alloy", 11370)]
)
def test_peak_forces_on_a_wall_are_those_that_others_store(material, force):
    assert float(scalars("co-2", material=material)["max_force"]) == pytest.approx(force, rel=1e-3)


@pytest.mark.parametrize("restitution", ["0.05", "0.5", "0.98", "1"])
def test_the_dashpot_makes_the_restitution_to_thirty_digits(restitution):
    for member, cutoff in (("co-3", "zero_overlap"), ("co-4", "zero_force")):
        if member == "co-3" or Fraction(restitution) > Fraction(1, 7):
            assert (
                abs(
                    scalars(member, restitution=restitution, cutoff=cutoff)["restitution"]
                    - Fraction(restitution)
                )
                < TINY
            )


def test_no_dashpot_that_stops_to_push_gives_less_than_exp_minus_two():
    with pytest.raises(UsageError, match="restitution"):
        discovery.case("impact-benchmarks").at(member="co-6", restitution="0.1")


@pytest.mark.parametrize("psi", ["8", "20", "-9"])
def test_dust_that_slides_loses_seven_of_psi_and_gains_five_of_spin(psi):
    if Fraction(psi) > 0:
        side = 1
    else:
        side = -1
    last = end("co-5", psi=psi)
    unit = Fraction(3, 10) * 5
    rolling = last["omega.z"] * Fraction("1e-5")
    assert abs((last["v.y"] + rolling) / unit - (Fraction(psi) - 7 * side)) < TINY
    assert abs(rolling / unit + 5 * side) < TINY


@pytest.mark.parametrize("cutoff", ["zero_force", "zero_overlap"])
def test_a_slip_on_a_wall_that_ends_without_a_spring_goes_on_as_rolling(cutoff):
    given = {"tangential_stiffness": "0", "angle": "1/10", "restitution": "1/2", "cutoff": cutoff}
    rebound = scalars("co-4", **given)
    # Friction through the point of contact keeps the angular momentum about it: of m v r, rolling
    # leaves 5/7 as m v r and 2/7 as spin, whatever the normal force is.
    across = Fraction(rebound["rebound_across"])
    assert abs(float(across) - 5 / 7 * 3.9 * sin(0.1)) < 1e-15
    assert abs(across + rebound["rebound_spin"] / 400) < TINY
    assert found("co-4", **given)[1].sensitivity(Fraction(1, 10**5)) >= 1


@pytest.mark.parametrize("spin", ["40", "-40"])
def test_a_spin_that_slides_has_the_tangential_restitution_of_its_impulse(spin):
    last = end("co-6", spin=spin, tangential_stiffness="0")
    e = Fraction(1, 2)
    mu = Fraction(2, 5)
    v = Fraction(1, 5)
    at_surface = Fraction(spin) / 10
    tangential = -(last["v.y"] + last["omega.z"] / 10) / at_surface
    assert abs(tangential - (-1 + Fraction(7, 2) * mu * (1 + e) * v / abs(at_surface))) < TINY


def test_it_slides_all_the_time_just_above_the_limit_angle_and_not_just_below():
    limit = MU * (7 - KN / KT)
    above, below = (np.arctan(limit * (1 + off)) for off in (1e-6, -1e-3))
    assert (
        abs(abs(scalars("dem-05", angle=repr(float(above)))["impulse_ratio"]) - Fraction("0.092"))
        < TINY
    )
    assert abs(scalars("dem-05", angle=repr(float(below)))["impulse_ratio"]) < Fraction("0.092") * (
        1 - Fraction(1, 10**9)
    )


@pytest.mark.parametrize("branch", ["R", "R-d/2", "R-d"])
def test_angular_momentum_about_the_wall_is_kept_by_the_lever_r_alone(branch):
    last = end("co-4", branch=branch)
    before = Fraction("3.9") * Fraction(sin(0.5))
    after = last["v.y"] - Fraction(2, 5) * Fraction("0.0025") * last["omega.z"]
    assert (abs(after - before) < 1e-15) == (branch == "R")
    assert abs(after - before) < 0.01


def phases(angle):
    """v_y and R omega after the contact without damping, lever R: closed form from phase to phase,
    switches by bisection.
    """
    m = 4000 * 4 / 3 * pi * 0.0025**3
    vn = 3.9 * cos(angle)
    vt = 3.9 * sin(angle)
    w = sqrt(KN / m)
    ws = sqrt(3.5 * KT / m)
    limit, climb = (
        (lambda t: MU * vn * m * w * sin(w * t)),
        (lambda t: MU * vn * m * w * w * cos(w * t)),
    )
    t = 0.0
    slip = vt
    spring = 0.0
    sticks = KT * vt <= MU * m * vn * w * w
    while t < pi / w:
        if sticks:

            def swing(s, a=spring, b=slip):
                return a * cos(ws * s) + b / ws * sin(ws * s)

            def speed(s, a=spring, b=slip):
                return b * cos(ws * s) - a * ws * sin(ws * s)

            s = crossing(lambda s, t=t, swing=swing: limit(t + s) - abs(KT * swing(s)), pi / w - t)
            slip = speed(s)
            spring = swing(s)
        else:
            if (spring or slip) > 0:
                side = 1
            else:
                side = -1
            lost = lambda s, t=t, side=side: 3.5 * side * MU * vn * (cos(w * t) - cos(w * (t + s)))  # noqa: E731
            s = crossing(
                lambda s, t=t, slip=slip, lost=lost, side=side: (
                    KT * side * (slip - lost(s)) - climb(t + s)
                ),
                pi / w - t,
            )
            slip = slip - lost(s)
            spring = side * limit(t + s) / KT
        t = t + s
        sticks = not sticks
    impulse = 2 / 7 * (vt - slip)
    return vt - impulse, -2.5 * impulse


def crossing(value, longest):
    """The first time at which a function falls below zero."""
    times = np.linspace(0, longest, 4001)[1:]
    high = next((t for t in times[4:] if value(t) < 0), None)
    if high is None:
        return longest + 1e-30
    low = high - times[0]
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if value(middle) > 0 else (low, middle)
    return high


@pytest.mark.parametrize("angle", [0.05, 0.09, 0.15, 0.3, 0.45, 0.7, 1.4])
def test_the_whole_curve_is_that_of_phases_in_closed_form(angle):
    last = end("dem-05", angle=str(angle))
    (across, turned) = phases(angle)
    assert float(last["v.y"]) == pytest.approx(across, abs=1e-11)
    assert float(last["omega.z"]) * 0.0025 == pytest.approx(turned, abs=1e-11)


@pytest.mark.parametrize("angle", ["0.1", "1/2", "1.4", "-0.3"])
def test_hertz_with_friction_obeys_its_law(angle):
    instance, truth = found("dem-05-hertz", angle=angle)
    law = instance.scene.elements[1]
    mass = instance.scene.bodies.mass[0]
    h = Fraction(1, 10**15)
    for index in (5, 14, 22, 30, 50):
        t = Fraction(float(instance.times[index]))
        before, now, after = (truth.at(s) for s in (t - h, t, t + h))
        rate = {name: float((after[name].mid - before[name].mid) / (2 * h)) for name in now}
        force = law.stiffness * max(float(now["r.x"].mid) + 0.0025, 0.0) ** 1.5
        slip = float(now["v.y"].mid) + 0.0025 * float(now["omega.z"].mid)
        rubs = -law.friction * force * np.sign(slip) * (abs(slip) > 1e-12)
        expected = {
            "r.x": float(now["v.x"].mid),
            "r.y": float(now["v.y"].mid),
            "v.x": -force / mass,
            "v.y": rubs / mass,
        }
        expected["omega.z"] = rubs / (0.4 * mass * 0.0025)
        for name, value in expected.items():
            assert rate[name] == pytest.approx(value, rel=1e-6, abs=1e-6), (name, index)


def test_gross_sliding_of_hertz_is_that_of_any_law():
    last = end("dem-05-hertz", angle="1.2")
    e_t = last["v.y"] / Fraction(3.9 * sin(1.2))
    assert float(e_t) == pytest.approx(1 - 2 * MU / tan(1.2), rel=1e-14)
    assert float(last["omega.z"]) == pytest.approx(-5 * MU * 3.9 * cos(1.2) / 0.0025, rel=1e-14)


def test_gears_feel_nothing_tangential_exactly():
    last = found("co-7")[1].at(Fraction(1, 100))
    for name in ("r1.y", "v1.y", "r2.y", "v2.y"):
        assert (last[name].mid, last[name].radius) == (0, 0)
    assert abs(last["omega1.z"].mid - 12) < TINY
    assert abs(last["omega2.z"].mid + 12) < TINY


@pytest.mark.parametrize(("branch", "kept"), [("R", False), ("R-d/2", True), ("R-d", False)])
def test_unequal_spheres_keep_total_angular_momentum_where_the_levers_fit(branch, kept):
    (instance, _), last = found("co-8", branch=branch), end("co-8", branch=branch)
    mass = instance.scene.bodies.mass
    inertia = instance.scene.bodies.inertia[:, 2]
    rows = [
        [float(last[f"{kind}{i}.{axis}"]) for i in (1, 2)]
        for kind, axis in (("r", "x"), ("r", "y"), ("v", "x"), ("v", "y"))
    ]
    x, y, vx, vy = map(np.array, rows)
    spin = np.array([float(last[f"omega{i}.z"]) for i in (1, 2)])
    change = mass @ (x * vy - y * vx) + inertia @ spin - inertia @ [12.0, 0.0]
    assert (abs(change) < 1e-12) == kept
    assert abs(change) < 1e-3


def test_apexes_come_to_those_of_a_hard_sphere_with_the_root_of_the_stiffness():
    def off(stiffness):
        known = scalars("dem-02", stiffness=stiffness)
        return [float(known[f"apex_{n}"]) - (0.1 + 0.4 * 0.8 ** (2 * n)) for n in (1, 2)]

    for soft, hard in zip(off("1e8"), off("4e8"), strict=True):
        assert soft / hard == pytest.approx(2, rel=0.01)


def test_without_damping_every_apex_is_the_height():
    assert all(
        abs(value - Fraction(1, 2)) < TINY for value in scalars("dem-02", restitution="1").values()
    )


def test_one_soft_bounce_is_a_damped_sine_about_its_sag():
    m = 2600 * 4 / 3 * pi * 1e-3
    k = 1e4
    g = 9.80665
    c = -2 * np.log(0.9) * sqrt(m * k / (pi**2 + np.log(0.9) ** 2))
    b = c / (2 * m)
    v = sqrt(2 * g * 0.4)
    w = sqrt(k / m - b * b)
    sag = m * g / k

    def overlap(t):
        return sag + np.exp(-b * t) * (-sag * cos(w * t) + (v - b * sag) / w * sin(w * t))

    end_time = crossing(overlap, 1.5 * pi / w)
    rate = -(overlap(end_time + 1e-7) - overlap(end_time - 1e-7)) / 2e-7
    assert float(scalars("dem-01")["apex_1"]) == pytest.approx(0.1 + rate**2 / (2 * g), rel=1e-8)


@pytest.mark.parametrize("restitution", ["1", "0.7"])
def test_squeezed_spheres_are_a_matrix_exponential(restitution):
    instance, truth = found("dem-03", restitution=restitution)
    m = instance.scene.bodies.mass
    k = 1000.0
    c = instance.scene.elements[-1].damping
    g = 9.80665
    coupled = np.array([[2.0, -1.0], [-1.0, 2.0]])
    matrix = np.zeros((4, 4))
    matrix[:2, 2:] = np.eye(2)
    matrix[2:, :2] = -k * coupled / m[:, None]
    matrix[2:, 2:] = -c * coupled / m[:, None]
    load = np.array([-k * 0.0005, k * (0.0005 + 0.0018)]) / m - g
    rest = np.linalg.solve(matrix, -np.array([0, 0, *load]))
    value, vector = np.linalg.eig(matrix)
    start = np.array([0.00045, 0.00135, 0, 0]) - rest
    t = float(instance.times[-1])
    now = rest + (vector @ (np.exp(value * t) * np.linalg.solve(vector, start))).real
    balls = truth.at(Fraction(t))
    assert [float(balls[name].mid) for name in ("r1.y", "r2.y")] == pytest.approx(
        now[:2], abs=1e-13
    )
    assert [float(balls[name].mid) for name in ("v1.y", "v2.y")] == pytest.approx(now[2:], abs=1e-9)


@pytest.mark.parametrize(
    "given",
    [{}, {"friction": "3/7", "radius": "2", "speed": "31"}, {"density": "1", "stiffness": "5"}],
)
def test_five_sevenths_at_two_sevenths_whatever_the_sphere(given):
    known = scalars("dem-04", **given)
    assert abs(known["speed_ratio"] - Fraction(5, 7)) < TINY
    assert abs(known["time_ratio"] - Fraction(2, 7)) < TINY
    last = end("dem-04", **given)
    assert abs(last["v.x"] + last["omega.z"] * Fraction(given.get("radius", "0.05"))) < TINY
