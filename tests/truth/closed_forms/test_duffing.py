"""Duffing's oscillator: every regime against validated integration, energy, Liouville's theorem,
and literal periods.
"""

from fractions import Fraction

import pytest
from flint import arb

from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.duffing import truth
from refdem.truth.validated_flow import ValidatedFlow

F = Fraction
SCALE = {"x": 1.0, "v": 1.0}
REGIMES = {
    "cn": ("1", "1", "1"),
    "cn over both wells": ("-1", "1", "3/2"),
    "cn without a linear part": ("0", "2", "-3/4"),
    "dn from the outer turning point": ("-1", "1", "5/4"),
    "nd from the inner one": ("-1", "1", "1/2"),
    "sech": ("-1", "2", "1"),
    "cd": ("1", "-1/2", "1"),
    "cosine": ("9/4", "0", "2"),
    "the bottom of a well": ("-1", "4", "1/2"),
}


def motion(name, amplitude=None):
    alpha, beta, a = (F(text) for text in REGIMES[name])
    return truth({"alpha": alpha, "beta": beta, "amplitude": amplitude or a}, SCALE)


@pytest.mark.parametrize("name", REGIMES)
def test_every_regime_solves_the_equation_of_motion(name):
    alpha, beta, a = (F(text) for text in REGIMES[name])

    def field(y):
        return [y[1], -alpha * y[0] - beta * (y[0] * y[0] * y[0])]

    flow = ValidatedFlow(
        field, [a, F(0)], lambda y: {"x": y[0], "v": y[1]}, SCALE, state=("x", "v"), moved=(0, 1)
    )
    found = motion(name).at(F(7, 4))
    other = flow.at(F(7, 4))
    assert all(
        abs(found[q].mid - other[q].mid) <= found[q].radius + other[q].radius for q in ("x", "v")
    )
    assert max(ball.radius for ball in [*found.values(), *other.values()]) <= F(1, 10**40)


@pytest.mark.parametrize("name", REGIMES)
@pytest.mark.parametrize("t", ["0", "1/3", "12", "-5"])
def test_energy_is_kept(name, t):
    alpha, beta, a = (F(text) for text in REGIMES[name])
    state = motion(name).at(F(t))
    x = state["x"].mid
    v = state["v"].mid
    assert abs(v**2 + alpha * (x**2 - a**2) + beta / 2 * (x**4 - a**4)) < F(1, 10**38)


@pytest.mark.parametrize("name", REGIMES)
@pytest.mark.parametrize("t", ["1/3", "4"])
def test_the_flow_keeps_area_whatever_made_its_columns(name, t):
    with precision(384):
        a, b, c, d = motion(name).jacobian(F(t)).entries()
        assert abs(a * d - b * c - 1) < 1e-28


@pytest.mark.parametrize(
    "name", [name for name in REGIMES if name not in ("sech", "the bottom of a well")]
)
def test_after_its_period_it_is_back_at_rest(name):
    period = motion(name).scalars()["period"].mid
    state = motion(name).at(period)
    assert abs(state["x"].mid - F(REGIMES[name][2])) < F(1, 10**38)
    assert abs(state["v"].mid) < F(1, 10**37)
    half = motion(name).at(period / 2)["x"].mid
    well = name.startswith(("dn", "nd"))
    assert (
        (half > 0) == (F(REGIMES[name][2]) > 0)
        if well
        else half == pytest.approx(-F(REGIMES[name][2]))
    )


def test_period_is_that_of_quadrature():
    # 4 integral_0^(pi/2) d phi/sqrt(1 + (1 + sin^2 phi)/2): tanh-sinh quadrature, mpmath 1.3, 45
    # digits
    assert (
        motion("cn")
        .scalars()["period"]
        .decimals(40)[0]
        .startswith("4.768022029102460806304518470057719054495")
    )


def test_separatrix_and_bottom_have_no_period():
    assert motion("sech").scalars() == motion("the bottom of a well").scalars() == {}


def test_just_beside_the_separatrix_it_is_the_separatrix_for_a_long_time():
    beside = motion("sech", F(1) + F(1, 10**60)).at(F(9))["x"].mid
    with precision(256):
        assert abs(arb(float(beside)) - 1 / arb(9).cosh()) < 1e-16


@pytest.mark.parametrize(("alpha", "beta", "amplitude"), [("1", "-1", "2"), ("-1", "-1", "1")])
def test_motion_to_infinity_is_not_certified(alpha, beta, amplitude):
    with pytest.raises(NotCertifiedError, match="infinity"):
        truth({"alpha": F(alpha), "beta": F(beta), "amplitude": F(amplitude)}, SCALE).at(F(1))


def test_a_linear_spring_that_repels_is_never_infinite():
    """x'' = x from rest at 1 is cosh t, and S that of cosh and sinh."""
    found = truth({"alpha": F(-1), "beta": F(0), "amplitude": F(1)}, SCALE)
    for t in (1, 30):
        ball = found.at(F(t))["x"]
        with precision(400):
            low, high = (arb_of(ball.mid + sign * ball.radius) for sign in (-1, 1))
            assert low < arb(t).cosh() < high
    assert found.sensitivity(F(3)) > 10
