"""The chapter's relations of quaternions and angular velocities, (1.67) to (1.75) and (1.89) to
(1.91), along a certified motion.
"""

from fractions import Fraction

import pytest

from refdem.core.discovery import truth_of
from tests.rationals import cross, hamilton

INERTIA = (Fraction(1), Fraction(2), Fraction(3))
H = Fraction(1, 10**14)
CLOSE = Fraction(1, 10**20)
"""Differences at 1e-14 s of values that are known to 1e-60 are rates to 1e-27."""


def conjugate(q):
    return [q[0], *(-x for x in q[1:])]


def half(q):
    return [x / 2 for x in q]


def close(a, b):
    return all(abs(x - y) < CLOSE for x, y in zip(a, b, strict=True))


def applied(rows, v):
    return [sum(x * y for x, y in zip(row, v, strict=True)) for row in rows]


@pytest.fixture(scope="module", params=["1", "17/8", "9"])
def motion(request):
    """Attitude, omega in space and in body axes, the matrix, each with its rate, and the second
    rate of the attitude.
    """
    truth = truth_of("free-rigid-body").refined(60)
    t = Fraction(request.param)
    samples = [{name: ball.mid for name, ball in truth.at(t + k * H).items()} for k in (-1, 0, 1)]
    kinds = {
        "q": [f"attitude.{a}" for a in "wxyz"],
        "w": [f"omega.{a}" for a in "xyz"],
        "wb": [f"omega_body.{a}" for a in "xyz"],
    }
    kinds["R"] = [f"R.{a}{b}" for a in "xyz" for b in "xyz"]
    values = {
        kind: [[sample[name] for name in names] for sample in samples]
        for kind, names in kinds.items()
    }
    found = {kind: now for kind, (_, now, _) in values.items()}
    found |= {
        f"{kind}'": [(b - a) / (2 * H) for a, b in zip(before, after, strict=True)]
        for kind, (before, _, after) in values.items()
    }
    found["q''"] = [(a - 2 * b + c) / H**2 for a, b, c in zip(*values["q"], strict=True)]
    return found


def test_rates_of_the_attitude_are_half_the_products_with_omega_and_with_omega_body(
    motion,
):
    assert close(motion["q'"], half(hamilton([0, *motion["w"]], motion["q"])))  # (1.67)
    assert close(motion["q'"], half(hamilton(motion["q"], [0, *motion["wb"]])))  # (1.91)
    assert not close(motion["q'"], half(hamilton(motion["q"], [0, *motion["w"]])))
    second = [
        a + b
        for a, b in zip(
            hamilton([0, *motion["w'"]], motion["q"]),
            hamilton([0, *motion["w"]], motion["q'"]),
            strict=True,
        )
    ]
    assert close(motion["q''"], half(second))  # (1.68)


def test_the_attitude_gives_omega_back_in_space_and_in_body_axes(motion):
    assert close(
        hamilton([2 * x for x in motion["q'"]], conjugate(motion["q"])), [0, *motion["w"]]
    )  # (1.89)
    assert close(
        hamilton(conjugate(motion["q"]), [2 * x for x in motion["q'"]]),
        [0, *motion["wb"]],
    )  # (1.90)


def test_the_attitude_stays_of_length_one_and_across_its_rate_and_does_not_commute_with_it(motion):
    q = motion["q"]
    rate = motion["q'"]
    assert close(
        [sum(x * x for x in q), sum(x * y for x, y in zip(q, rate, strict=True))], [1, 0]
    )  # (1.74), (1.75)
    there = hamilton(q, conjugate(rate))
    back = hamilton(rate, conjugate(q))
    assert close(there, [-x for x in back])
    assert not close(hamilton(q, rate), hamilton(rate, q))  # the chapter's remark after (1.75)


def test_the_equation_of_motion_in_space_has_the_tensor_turned_by_the_matrix_from_body_to_space(
    motion,
):
    turn = [motion["R"][i : i + 3] for i in (0, 3, 6)]
    back = list(map(list, zip(*turn, strict=True)))
    rate = applied(back, motion["w'"])
    momentum = applied(
        turn, [j * x for j, x in zip(INERTIA, applied(back, motion["w"]), strict=True)]
    )  # (1.71), (1.72)
    torque = cross(momentum, motion["w"])
    assert close(
        rate, [x / j for j, x in zip(INERTIA, applied(back, torque), strict=True)]
    )  # (1.70), (1.73)
    wrong = applied(back, [j * x for j, x in zip(INERTIA, applied(turn, motion["w"]), strict=True)])
    assert not close(wrong, momentum)  # with the printed matrix, which maps from space to body
