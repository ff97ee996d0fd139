"""Free rigid body: against the Taylor witness, the equations of motion, conservation, and planted
errors.
"""

from contextlib import suppress
from fractions import Fraction
from functools import cache
from itertools import permutations

import numpy as np
import pytest
from flint import arb

from refdem.core.discovery import case, truth_of
from refdem.truth import rotation
from refdem.truth.balls import UndecidedError, arb_of, precision
from refdem.truth.closed_forms.free_rigid_body import FreeRigidBody
from refdem.truth.free_body import Axisymmetric, Elliptic, Separatrix, Steady
from refdem.truth.refiner import Refiner
from tests.quadratic_flows import body_flow

SCALE = dict.fromkeys(
    ("omega_body.x", "omega_body.y", "omega_body.z", "omega.x", "omega.y", "omega.z", "attitude.w"),
    1.0,
)
TILTED = tuple(map(Fraction, (1, 2, -3, Fraction(1, 2))))
TIME = Fraction(7, 2)

STARTS = [
    (Elliptic, "1 2 3", "0.9 1.1 1.3"),
    (Elliptic, "1 2 3", "1.3 1.1 -0.2"),
    (Elliptic, "1 2 3", "-1.3 0 0.2"),
    (Elliptic, "1 2 3", "0.3 -1.1 1.3"),
    (Elliptic, "6 1 6.5", "1e-9 1 0"),
    (Elliptic, "1 2 3", "0 1 1e-30"),
    (Elliptic, "1 2 2.0000000001", "0.5 0.6 0.7"),
    (Elliptic, "1 2 3", "1e-20 1e-21 1"),
    (Axisymmetric, "2 2 3", "0.9 -1.1 1.3"),
    (Axisymmetric, "3 2 2", "-0.9 1.1 0.3"),
    (Axisymmetric, "2 1 2", "0.9 1.1 0.3"),
    (Steady, "2 2 2", "0.9 1.1 1.3"),
    (Steady, "2 2 3", "0.3 0.4 0"),
    (Steady, "1 2 3", "0 -1 0"),
    (Separatrix, "1 3 6", "0.75 -0.125 0.25"),
    (Separatrix, "1 3 6", "0.75 0.5 -0.25"),
]


def exact(text):
    return tuple(Fraction(x) for x in text.split())


def body(inertia, omega, attitude=TILTED):
    return FreeRigidBody(Refiner.of(SCALE), inertia, omega, attitude)


def misses(truth):
    """Names of the quantities of state in which a truth and the witness exclude each other."""
    omega, q = witness(truth.inertia, truth.omega)
    t = arb_of(TIME)
    away = rotation.times(rotation.conjugate(truth.turned(t)), q)[1:]
    found = [
        f"omega {i}"
        for i, (a, b) in enumerate(zip(truth.spin(t), omega, strict=True))
        if not a.overlaps(b)
    ]
    return found + [f"attitude {i}" for i, x in enumerate(away) if not x.contains(0)]


@cache
def witness(inertia, omega):
    """omega and attitude at TIME by Taylor series, at 400 bits."""
    with precision(400):
        return body_flow(inertia, omega, TILTED, TIME, order=60)


@pytest.mark.parametrize(("kind", "inertia", "omega"), STARTS)
def test_closed_form_meets_the_taylor_witness(kind, inertia, omega):
    truth = body(exact(inertia), exact(omega))
    with precision(400):
        assert type(truth.body()) is kind
        assert (
            max(float(x.rad()) for part in witness(truth.inertia, truth.omega) for x in part)
            < 1e-30
        )
        assert misses(truth) == []


@pytest.mark.parametrize("order", list(permutations(range(3))))
@pytest.mark.parametrize(
    ("inertia", "omega"),
    [("1 2 3", "0.5 -1 0.8"), ("1 2 3", "0.8 1 -0.1"), ("1 3 6", "0.75 -0.125 0.25")],
)
def test_every_order_of_the_moments_meets_the_witness(inertia, omega, order):
    truth = body(*(tuple(exact(x)[i] for i in order) for x in (inertia, omega)))
    with precision(400):
        assert misses(truth) == []


