"""Lines at known frequencies: which there are, and the linear map that gives them."""

import numpy as np
import pytest

from refdem.mechanics.spectral_lines import (
    Line,
    cycle_frequency,
    cycle_lines,
    free_motions,
    line_map,
    mixed_lines,
)


def test_a_square_makes_a_shift_doubles_sums_and_differences() -> None:
    found = {line.name: line.frequency for line in mixed_lines([0.5, 0.75], 2)}
    assert found == {
        "shift": 0.0,
        "w1": 0.5,
        "w2": 0.75,
        "2w1": 1.0,
        "2w2": 1.5,
        "w1+w2": 1.25,
        "w2-w1": 0.25,
    }


def test_the_difference_of_drives_is_positive_whichever_is_faster() -> None:
    names = {line.name: line.frequency for line in mixed_lines([0.75, 0.5], 2)}
    assert names["w1-w2"] == 0.25
    assert all(frequency >= 0 for frequency in names.values())


def test_a_cube_makes_the_third_and_no_second_line() -> None:
    assert mixed_lines([2.0], 3, odd=True) == (Line("shift", 0.0), Line("w", 2.0), Line("3w", 6.0))
    names = {line.name for line in mixed_lines([1.0, 1.15], 3, odd=True)}
    assert names >= {"2w1-w2", "2w2-w1", "2w1+w2", "3w1", "3w2"}
    assert not names & {"2w1", "w1+w2", "w2-w1"}


def test_of_lines_at_one_frequency_the_simplest_is_kept() -> None:
    """2 w1 = w2 and w2 - w1 = w1."""
    names = [line.name for line in mixed_lines([1.0, 2.0], 2)]
    assert names == ["shift", "w1", "w2", "w1+w2", "2w2"]


def test_the_map_gives_back_amplitudes_and_phases_beside_a_free_motion() -> None:
    t = np.linspace(0.0, 40.0, 81)
    lines = mixed_lines([0.5, 0.75], 2)
    amplitudes = np.array([0.5 + 0j, 1 - 2j, -3j, 0.25 + 1j, -1 - 1j, 2 + 0j, 1j])
    free = free_motions(t, 1.0, 0.125)
    signal = 3.0 * free[0] - free[1]
    for amplitude, line in zip(amplitudes, lines, strict=True):
        signal = signal + np.real(amplitude * np.exp(1j * line.frequency * t))
    rows = line_map(t, lines, free)
    assert rows is not None
    assert np.max(np.abs(rows @ signal - amplitudes)) < 1e-13


@pytest.mark.parametrize("delta", [0.0, 0.25, 1.0, 1.0 + 1e-9, 3.0])
def test_free_motions_solve_the_equation_in_every_regime(delta: float) -> None:
    """By differences of 4th order over h = 1/64, right to h^4/90 of the sixth derivative."""
    h = 1 / 64
    t = np.arange(0.0, 2.0, h)
    for x in free_motions(t, 1.0, delta):
        first = (x[:-4] - 8 * x[1:-3] + 8 * x[3:-1] - x[4:]) / (12 * h)
        second = (-x[:-4] + 16 * x[1:-3] - 30 * x[2:-2] + 16 * x[3:-1] - x[4:]) / (12 * h * h)
        left = second + 2 * delta * first + x[2:-2]
        rate = delta + np.sqrt(abs(delta**2 - 1))
        assert np.max(np.abs(left)) < max(1.0, rate) ** 6 * h**4


@pytest.mark.parametrize(
    ("t", "drives"),
    [
        (np.linspace(0.0, 40.0, 9), [0.5, 0.75]),
        # Samples at the period of the drive see a constant.
        (np.arange(0.0, 40.0), [2 * np.pi]),
        # Without damping the free motion is a line at 1 rad/s.
        (np.linspace(0.0, 40.0, 81), [1.0]),
    ],
)
def test_lines_that_the_samples_do_not_tell_apart_have_no_map(t, drives) -> None:
    assert line_map(t, mixed_lines(drives, 2), free_motions(t, 1.0, 0.0)) is None


def test_a_cycle_and_a_drive_are_named_as_in_the_source() -> None:
    found = {line.name: line.frequency for line in cycle_lines(1.0, 1.15, 5)}
    assert found["w"] == 1.0
    assert found["wd"] == 1.15
    assert found["2w-wd"] == pytest.approx(0.85)
    assert found["3w-2wd"] == pytest.approx(0.7)
    assert not set(found) & {"2w", "w+wd", "wd-w"}


@pytest.mark.parametrize("pulled", [-0.06, 0.0, 0.014, 0.07])
def test_the_frequency_of_a_cycle_is_found_beside_that_of_the_drive(pulled) -> None:
    t = 45 + np.arange(180) * 0.4
    w = 1.0 + pulled
    x = 2 * np.cos(w * t) + 0.1 * np.cos(1.15 * t + 1) + 0.05 * np.sin((2 * w - 1.15) * t)
    x += 0.01 * np.cos(3 * w * t)
    assert cycle_frequency(t, x, 1.0, 1.15, 5) == pytest.approx(w, abs=1e-7)


def test_a_drive_at_the_frequency_of_a_cycle_leaves_it_where_it_is() -> None:
    t = np.arange(100) * 0.4
    assert cycle_frequency(t, np.cos(t), 1.0, 1.0, 3) == 1.0
