"""The truth of the scenes of stress/scenes against a Runge-Kutta integration of this file; the
reference against both.
"""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.judgement import errors
from refdem.core.problem import Request
from refdem.stress.scenes import truth_here
from refdem.stress.scenes.half_sine import HalfSine
from refdem.stress.scenes.overlap_at_start import CASE as OVERLAP
from refdem.stress.scenes.simultaneous import CASE as SIMULTANEOUS
from refdem.truth.refiner import Refiner

SCALE = {"overlap": 1.0, "rate": 1.0}


def integrated(
    square: float, start: tuple[float, float], end: float, steps: int = 20000
) -> tuple[float, float]:
    """Overlap and rate at `end` by the classical method; the force has a kink where contact ends,
    of first order in the step.
    """
    y = np.array(start)
    h = end / steps

    def rates(y: np.ndarray) -> np.ndarray:
        return np.array([y[1], -square * max(y[0], 0.0)])

    for _ in range(steps):
        a = rates(y)
        b = rates(y + h / 2 * a)
        c = rates(y + h / 2 * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + rates(y + h * c))
    return float(y[0]), float(y[1])


@pytest.mark.parametrize("start", [("1/4", "0"), ("0", "1"), ("1/8", "-1"), ("-1/4", "2")])
@pytest.mark.parametrize("end", ["1/8", "1/2", "1", "2"])
def test_the_half_sine_is_the_solution(start: tuple[str, str], end: str) -> None:
    exact = Fraction(start[0]), Fraction(start[1])
    balls = HalfSine(Refiner.of(SCALE), Fraction(9), exact).at(Fraction(end))
    seen = integrated(9.0, (float(exact[0]), float(exact[1])), float(Fraction(end)))
    assert (float(balls["overlap"].mid), float(balls["rate"].mid)) == pytest.approx(seen, abs=2e-7)


def test_the_growth_of_errors_counts_every_body() -> None:
    alone, many = (
        HalfSine(Refiner.of(SCALE), Fraction(9), (Fraction(0), Fraction(1)), bodies)
        for bodies in (1, 5)
    )
    assert many.sensitivity(Fraction(1)) == pytest.approx(
        5 * alone.sensitivity(Fraction(1)), rel=1e-6
    )


@pytest.mark.parametrize(
    "instance",
    [OVERLAP.at(samples="8"), SIMULTANEOUS.at(hits="4", samples="8")],
    ids=lambda one: one.label,
)
def test_the_reference_agrees_with_the_truth(instance: object) -> None:
    truth = truth_here(instance)
    assert truth is not None
    assert truth.until == 9
    run, _ = discovery.engine("reference").run(
        Request(problem=instance.problem, method="contact-events")
    )
    assert max(float(values.max()) for values in errors(instance, run, truth).values()) < 1e-13


def test_a_case_of_the_catalogue_has_no_truth_here() -> None:
    assert truth_here(discovery.case("pendulum").at()) is None