PLANTED = {
    "sense of the theta phase": lambda b: vars(b).update(sense=-b.sense),
    "sign of the drift's zeta term": lambda b: vars(b).update(
        drift=2 * b.start.length / arb_of(b.start.inertia[b.other]) - b.drift
    ),
    "sign of M_2": lambda b: vars(b).update(sign_b=-b.sign_b),
    "branch of the start": lambda b: vars(b).update(shift=2 * b.jacobi.k - b.shift),
    "phase at the start left out": lambda b: vars(b).update(phase0=arb(1)),
    "M about the wrong end of its axis": lambda b: vars(b).update(sign_c=-b.sign_c),
    "rate off by 1e-25": lambda b: vars(b).update(rate=b.rate * (1 + arb("1e-25"))),
}


@pytest.mark.parametrize("fault", PLANTED)
@pytest.mark.parametrize("omega", ["0.9 1.1 1.3", "1.3 1.1 -0.2"])
def test_the_witness_sees_a_planted(fault, omega):
    truth = body(exact("1 2 3"), exact(omega))
    with precision(400):
        PLANTED[fault](truth.body())
        assert misses(truth)


@pytest.mark.parametrize("t", [Fraction(1, 3), Fraction(-40), Fraction(1000)])
@pytest.mark.parametrize(("kind", "inertia", "omega"), STARTS)
def test_equations_of_motion_hold_at_any_time(kind, inertia, omega, t):
    truth = body(exact(inertia), exact(omega))
    j = exact(inertia)
    with precision(1600):
        h = arb(2) ** -400
        time = arb_of(t)
        (w_minus, q_minus), (w, q), (w_plus, q_plus) = (
            (truth.spin(x), truth.turned(x)) for x in (time - h, time, time + h)
        )
        if rotation.dot(q_minus, q_plus) < 0:
            q_plus = [-x for x in q_plus]
        if rotation.dot(q, q_plus) < 0:
            q = [-x for x in q]
        spinning = [(a - b) / (2 * h) for a, b in zip(w_plus, w_minus, strict=True)]
        turning = [(a - b) / (2 * h) for a, b in zip(q_plus, q_minus, strict=True)]
        torque = [
            arb_of(j[(i + 1) % 3] - j[(i + 2) % 3]) * w[(i + 1) % 3] * w[(i + 2) % 3]
            for i in range(3)
        ]
        assert all(abs(arb_of(j[i]) * spinning[i] - torque[i]) < arb("1e-100") for i in range(3))
        residual = [
            a - b / 2 for a, b in zip(turning, rotation.times(q, [arb(0), *w]), strict=True)
        ]
        assert all(abs(x) < arb("1e-100") for x in residual)


@pytest.mark.parametrize("t", [Fraction(11, 7), Fraction(1500)])
@pytest.mark.parametrize(("kind", "inertia", "omega"), STARTS)
def test_energy_and_angular_momentum_in_space_are_kept(kind, inertia, omega, t):
    truth = body(exact(inertia), exact(omega))
    with precision(400):
        j = [arb_of(x) for x in exact(inertia)]

        def kept(time):
            w = truth.spin(time)
            q = truth.turned(time)
            momentum = [a * b for a, b in zip(j, w, strict=True)]
            return [rotation.dot(w, momentum), *rotation.rotated(q, momentum), rotation.dot(q, q)]

        change = [a - b for a, b in zip(kept(arb_of(t)), kept(arb(0)), strict=True)]
        assert all(x.contains(0) and x.rad() < 1e-50 for x in change)


@pytest.mark.parametrize(("kind", "inertia", "omega"), STARTS)
def test_balls_of_forty_digits_contain_those_of_a_hundred(kind, inertia, omega):
    truth = body(exact(inertia), exact(omega))
    for t in (Fraction(0), Fraction(1, 3), Fraction(1000)):
        wide = truth.at(t)
        narrow = truth.refined(100).at(t)
        for name, ball in wide.items():
            assert ball.radius <= Fraction(1, 10**40), name
            assert narrow[name].radius <= Fraction(1, 10**100), name
            assert abs(ball.mid - narrow[name].mid) <= ball.radius + narrow[name].radius, name


