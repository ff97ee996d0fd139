"""Heavy top: against quaternions with the torque of the weight, Jacobi's solution for the tilt,
steady precession and the sleeping top.
"""

from fractions import Fraction

import pytest
from flint import acb, arb

from refdem.core.discovery import case, truth_of
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms import heavy_top as module
from refdem.truth.witnesses.taylor import Solution

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
sound = module.field


def spun(given, t):
    """Euler's angles and the rate of the tilt at t from q' = q w/2 and Euler's equations about the
    tip.
    """
    e = {name: arb_of(value) for name, value in nutation_of(**given).p.items()}
    sine = e["theta0"].sin()
    half = (e["theta0"] / 2).sin_cos()
    weight = e["mass"] * e["gravity"] * e["length"]
    ratio = (e["j1"] - e["j3"]) / e["j1"]

    def rates(clock, s):
        w, x, y, z, a, b, c = s
        felt = [
            2 * (x * z - w * y) * weight,
            2 * (y * z + w * x) * weight,
        ]  # up in body axes, times m g l
        q = [
            -x * a - y * b - z * c,
            w * a + y * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - y * a,
        ]
        return [
            *(value / 2 for value in q),
            ratio * b * c + felt[1] / e["j1"],
            -ratio * a * c - felt[0] / e["j1"],
            0 * c,
        ]

    start = [half[1], half[0], arb(0), arb(0), e["thetadot0"], e["phidot0"] * sine, e["spin"]]
    w, x, y, z, a, b, _ = Solution(rates, start).at(t)
    up = [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
    psi = arb.atan2(up[0], up[1])
    return {
        "theta": up[2].acos(),
        "phi": arb.atan2(2 * (x * z + w * y), -2 * (y * z - w * x)),
        "psi": psi,
        "thetadot": a * psi.cos() - b * psi.sin(),
    }


def misses(given, t=Fraction(1, 2)):
    """Quantities in which the truth and the quaternions differ, angles modulo 2 pi."""
    truth = truth_of("heavy-top", **given).at(t)
    found = []
    with precision(200):
        for name, value in spun(given, t).items():
            off = (value - arb_of(truth[name].mid)) / 2
            if name != "thetadot":
                size = abs(off.sin())
            else:
                size = abs(off)
            if not size < arb(10) ** -25:
                found.append(name)
    return found


@pytest.mark.parametrize("given", SETS)
def test_angles_meet_the_quaternions(given):
    assert misses(given) == []


PLANTED = {
    "weight of the wrong sign": (
        3,
        lambda y, p: y[0].sin() * (-2 * p["mass"] * p["gravity"] * p["length"] / p["j1"]),
    ),
    "gyroscopic term lost by a hair": (3, lambda y, p: y[0].sin() * y[5] * Fraction(1, 10**20)),
    "own rotation without precession": (2, lambda y, p: y[0].cos()),
}


@pytest.mark.parametrize("fault", PLANTED)
def test_the_quaternions_see(fault, monkeypatch):
    place, more = PLANTED[fault]

    def field(p):
        def wrong(y):
            rates = list(sound(p)(y))
            rates[place] = rates[place] + more(y, p)
            return rates

        return wrong

    monkeypatch.setattr(module, "field", field)
    assert misses({})


def nutation_of(**given):
    """The tilts of a heavy top."""
    p = case("heavy-top").at(**given).p
    j1, j3 = p["inertia"]
    names = ("mass", "length", "gravity", "theta0", "phidot0", "thetadot0", "spin")
    return module.Nutation({name: p[name] for name in names} | {"j1": j1, "j3": j3})


@pytest.mark.parametrize("given", SETS)
def test_tilt_is_jacobis_solution_between_its_ends(given):
    truth = truth_of("heavy-top", **given)
    ends = truth.scalars()
    t = Fraction(1, 2)
    with precision(256):
        nutation = nutation_of(**given)
        low, high, beyond = nutation.roots()
        p = nutation.p
        m = (high - low) / (beyond - low)
        rate = (
            arb_of(p["mass"] * p["gravity"] * p["length"] / (2 * p["j1"])) * (beyond - low)
        ).sqrt()
        whole = 2 * acb(m).elliptic_k().real / rate
        assert abs(whole - arb_of(ends["period"].mid)) < 1e-30
        # sn^2 of the start, on the way that the sign of thetadot says
        if p["thetadot0"]:
            part = ((arb_of(p["theta0"]).cos() - low) / (high - low)).sqrt().asin()
        else:
            part = arb.pi() / 2
        begin = acb.elliptic_f(acb(part), acb(m)).real * (-1 if p["thetadot0"] > 0 else 1)
        q = (-arb.pi() * acb(1 - m).elliptic_k().real / acb(m).elliptic_k().real).exp()
        sn = jacobi_sn(begin + rate * arb_of(t), acb(m).elliptic_k().real, q, m)
        assert abs(low + (high - low) * sn * sn - arb_of(truth.at(t)["theta"].mid).cos()) < 1e-30


def jacobi_sn(u, k, q, m):
    """sn u by its Fourier series (DLMF 22.11.1)."""
    series = sum(
        (
            q ** arb(n + 0.5)
            / (1 - q ** (2 * n + 1))
            * ((2 * n + 1) * arb.pi() * u / (2 * k)).sin()
            for n in range(60)
        ),
        arb(0),
    )
    return 2 * arb.pi() / (k * m.sqrt()) * series


def test_at_the_right_speed_it_goes_round_steadily():
    # J1 W^2 cos th - J3 w3 W + m g l = 0 with J1 = 2, J3 = 1, W = 2: w3 = (8 cos th + m g l)/2,
    # cos(pi/3) = 1/2
    third = "1.047197551196597746154214461093167628065723133125035273658314"
    given = {
        "inertia": "2,1",
        "mass": "1",
        "length": "1",
        "gravity": "3",
        "theta0": third,
        "phidot0": "2",
        "spin": "3.5",
    }
    truth = truth_of("heavy-top", **given)
    assert (
        abs(float(truth.scalars()["nutation_max"].mid - truth.scalars()["nutation_min"].mid))
        < 1e-40
    )
    at = truth.at(Fraction(1, 2))
    assert float(at["theta"].mid) == pytest.approx(float(third), abs=1e-15)
    assert float(at["phi"].mid) == pytest.approx(1.0, abs=1e-15)
    assert float(at["psi"].mid) == pytest.approx((3.5 - 2 * 0.5) / 2, abs=1e-15)


@pytest.mark.parametrize(
    ("spin", "sleeps"), [("6.1", False), ("6.2", False), ("6.3", True), ("7", True)]
)
def test_upright_it_sleeps_from_the_spin_that_the_catalogue_says(spin, sleeps):
    # (J3 w3)^2 >= 4 J1 m g l: J1 = 2, J3 = 1, m g l = 49/10: w3 >= sqrt(39.2) = 6.26099...; let go
    # with the precession J3 w3/(2 J1)
    given = {
        "inertia": "2,1",
        "mass": "1",
        "length": "1",
        "gravity": "4.9",
        "theta0": "1e-6",
        "phidot0": str(float(spin) / 4),
    }
    ends = truth_of("heavy-top", **given, spin=spin).scalars()
    assert (float(ends["nutation_max"].mid) < 1e-4) is sleeps


NEAR = [
    {"theta0": "1/50", "phidot0": "3"},
    {"theta0": "3.1", "spin": "5"},
    {"thetadot0": "5", "spin": "-7", "inertia": "3,1/3", "mass": "2", "length": "1"},
]


@pytest.mark.parametrize("given", NEAR)
def test_next_to_a_vertical_angles_meet_the_quaternions(given):
    assert isinstance(truth_of("heavy-top", **given).reading, module.AxisReading)
    assert misses(given) == []


def test_next_to_a_vertical_the_way_of_errors_is_that_of_displaced_starts():
    truth = truth_of("heavy-top", **NEAR[0])
    t = Fraction(1, 2)
    small = Fraction(1, 10**20)
    with precision(truth.bits()):
        slopes = truth.jacobian(t).table()
        for axis in range(7):
            moved = truth.displaced(axis, small * truth.scale[truth.state[axis]]).at(t)
            for row, name in enumerate(module.SEEN, 7):
                found = float((moved[name].mid - truth.at(t)[name].mid) / small / truth.scale[name])
                assert found == pytest.approx(float(slopes[row][axis].mid()), rel=1e-6, abs=1e-6), (
                    axis,
                    name,
                )


@pytest.mark.parametrize("given", NEAR)
def test_next_to_a_vertical_s_counts_what_errors_do_to_the_angles(given):
    """The angles turn as 1/sin theta beside a vertical; their rows had been left out of S."""
    truth = truth_of("heavy-top", **given)
    t = Fraction(1, 2)
    with precision(truth.bits()):
        rows = truth.jacobian(t).table()
    sums = [sum(abs(float(entry.mid())) for entry in row) for row in rows]
    # Rows of the angles are the last.
    assert max(sums) == max(sums[7:])
    assert truth.sensitivity(t) >= max(sums) * (1 - 1e-12)


@pytest.mark.parametrize(
    "given",
    [{"theta0": "1e-3"}, {"theta0": "1e-9", "phidot0": "4"}, {"theta0": "3.1", "spin": "1/100"}],
)
def test_within_a_hundredth_of_a_vertical_angles_are_certified(given):
    """The second sleeps within 1e-9, the third passes the lower vertical at 3.3e-5."""
    truth = truth_of("heavy-top", **given)
    ends = truth.scalars()
    assert min(
        ends["nutation_min"].mid, Fraction(3.141592653589793) - ends["nutation_max"].mid
    ) < Fraction(11, 10000)
    assert misses(given) == []
    assert all(ball.radius < Fraction(1, 10**38) for ball in truth.at(Fraction(1, 2)).values())


@pytest.mark.parametrize(
    ("given", "theta"),
    [({"spin": "0"}, 0.5), ({"theta0": "3", "spin": "0"}, 3.0), ({"theta0": "1e-13"}, 1e-13)],
)
def test_through_a_vertical_no_angles_are_certified(given, theta):
    truth = truth_of("heavy-top", **given)
    for ask in (truth.at, truth.sensitivity):
        with pytest.raises(NotCertifiedError, match="vertical") as caught:
            ask(Fraction(1))
        assert (caught.value.code, caught.value.time, float(caught.value.state["theta"].mid)) == (
            "vertical",
            0.0,
            theta,
        )


def test_lz_and_energy_are_those_of_the_scene():
    scene = case("heavy-top").at(**SETS[1]).scene
    body = scene.bodies.single()[0]
    q = body.attitude
    vertical = 1.5 * (body.position[0] * body.velocity[1] - body.position[1] * body.velocity[0])
    assert q[2] == q[3] == 0
    inner = (
        body.omega[0],
        body.omega[1] * (1 - 2 * q[1] ** 2) + 2 * q[0] * q[1] * body.omega[2],
        -2 * q[0] * q[1] * body.omega[1] + (1 - 2 * q[1] ** 2) * body.omega[2],
    )
    spin = [j * w for j, w in zip(body.inertia, inner, strict=True)]
    vertical += 2 * q[0] * q[1] * spin[1] + (1 - 2 * q[1] ** 2) * spin[2]
    with precision(100):
        assert float(nutation_of(**SETS[1]).vertical()) == pytest.approx(vertical, rel=1e-14)
