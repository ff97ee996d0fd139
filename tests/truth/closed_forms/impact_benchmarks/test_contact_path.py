"""A prescribed contact path: against midpoint sums of a force that is found step by step, pieces,
and a frame that is turned.
"""

import re
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from refdem.cases.impact_benchmarks import member
from refdem.core import discovery
from refdem.errors import NotCertifiedError
from refdem.truth.balls import precision


@cache
def found(name="contact-path", **given):
    instance = discovery.case("impact-benchmarks").at(member=name, **given)
    return instance, instance.truth()


def force(v, x, stretch):
    """On body 1 at (x, off) of body 2: parts along x and y, torque; the slip."""
    r1 = float(v.radius)
    r2 = float(v.partner_radius)
    lever = {"R": 0.0, "R-d/2": 0.5, "R-d": 1.0}[v.branch]
    k = float(v.stiffness)
    kt = float(v.tangential_stiffness)
    mu = float(v.friction)
    b = float(v.off)
    distance = np.hypot(x, b)
    overlap = r1 + r2 - distance
    limit = mu * k * overlap / kt
    held = np.clip(stretch, -limit, limit)
    n = np.array([x, b]) / distance
    t = np.array([-b, x]) / distance
    slip = float(v.speed) * b / distance + (r2 - lever * overlap) * float(v.partner_spin)
    return -k * overlap * n - kt * held * t, -(r1 - lever * overlap) * kt * held, slip


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"branch": "R-d", "partner_radius": "1/2"},
        {"partner_spin": "-0.985"},
        {"partner_spin": "3"},
    ],
)
def test_what_the_law_gives_is_the_sum_of_its_forces(given):
    instance, truth = found(**given)
    v = member("contact-path").values(instance.p)
    steps = 8000
    half = v.half
    h = 2 * half / steps
    stretch = 0.0
    total = np.zeros(3)
    for n in range(steps):
        push, turn, slip = force(
            v,
            -half + (n + 0.5) * h,
            stretch + force(v, -half + (n + 0.25) * h, stretch)[2] * h / 2 / float(v.speed),
        )
        total += np.array([*push, turn]) * h / float(v.speed)
        stretch = np.clip(stretch + slip * h / float(v.speed), *_limits(v, -half + (n + 1) * h))
    last = truth.at(Fraction(float(instance.times[-1])))
    exact = np.array([float(last[name].mid) for name in ("impulse.x", "impulse.y", "turning.z")])
    assert np.abs(total - exact).max() < 2e-6 * np.abs(exact).max()


def _limits(v, x):
    size = float(v.friction * v.stiffness / v.tangential_stiffness) * (
        float(v.radius + v.partner_radius) - np.hypot(x, float(v.off))
    )
    return -abs(size), abs(size)


@pytest.mark.parametrize(("spin", "sides"), [("-0.9", [0, 1]), ("3", [1]), ("-1.02", [0, -1])])
def test_pieces_of_sticking_and_sliding(spin, sides):
    with precision(256):
        assert [piece.side for piece in found(partner_spin=spin)[1].pieces()] == sides


@pytest.mark.parametrize("spin", ["-0.9", "-1.02"])
def test_without_a_spring_friction_is_that_of_a_very_stiff_one(spin):
    """k_t = 0: mu k d against the slip from touch on, as a spring of 100 k is at its limit at once
    and stays there.
    """
    t = Fraction(1)
    none, stiff = (
        found(partner_spin=spin, tangential_stiffness=size)[1].refined(20).at(t)
        for size in ("0", "1e9")
    )
    for name in ("impulse.x", "impulse.y", "turning.z"):
        assert float(none[name].mid) == pytest.approx(float(stiff[name].mid), rel=1e-9)


def test_without_a_spring_s_is_no_less_than_what_displaced_starts_do():
    truth = found(tangential_stiffness="0")[1]
    t = Fraction(1)
    bound = truth.sensitivity(t)
    small = Fraction(1, 10**20)
    grown = dict.fromkeys(truth.at(t), 0.0)
    for axis, name in enumerate(truth.state):
        before, after = (
            truth.displaced(axis, sign * small * truth.scale[name]).at(t) for sign in (-1, 1)
        )
        for key in grown:
            change = (after[key].mid - before[key].mid) / (2 * small) / truth.scale[key]
            grown[key] += abs(float(change))
    assert 1 < max(grown.values()) <= bound * (1 + 1e-9)


def test_without_a_spring_a_slip_that_changes_its_sign_is_singular():
    with pytest.raises(NotCertifiedError, match="changes its sign") as caught:
        found(partner_spin="-0.985", tangential_stiffness="0")[1].at(Fraction(1))
    assert caught.value.code == "singular"


def test_the_force_turns_with_the_pair_and_what_gives_way_is_in_the_radius():
    plain, turned = (
        found(name)[1].at(Fraction(1, 2)) for name in ("contact-path", "contact-path-turned")
    )
    frame = np.array(member("contact-path-turned").frame, dtype=object)
    assert (frame.T @ frame == np.eye(3, dtype=int)).all()
    for kind in ("impulse", "turning", "r", "v"):
        expected = frame @ [plain[f"{kind}.{axis}"].mid for axis in "xyz"]
        apart = [
            abs(a - turned[f"{kind}.{axis}"].mid) for a, axis in zip(expected, "xyz", strict=True)
        ]
        assert max(apart) <= 10 * max(turned[f"{kind}.{axis}"].radius for axis in "xyz")
    assert plain["impulse.x"].radius > 0


@pytest.mark.parametrize("name", ["contact-path", "contact-path-turned"])
def test_digits_are_certified_as_far_as_the_spheres_do_not_give_way_and_the_refusal_says_how_far(
    name,
):
    truth = found(name)[1]
    with pytest.raises(NotCertifiedError, match="give way") as caught:
        truth.refined(60).at(Fraction(1))
    said = re.search(r"ask for at most (\d+)", str(caught.value))
    most = int(said.group(1))
    assert most >= 40
    size = min(1, *truth.scale.values())
    balls = truth.refined(most).at(Fraction(1))
    assert max(ball.radius for ball in balls.values()) <= size / Fraction(10) ** most


def test_a_path_so_slow_that_the_spheres_give_way_at_once_has_no_digits():
    with pytest.raises(NotCertifiedError, match="no digit; take a faster path"):
        found(speed="1e-30")[1].at(Fraction(1))
