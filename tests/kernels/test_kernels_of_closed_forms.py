"""What the closed-form kernels do where the solvers above them never go: hopeless input, and times
far from zero.
"""

import numpy as np
import pytest

from refdem.kernels import load, pointer


def called(family, function, *arguments, samples, widths):
    """Return value and outputs (samples, width) of a kernel."""
    out = [np.full((samples, width), np.nan) for width in widths]
    arrays = [
        pointer(family, np.asarray(a, float)) if isinstance(a, tuple | np.ndarray) else a
        for a in arguments
    ]
    status = getattr(load(family).lib, function)(
        *arrays, *(pointer(family, o, output=True) for o in out)
    )
    return status, out


@pytest.mark.parametrize("velocity", [(0.0, 1.5, 0.0), (0.5, 0.0, 0.0)])
def test_kepler_says_that_an_orbit_is_not_bound_or_straight_and_writes_nothing(velocity):
    status, (position, _) = called(
        "kepler",
        "refdem_kepler",
        1.0,
        (1.0, 0.0, 0.0),
        velocity,
        0.0,
        2,
        (0.0, 1.0),
        samples=2,
        widths=(3, 3),
    )
    assert status == 1
    assert np.isnan(position).all()


@pytest.mark.parametrize("shift", [2.0**30, -(2.0**40)])
def test_state_depends_on_the_time_since_the_start_alone(shift):
    body = ((1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0), (0.9, 1.1, 1.3))
    (_, near), (_, far) = (
        called(
            "free_body",
            "refdem_free_body",
            *body,
            start,
            2,
            np.array([start + 0.5, start - 3.0]),
            samples=2,
            widths=(4, 3),
        )
        for start in (0.0, shift)
    )
    assert all(np.array_equal(a, b) for a, b in zip(near, far, strict=True))


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(
    ("across", "is_orbit"),
    [
        # 1 - e^2 = v^2 (2 - v^2) beside its limit 1e-16.
        (np.sqrt(0.51e-16), True),
        (np.sqrt(0.49e-16), False),
        # 2/r - v^2/gm beside 0.
        (np.sqrt(2.0) * (1 - 2.0**-50), True),
        (np.sqrt(2.0) * (1 + 2.0**-50), False),
    ],
)
def test_kepler_refuses_from_its_limits_on(across, is_orbit, turned):
    """At 1 m from a centre with gm = 1, across the line to it."""
    place = (1.0, 0.0, 0.0)
    velocity = (0.0, across, 0.0)
    if turned:
        place = (0.0, 0.0, -1.0)
        velocity = (0.0, 0.0 - across, 0.0)
    times = (0.0, 1e-9)
    status, (position, _) = called(
        "kepler", "refdem_kepler", 1.0, place, velocity, 0.0, 2, times, samples=2, widths=(3, 3)
    )
    assert (status == 0) is is_orbit
    assert np.isfinite(position).all() == is_orbit
