"""The order is a limit: what the finest pair of levels shows decides, and a lack that vanishes with the step is none."""

import pytest

from refdem.checks.order import lack


@pytest.mark.parametrize(
    "orders",
    [
        [4.0, 4.0, 4.0],
        [3.76, 3.81],  # measured: MuJoCo rk4, pendulum[gravity=2.65707 thetadot0=3.2601]; goes on with 4.00, 4.00
        [3.52, 3.76],  # measured: rk4 of the reference, oblique collision; terms of higher order cancel part of the leading one
        [3.52, 3.76, 3.9],
        [0.70, 1.07],
        [6.0, 4.1],
    ],
)
def test_a_lack_that_goes_as_the_step_falls_is_none(orders):
    claimed = round(orders[-1])
    assert lack(orders, claimed) <= max(0.15, 0.05 * claimed)


@pytest.mark.parametrize(
    ("orders", "claimed"),
    [
        ([3.0, 3.0, 3.0], 4),
        ([4.0, 3.9, 3.4], 4),  # a small term of lower order comes out as the step falls
        ([2.0, 1.98, 1.6, 1.2], 2),
        ([3.4, 3.2], 4),
        ([2.6, 3.0], 4),  # halves its lack, but is no nearer to 4 than to 3
        ([2.0, 3.0], 4),
        ([1.0], 2),
        ([0.5, 0.5], 1),
        ([3.7, 3.7], 4),
    ],
)
def test_an_order_that_is_missing_at_the_finest_pair_is_seen(orders, claimed):
    assert lack(orders, claimed) > max(0.15, 0.05 * claimed)
