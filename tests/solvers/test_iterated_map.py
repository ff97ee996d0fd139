"""Maps in C: against plain Python, exact rationals and reversal of the path; a million bounces in a
fraction of a second.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core.maps import Logistic, LogisticFlow, RectangleBilliard, StadiumBilliard
from refdem.core.problem import Iteration, Request
from refdem.engines.reference import ENGINE
from refdem.faults.iterating import CORRECT_MAPS, iterated

UNIT = np.array([0.25, 0.125, 0.8, 0.6])
STADIUM = StadiumBilliard(width=4.0, height=2.0)
RECTANGLE = RectangleBilliard(width=4.0, height=2.0)
PROBLEMS = [
    Iteration(Logistic(eta=3.2), np.array([0.3]), 500),
    Iteration(LogisticFlow(eta=0.5), np.array([0.01]), 30),
    Iteration(STADIUM, UNIT, 10),
    Iteration(RECTANGLE, UNIT, 700),
    Iteration(RectangleBilliard(width=1.0, height=3.0), np.array([-0.25, 1.0, -0.28, 0.96]), 129),
    Iteration(StadiumBilliard(width=2.0, height=2.0), np.array([0.5, -0.25, 0.0, -1.0]), 10),
    Iteration(STADIUM, np.array([0.5, 0.25, -1.0, 0.0]), 12),
]


def ran(problem):
    return ENGINE.run(Request(problem=problem, method="iterated-map"))


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda p: f"{p.map.kind}-{p.n}")
def test_the_kernel_is_what_plain_python_gives(problem):
    run, cost = ran(problem)
    plain = iterated(problem, CORRECT_MAPS)
    assert cost.steps == problem.n
    assert np.array_equal(run.t, problem.times)
    for name, values in plain.values.items():
        assert np.allclose(
            run.values[name], values, rtol=0, atol=1e-9 if len(problem.start) == 4 else 1e-12
        )


def test_iterate_zero_is_the_start():
    for problem in PROBLEMS:
        run, _ = ran(problem)
        assert np.array_equal(
            np.concatenate([np.ravel(values[0]) for values in run.values.values()]), problem.start
        )


def test_a_million_bounces_in_a_rectangle_are_exact_to_the_last_digits():
    run, _ = ran(Iteration(RECTANGLE, UNIT, 10**6))
    n = run.t.astype(int)
    dx, dy = Fraction(UNIT[2]), Fraction(UNIT[3])  # the doubles themselves: 0.8 and 0.6 are rounded
    for k in range(0, len(n), 17):
        if n[k] == 0:
            continue
        low, high = (
            0,
            int(n[k]),
        )  # crossings of x among the first n, by bisection on the exact times
        first = [(2 - Fraction(UNIT[0])) / dx, (1 - Fraction(UNIT[1])) / dy]
        every = [4 / dx, 2 / dy]
        while low < high:
            middle = (low + high + 1) // 2
            t = first[0] + (middle - 1) * every[0]
            if t < first[1]:
                others = 0
            else:
                others = int((t - first[1]) // every[1]) + 1
            low, high = (middle, high) if middle + others <= n[k] else (low, middle - 1)
        times = [
            first[0] + (low - 1) * every[0] if low else 0,
            first[1] + (int(n[k]) - low - 1) * every[1] if n[k] > low else 0,
        ]
        t = max(times)
        x = Fraction(UNIT[0]) + dx * t - 4 * low
        y = Fraction(UNIT[1]) + dy * t - 2 * (int(n[k]) - low)
        exact = [float(-x if low % 2 else x), float(-y if (n[k] - low) % 2 else y)]
        assert np.allclose(run.values["position"][k], exact, rtol=0, atol=1e-15)


@pytest.mark.parametrize("table", [STADIUM, RECTANGLE])
def test_a_path_runs_back_when_its_direction_is_turned(table):
    n = 8
    run, _ = ran(Iteration(table, UNIT, n))
    end = np.concatenate(
        (
            run.values["position"][n - 1] * (1 - 1e-12),
            -(run.values["position"][n - 1] - run.values["position"][n - 2]),
        )
    )
    end[2:] /= np.hypot(*end[2:])
    back, _ = ran(Iteration(table, end, n))
    assert np.allclose(back.values["position"][1], run.values["position"][n - 2], atol=1e-8)
    assert np.allclose(back.values["position"][n - 2], run.values["position"][1], atol=1e-5)


@pytest.mark.parametrize("table", [STADIUM, RECTANGLE])
def test_a_million_bounces_keep_the_speed(table):
    run, _ = ran(Iteration(table, UNIT, 10**6))
    assert np.max(np.abs(np.hypot(*run.values["direction"].T) - 1)) < 3e-15


def test_the_mean_flight_in_a_stadium_is_pi_times_area_over_perimeter():
    """Santalo's formula, for a path that comes everywhere: what chaos leaves to be predicted."""
    problem = Iteration(STADIUM, UNIT, 128)
    flights = []
    start = UNIT
    for _ in range(400):
        run, _ = ran(Iteration(STADIUM, start, problem.n))
        flights += np.hypot(*np.diff(run.values["position"][1:], axis=0).T).tolist()
        end = np.concatenate((run.values["position"][-1] * (1 - 1e-9), run.values["direction"][-1]))
        start = end / np.array([1, 1, np.hypot(*end[2:]), np.hypot(*end[2:])])
    area = np.pi + 4
    perimeter = 2 * np.pi + 4
    assert abs(np.mean(flights) - np.pi * area / perimeter) < 0.03


def test_the_density_of_iterates_at_eta_4_is_the_arcsine_law():
    problem = Iteration(Logistic(eta=4.0), np.array([0.3]), 128)
    seen = []
    x = 0.3
    for _ in range(200):
        run, _ = ran(Iteration(problem.map, np.array([x]), 128))
        seen += run.values["x"][1:].tolist()
        x = run.values["x"][-1]
    for quantile in (0.1, 0.5, 0.9):
        assert abs(np.mean(np.array(seen) < np.sin(np.pi * quantile / 2) ** 2) - quantile) < 0.02


def test_a_map_that_it_does_not_have_is_refused():
    class Tent(Logistic, frozen=True, kw_only=True, tag="tent"):
        """Another map."""

    assert "no map tent" in ENGINE.unsupported(
        Iteration(Tent(eta=2.0), np.array([0.5]), 3), ENGINE.method("iterated-map")
    )


def test_a_direction_of_no_length_writes_nothing_out_of_bounds():
    from refdem.kernels import load, pointer

    out = np.full((2, 4), np.nan)
    n = np.array([0.0, 5.0])
    start = np.array([0.1, 0.1, 0.0, 0.0])
    arrays = pointer("maps", start), 2, pointer("maps", n), pointer("maps", out, output=True)
    assert load("maps").lib.refdem_rectangle(4.0, 2.0, *arrays) == 1
    assert np.isnan(out).all()
