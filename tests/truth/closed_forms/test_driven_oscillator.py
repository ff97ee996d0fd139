"""Damped and driven oscillators: against the Taylor series of their equation in rationals, in every
regime, and exact amplitudes.
"""

from fractions import Fraction

import pytest

from refdem.truth.closed_forms import driven_oscillator, viscous_oscillator

F = Fraction
FREE = {
    "mass": F(3, 2),
    "stiffness": F(27, 8),
    "gravity": F(5, 7),
    "x0": F(1, 3),
    "v0": F(-2),
}  # w0 = 3/2
SCALE = {"x": 1.0, "v": 1.0}
DRIVES = [
    (F(0), F(1)),
    (F(7, 5), F(0)),
    (F(7, 5), F(4, 3)),
    (F(7, 5), F(3, 2)),
    (F(-1), F(151, 100)),
]


def truth(delta, f0=None, drive=None, **more):
    p = {**FREE, "delta": delta, **more}
    if f0 is None:
        return viscous_oscillator.truth(p, SCALE)
    return driven_oscillator.truth({**p, "f0": f0, "drive": drive}, SCALE)


def series(delta, f0, drive, t):
    """x and v by the Taylor series of x'' = g - w0^2 x - 2 delta x' + f0 cos(w t), in exact
    rationals.
    """
    a = [FREE["x0"], FREE["v0"]]
    wave = f0
    for n in range(150):
        push = FREE["gravity"] * (n == 0) + (wave if n % 2 == 0 else 0)
        a.append(
            (push - FREE["stiffness"] / FREE["mass"] * a[n] - 2 * delta * (n + 1) * a[n + 1])
            / ((n + 1) * (n + 2))
        )
        if n % 2 == 0:
            wave = -wave * drive**2 / ((n + 1) * (n + 2))
    return sum(c * t**n for n, c in enumerate(a)), sum(
        n * c * t ** (n - 1) for n, c in enumerate(a) if n
    )


@pytest.mark.parametrize("delta", [F(0), F(1, 10), F(149, 100), F(3, 2), F(151, 100), F(3)])
@pytest.mark.parametrize(("f0", "drive"), DRIVES)
@pytest.mark.parametrize("t", [F(0), F(1, 2), F(3)])
def test_motion_is_the_taylor_series_of_the_equation(delta, f0, drive, t):
    balls = truth(delta, f0, drive).at(t)
    expected = series(delta, f0, drive, t)
    for name, value in zip(("x", "v"), expected, strict=True):
        assert balls[name].radius <= F(1, 10**40)
        assert abs(balls[name].mid - value) <= balls[name].radius + F(1, 10**36)


@pytest.mark.parametrize("delta", [F(1, 5), F(3, 2), F(2)])
def test_nothing_drives_the_viscous_oscillator(delta):
    free = truth(delta).at(F(5, 2))
    driven = truth(delta, F(0), F(1)).at(F(5, 2))
    assert free == driven


def test_period_is_that_of_the_damped_frequency_and_ends_at_critical_damping():
    period = truth(F(9, 10)).scalars()["period"]  # sqrt(9/4 - 81/100) = 6/5: 5 pi/3
    assert period.decimals(41)[0].startswith("5.235987755982988730771072305465838140328")
    assert truth(F(3, 2)).scalars() == truth(F(2)).scalars() == {}


def test_steady_amplitude_of_a_right_triangle_is_rational():
    # w0^2 - w^2 = 9/4 - 1/4 = 2 and 2 delta w = 3/2: the hypotenuse is 5/2.
    found = truth(F(3, 2), F(10), F(1, 2)).scalars()["steady_amplitude"]
    assert abs(found.mid - 4) <= found.radius
    undamped = truth(F(0), F(10), F(1, 2)).scalars()["steady_amplitude"]
    assert abs(undamped.mid - 5) <= undamped.radius
    assert truth(F(0), F(10), F(3, 2)).scalars() == {}


def test_amplitude_is_largest_where_w_squared_is_w0_squared_less_twice_delta_squared():
    # delta^2 = 9/8 - 1/2 = 5/8 would be irrational: take delta = 1, w^2 = 9/4 - 2 = 1/4; peak f0/(2
    # delta sqrt(w0^2 - delta^2)).
    peak = truth(F(1), F(1), F(1, 2)).scalars()["steady_amplitude"].mid
    assert abs(peak**2 - F(1, 4 * 1) / (F(9, 4) - 1)) < F(1, 10**38)
    assert all(
        truth(F(1), F(1), F(1, 2) + off).scalars()["steady_amplitude"].mid < peak
        for off in (F(1, 1000), F(-1, 1000))
    )


def test_undamped_at_resonance_the_amplitude_grows_as_f0_t_over_2_w0():
    growing = {"gravity": F(0), "x0": F(0), "v0": F(0)}
    found = truth(F(0), F(6), F(3, 2), **growing).at(F(40))["x"]  # 2 t sin(60), by mpmath 1.3
    assert found.decimals(41)[0].startswith("-24.384849688177336450051957238274067266")
    nearby = truth(F(0), F(6), F(3, 2) + F(1, 10**30), **growing).at(F(40))["x"]
    assert abs(nearby.mid - found.mid) < F(1, 10**26)


def test_what_remains_after_the_transient_has_the_steady_amplitude():
    damped = truth(F(1), F(6), F(5, 4))
    amplitude = damped.scalars()["steady_amplitude"].mid
    centre = FREE["gravity"] / F(9, 4)
    late = [damped.at(F(90) + F(n, 16)) for n in range(3)]
    for state in late:  # a circle in the plane of x and v/w
        assert abs(
            (state["x"].mid - centre) ** 2 + (state["v"].mid / F(5, 4)) ** 2 - amplitude**2
        ) < F(1, 10**30)


def test_sensitivity_is_that_of_the_free_motion_and_never_falls():
    driven = truth(F(1, 10), F(7, 5), F(4, 3))
    free = truth(F(1, 10))
    times = [F(n, 2) for n in range(9)]
    assert driven.sensitivities(times) == pytest.approx(free.sensitivities(times), rel=1e-12)
    assert driven.sensitivities(times) == sorted(driven.sensitivities(times))
    assert max(driven.sensitivities(times)) == pytest.approx(
        1.8, abs=0.3
    )  # at most w0 and 1/w0 beside the cosine
