"""Slips about oscillators are settled by their own numbers."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.manual import oscillator_slips
from refdem.manual.oscillator_slips import half_power_width, steady_amplitudes
from refdem.manual.slip import Measured
from refdem.mechanics.response import balanced_drives


def values(measured: Measured) -> list[float]:
    return [float(value) for _, value in measured]


def test_a_drive_repeats_after_2_pi_over_its_frequency() -> None:
    after_period, after_frequency = values(oscillator_slips.period_of_the_drive())
    assert after_period == 0
    assert abs(after_frequency) > 0.1


def test_only_with_friction_the_flow_has_an_attractor() -> None:
    harmonic, viscous, coulomb = values(oscillator_slips.flow_and_attractor())
    assert harmonic == 1
    # exp(-2 delta t) with delta = 0.1 after 10 s.
    assert viscous == pytest.approx(np.exp(-2), rel=1e-5)
    assert coulomb < 0.1


def test_the_line_of_a_periodic_motion_is_as_wide_as_that_of_a_cosine() -> None:
    back, short, cosine, long, long_cosine, third = values(
        oscillator_slips.peak_of_a_periodic_motion()
    )
    assert back < 1e-8
    assert (short, long) == (cosine, long_cosine)
    assert short == pytest.approx(4 * long, rel=0.01)
    # A cosine, whose line is as wide, has none at 3 w.
    assert third > 0.01


def test_the_line_of_a_rectangular_record_has_the_width_that_is_known() -> None:
    cosine = np.cos(2 * np.pi * np.arange(64 * 160) / 64)
    # sinc^2(x) = 1/2 at x = 0.44295.
    assert half_power_width(cosine, 64) * 160 == pytest.approx(2 * 0.44295, rel=1e-3)


def test_jumps_need_no_damping_and_end_with_enough_of_it() -> None:
    assert values(oscillator_slips.damping_removes_the_jumps()) == [3, 3, 1, 1]


@pytest.mark.parametrize("delta", ["1/10", "1/5", "2/5"])
def test_steady_amplitudes_are_as_many_as_the_resonance_curve_shows(delta: str) -> None:
    drive = Fraction(9, 5)
    amplitude = np.linspace(0.01, 5, 200_001)
    lower, higher = balanced_drives(amplitude, 1.0, 0.4, float(Fraction(delta)), 1.5)
    below = np.concatenate([lower, higher[::-1]]) - float(drive)
    below = below[np.isfinite(below)]
    changes = int(np.sum(below[1:] * below[:-1] < 0))
    assert steady_amplitudes(Fraction(delta), drive=drive) == changes