@pytest.mark.parametrize("bits", [53, 80, 200])
@pytest.mark.parametrize(("kind", "inertia", "omega"), STARTS)
def test_balls_of_few_bits_contain_the_values_of_many(kind, inertia, omega, bits):
    truth = body(exact(inertia), exact(omega))
    t = Fraction(3, 2)
    with precision(1000):
        sure = truth.evaluate(arb_of(t))
    with precision(bits), suppress(UndecidedError):
        assert [
            name
            for name, ball in truth.evaluate(arb_of(t)).items()
            if not ball.contains(sure[name])
        ] == []


def test_period_brings_omega_back_and_no_shorter_time_does():
    truth = body(exact("1 2 3"), exact("0.9 1.1 1.3"))
    with precision(300):
        period = truth.constants()["period"]
        assert all(
            a.overlaps(arb_of(b)) for a, b in zip(truth.spin(period), truth.omega, strict=True)
        )
        for part in (2, 3, 4):
            assert not all(
                a.overlaps(arb_of(b))
                for a, b in zip(truth.spin(period / part), truth.omega, strict=True)
            )


def test_period_of_an_axisymmetric_body_is_that_of_its_cone():
    # omega_3 (J3 - J1)/J1 = 1.3/2: T = 2 pi/0.65
    assert float(
        truth_of("free-rigid-body", inertia="2,2,3").scalars()["period"].mid
    ) == pytest.approx(9.666438934122441, rel=1e-15)


def test_steady_spin_has_no_period_and_turns_at_its_rate():
    truth = truth_of("free-rigid-body", omega_body="0,0,1", attitude="0,1,0,0")
    assert truth.scalars() == {}
    end = truth.at(Fraction(2))
    # q = i (cos 1 + k sin 1) = i cos 1 - j sin 1: w stays exactly 0
    assert end["attitude.w"].mid == end["attitude.w"].radius == 0
    assert float(end["attitude.x"].mid) == pytest.approx(0.5403023058681398, rel=1e-15)
    assert float(end["attitude.y"].mid) == pytest.approx(-0.8414709848078965, rel=1e-15)
    assert float(end["omega.z"].mid) == -1.0


def test_attitude_need_not_be_of_unit_size_and_w_is_never_negative():
    one, two = (truth_of("free-rigid-body", attitude=a) for a in ("1,2,-3,0.5", "-2,-4,6,-1"))
    for k in range(12):
        first = one.at(Fraction(k))
        second = two.at(Fraction(k))
        assert first["attitude.w"].mid >= 0
        assert all(
            abs(first[n].mid - second[n].mid) <= first[n].radius + second[n].radius for n in first
        )


def test_quantities_are_those_of_the_case():
    instance = case("free-rigid-body").at()
    assert set(instance.truth().at(Fraction(1))) == set(instance.quantities)


def test_sensitivity_is_the_response_of_the_witness_to_a_small_change():
    start = exact("0.9 1.1 1.3")
    inertia = exact("1 2 3")
    h = Fraction(1, 10**12)
    turns = np.zeros((3, 3))
    spins = np.zeros((3, 3))
    with precision(300):
        for axis in range(3):
            moved = [tuple(w + s * h * (i == axis) for i, w in enumerate(start)) for s in (1, -1)]
            (w_plus, q_plus), (w_minus, q_minus) = (
                body_flow(inertia, w, TILTED, TIME, order=40) for w in moved
            )
            turns[:, axis] = [
                float(x / arb_of(h))
                for x in rotation.times(q_plus, rotation.conjugate(q_minus))[1:]
            ]
            spins[:, axis] = [
                float((a - b) / (2 * arb_of(h))) for a, b in zip(w_plus, w_minus, strict=True)
            ]
    spread = np.linalg.svd(turns, compute_uv=False)
    growth = max(1 + spread[0], float(np.linalg.norm(spins, axis=1).max()))
    assert growth <= body(inertia, start).sensitivity(TIME) <= 2 * growth
