"""Driven Duffing, quadratic response and van der Pol: against heyoka in multiprecision, and power
series in rationals.
"""

from fractions import Fraction

import pytest

from refdem.truth.closed_forms import driven_duffing, quadratic_response, van_der_pol

F = Fraction
SCALE = {"x": 1.0, "v": 1.0}
DUFFING = {
    "alpha": F(-1, 2),
    "beta": F(3, 4),
    "delta": F(1, 20),
    "f0": F(2, 5),
    "drive": F(6, 5),
    "x0": F(1, 3),
    "v0": F(-1, 4),
}
QUADRATIC = {
    "w0": F(3, 2),
    "eps": F(1, 4),
    "delta": F(1, 8),
    "f0": (F(1, 5), F(-1, 3)),
    "drive": (F(3, 10), F(7, 5)),
}
QUADRATIC |= {"x0": F(1, 2), "v0": F(1)}
POL = {"mu": F(1, 2), "p": F(2, 5), "drive": F(23, 20), "x0": F(1, 2), "v0": F(-1)}
MODULES = {
    "duffing": (driven_duffing, DUFFING),
    "quadratic": (quadratic_response, QUADRATIC),
    "pol": (van_der_pol, POL),
}

HEYOKA = {
    ("duffing", 3): (
        "0.6787133541762144711192018187364640193223",
        "-0.03556367392531263551650337122236945392517",
    ),
    ("duffing", 7): (
        "1.252943554065649278912676888328460227423",
        "-0.3698818867639409419150848738793087804307",
    ),
    ("quadratic", 3): (
        "-0.1917324578668971285303112206334901221953",
        "0.5661172953944261885462812254493957054488",
    ),
    ("quadratic", 7): (
        "-0.05374467348586451579533169658821176492770",
        "0.6654671199179419884222864502453830318897",
    ),
    ("pol", 3): (
        "-0.3484022139271490963107970288616768027233",
        "1.429370808341667270386696808578514537965",
    ),
    ("pol", 7): (
        "-1.438048906432981367821400282521932787888",
        "-0.9423761853924453519172790585958086835883",
    ),
}
"""x, v by heyoka 7.13 in 256 bits, from the equations with time as it stands in them."""


@pytest.mark.parametrize(("name", "t"), HEYOKA)
def test_motion_is_that_of_an_independent_integration(name, t):
    module, p = MODULES[name]
    found = module.truth(p, SCALE).at(F(t))
    for quantity, value in zip(("x", "v"), HEYOKA[name, t], strict=True):
        assert found[quantity].radius <= F(1, 10**40)
        assert abs(found[quantity].mid - F(value)) < F(1, 10**38)


def product(a, b, n):
    return sum(a[i] * b[n - i] for i in range(n + 1))


def waves(drives, n):
    """The n-th Taylor coefficient of sum f cos(w t + quarters pi/2)."""
    total = F(0)
    factorial = 1
    for i in range(2, n + 1):
        factorial *= i
    for f, w, quarters in drives:
        total += f * w**n * (1, 0, -1, 0)[(n + quarters) % 4] / factorial
    return total


def series(acceleration, p, t):
    """x and v at t from the power series of x, in rationals; acceleration(x, v, n) is its n-th
    coefficient.
    """
    x = [p["x0"]]
    v = [p["v0"]]
    for n in range(36):
        x.append(v[n] / (n + 1))
        v.append(acceleration(x, v, n) / (n + 1))
    return sum(c * t**n for n, c in enumerate(x)), sum(c * t**n for n, c in enumerate(v))


def duffing(x, v, n):
    cube = product([product(x, x, i) for i in range(n + 1)], x, n)
    push = waves([(DUFFING["f0"], DUFFING["drive"], 0)], n)
    return push - 2 * DUFFING["delta"] * v[n] - DUFFING["alpha"] * x[n] - DUFFING["beta"] * cube


def quadratic(x, v, n):
    push = waves([(f, w, 0) for f, w in zip(QUADRATIC["f0"], QUADRATIC["drive"], strict=True)], n)
    return (
        push
        - 2 * QUADRATIC["delta"] * v[n]
        - QUADRATIC["w0"] ** 2 * x[n]
        - QUADRATIC["eps"] * product(x, x, n)
    )


def pol(x, v, n):
    drag = product([product(x, x, i) for i in range(n + 1)], v, n)
    return POL["mu"] * (v[n] - drag) - x[n] + waves([(POL["p"], POL["drive"], 3)], n)


@pytest.mark.parametrize(
    ("name", "acceleration"), [("duffing", duffing), ("quadratic", quadratic), ("pol", pol)]
)
def test_motion_is_the_power_series_of_the_equation(name, acceleration):
    module, p = MODULES[name]
    t = F(1, 8)
    found = module.truth(p, SCALE).at(t)
    expected = series(acceleration, p, t)
    for quantity, value in zip(("x", "v"), expected, strict=True):
        assert abs(found[quantity].mid - value) < F(1, 10**24)


@pytest.mark.parametrize("name", MODULES)
def test_without_a_drive_the_motion_has_no_further_coordinates(name):
    module, p = MODULES[name]
    still = p | {"f0": (F(0), F(0)) if name == "quadratic" else F(0), "p": F(0)}
    with_drive = p | (
        {"f0": (F(1, 10**40), F(0))}
        if name == "quadratic"
        else {"f0": F(1, 10**40), "p": F(1, 10**40)}
    )
    near, far = (module.truth(given, SCALE).at(F(1, 2))["x"].mid for given in (still, with_drive))
    assert 0 < abs(near - far) < F(1, 10**40)


def test_sensitivity_is_that_of_a_displaced_start():
    truth = driven_duffing.truth(DUFFING, SCALE)
    small = F(1, 10**18)
    moved = [
        driven_duffing.truth(DUFFING | {n: DUFFING[n] + small}, SCALE).at(F(2))
        for n in ("x0", "v0")
    ]
    base = truth.at(F(2))
    rows = [
        sum(abs(float((other[q].mid - base[q].mid) / small)) for other in moved) for q in ("x", "v")
    ]
    assert max(1.0, *rows) <= truth.sensitivity(F(2)) * (1 + 1e-10)
    assert truth.sensitivity(F(2)) <= 3 * max(rows)
