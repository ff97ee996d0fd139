"""A bound that is above a tenth of what it judges decides nothing; a value beyond it fails all the
same.
"""

import msgspec
import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.check import Subject
from refdem.core.engine import Method
from refdem.core.finding import Finding
from refdem.core.judgement import Sight, judged, left_at_finest, movements, sharpest, worst
from refdem.core.truth import SampledTruth

WORDS = {
    "check": "error",
    "quantity": "x",
    "unit": "1",
    "basis": "a reason",
    "what": "The error of x",
}
T = np.linspace(0.0, 1.0, 5)


@pytest.mark.parametrize(
    ("value", "signal", "outcome"),
    [
        (0.2, 10.0, "pass"),
        (0.2, 2.9, "undecided"),
        (0.4, 2.9, "fail"),
        (0.4, 10.0, "fail"),
        (0.2, 0.0, "pass"),
    ],
)
def test_a_bound_above_a_tenth_of_the_motion_passes_nothing(value, signal, outcome):
    assert judged(value=value, bound=0.3, sight=Sight(0.3, signal), **WORDS).outcome == outcome


def test_what_is_not_decided_says_why():
    finding = judged(value=0.2, bound=0.3, sight=Sight(0.3, 0.01), **WORDS)
    assert finding.sentence.startswith(
        "Undecided: the allowed error is more than a tenth of how far the quantity moves; use"
        " smaller steps, or a longer run. It is allowed 0.3, and moves by 0.01."
    )
    assert finding.sharpness == pytest.approx(30)


def test_what_moves_by_round_off_alone_is_not_given_as_a_number():
    smallest = float(np.finfo(float).tiny)
    finding = judged(value=0.2, bound=0.3, sight=Sight(0.3, smallest), **WORDS)
    assert finding.outcome == "undecided"
    assert "It is allowed 0.3, and moves by no more than round-off." in finding.sentence


def test_a_number_that_is_none_fails_however_blind_the_bound():
    assert judged(value=np.nan, bound=0.3, sight=Sight(0.3, 0.01), **WORDS).outcome == "fail"


def test_a_signal_too_small_to_divide_by_makes_no_warning():
    assert sharpest(np.array([1e200, 1.0]), np.array([1e-200, 1.0])) == Sight(1.0, 1.0)


def test_a_curve_is_seen_by_its_sharpest_sample_and_a_motion_counts_from_its_largest_way():
    sight = sharpest(np.array([1.0, 1.0, 2.0, 3.0]), np.array([0.0, 50.0, 40.0, 40.0]))
    assert (sight.bound, sight.signal) == (1.0, 50.0)


def test_one_sharp_sample_lets_a_curve_decide():
    allowed = np.array([0.3, 0.3, 0.3, 0.3, 0.01])
    assert (
        worst(t=T, values=np.zeros(5), allowed=allowed, signal=np.full(5, 1.0), **WORDS).outcome
        == "pass"
    )
    assert (
        worst(t=T, values=np.zeros(5), allowed=0.3, signal=np.full(5, 1.0), **WORDS).outcome
        == "undecided"
    )


def test_a_quantity_without_a_signal_is_a_law_and_decides():
    finding = worst(t=T, values=np.zeros(5), allowed=0.3, **WORDS)
    assert (finding.outcome, finding.sharpness) == ("pass", None)


def test_a_finding_of_an_older_version_is_read():
    old = (
        b'{"check":"error","quantity":"x","outcome":"pass","sentence":"said",'
        b'"value":0.1,"bound":1.0}'
    )
    assert msgspec.json.decode(old, type=Finding).sharpness is None


def test_the_truth_of_an_angle_moves_modulo_a_turn_and_an_attitude_as_one_rotation():
    instance = discovery.case("free-rigid-body").at()
    turn = [np.cos(0.25), 0.0, 0.0, np.sin(0.25)]
    values = {
        f"attitude.{axis}": [start, end]
        for axis, start, end in zip("wxyz", (1.0, 0.0, 0.0, 0.0), turn, strict=True)
    }
    truth = SampledTruth(
        t=[0.0, 1.0],
        values=values,
        radii={},
        sensitivity=[1.0, 1.0],
        scalars={},
        method="",
        witness="",
        until=2,
    )
    np.testing.assert_allclose(movements(instance, truth)["attitude"], [0.0, 0.5], atol=1e-15)


def test_an_error_of_the_order_may_be_a_few_times_what_the_coarsest_step_leaves():
    instance = discovery.case("harmonic-oscillator").at()
    method = Method(name="m", summary="", control="step", order=2)
    subject = Subject(instance=instance, method=method, levels=(0.4, 0.2, 0.1), truth=None)
    assert left_at_finest(subject, np.array([0.0, 0.16])) == pytest.approx(4 * 0.01)
