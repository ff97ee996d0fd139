"""Turning points, areas, lines and answers of signals that are known."""

import numpy as np
import pytest

from refdem.mechanics import oscillation, response, spectrum


def test_turning_points_of_a_cosine_are_found_to_the_third_power_of_the_interval():
    errors = []
    for count in (200, 400):
        t = np.linspace(0.1, 20.1, count)
        times, places = oscillation.turning_points(t, 3 * np.cos(1.5 * t), -4.5 * np.sin(1.5 * t))
        expected = np.arange(1, len(times) + 1) * np.pi / 1.5
        errors.append(np.abs(times - expected).max())
        assert np.abs(places) == pytest.approx(3.0, rel=1e-4)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(3, abs=0.3)


def test_a_parabola_turns_exactly_where_it_does_also_on_a_sample():
    t = np.arange(5.0)
    for top in (1.25, 2.0):
        times, places = oscillation.turning_points(t, 7 - (t - top) ** 2, -2 * (t - top))
        assert times[0] == pytest.approx(top, abs=1e-15)
        assert places[0] == pytest.approx(7.0, abs=1e-15)


def test_amplitude_and_period_are_those_of_the_cosine():
    t = np.linspace(0.1, 30.1, 3001)
    x = 1 + 2 * np.cos(3 * t)
    v = -6 * np.sin(3 * t)
    assert oscillation.amplitude(t, x, v) == pytest.approx(2, rel=1e-7)
    assert oscillation.period(t, x, v) == pytest.approx(2 * np.pi / 3, rel=1e-7)


def test_area_of_a_square_has_the_sign_of_its_sense():
    x = np.array([0.0, 2.0, 2.0, 0.0])
    v = np.array([0.0, 0.0, 1.5, 1.5])
    assert oscillation.phase_area(x, v) == 3.0
    assert oscillation.phase_area(x[::-1], v[::-1]) == -3.0
    assert oscillation.phase_area(np.stack([x, x]), np.stack([v, 2 * v])).tolist() == [3.0, 6.0]


def test_a_rotation_carries_the_area_of_its_triangles_and_a_decay_shrinks_it():
    t = np.linspace(0, 3, 13)
    kept = oscillation.carried_area(np.cos(t), -np.sin(t))
    assert kept == pytest.approx(kept[0], rel=1e-12)
    fading = oscillation.carried_area(np.exp(-t) * np.cos(t), np.exp(-t) * np.sin(t))
    assert fading == pytest.approx(fading[0] * np.exp(-2 * t[:-2]), rel=1e-12)


def test_lines_have_amplitude_phase_and_mean():
    t = np.arange(4096) / 16
    x = 0.25 + 2 * np.cos(1.25 * t + 0.5) + 0.001 * np.cos(2.5 * t)
    assert spectrum.line(t, x, 1.25) == pytest.approx(2 * np.exp(0.5j), abs=1e-5)
    assert spectrum.line(t, x, 0).real == pytest.approx(0.25, abs=1e-5)
    assert abs(spectrum.line(t, x, 2.5)) == pytest.approx(0.001, abs=1e-5)
    frequencies, heights = spectrum.spectrum(t, x)
    assert frequencies[np.argmax(heights)] == pytest.approx(1.25, abs=2 * np.pi / 256)
    assert spectrum.frequency_of(t, x, 1.24) == pytest.approx(1.25, abs=1e-6)


def test_amplitudes_of_forced_oscillators_solve_their_equation():
    w = np.array([0.0, 0.5, 1.0, 3.0])
    answer = response.linear_amplitude(w, 1.0, 0.25, 2.0)
    assert answer == pytest.approx(np.abs(2.0 / (1.0 - w**2 + 0.5j * w)), rel=1e-14)
    where, height = response.linear_peak(1.0, 0.25, 2.0)
    assert response.linear_amplitude(np.array([where]), 1.0, 0.25, 2.0)[0] == pytest.approx(
        height, rel=1e-14
    )
    assert (
        height
        > response.linear_amplitude(np.array([where + 1e-3, where - 1e-3]), 1.0, 0.25, 2.0).max()
    )


def test_hysteresis_is_where_sweeps_differ():
    drives = np.array([1.0, 1.1, 1.2, 1.3])
    assert response.hysteresis(
        drives, np.array([1.0, 1.0, 1.0, 3.0]), np.array([1.0, 2.0, 2.5, 3.0])
    ) == (1.1, 1.2)
    assert response.hysteresis(drives, np.ones(4), 1.01 * np.ones(4)) is None


@pytest.mark.parametrize(
    ("drive", "beta", "delta"),
    [(1.5, 0.4, 0.1), (2.0, 0.4, 0.1), (1.55, 0.4, 0.2), (0.5, -0.1, 0.1), (1.2, 3.0, 0.0)],
)
def test_the_largest_balanced_amplitude_is_the_largest_root_of_its_cubic(drive, beta, delta):
    gap = 1.0 - drive**2
    h = 0.75 * beta
    drag = (2 * delta * drive) ** 2
    roots = np.roots([h * h, 2 * h * gap, gap * gap + drag, -0.25])
    largest = max(root.real for root in roots if abs(root.imag) < 1e-9)
    assert response.balanced_amplitude(drive, 1.0, beta, delta, 0.5) == pytest.approx(
        np.sqrt(largest), rel=1e-9
    )


def test_without_a_drive_the_balanced_amplitude_is_that_of_free_oscillations():
    assert response.balanced_amplitude(1.2, 1.0, 3.0, 0.1, 0.0) == 0.0
    assert response.balanced_frequency(
        np.array(response.balanced_amplitude(1.2, 1.0, 3.0, 0.0, 0.0)), 1.0, 3.0
    ) == pytest.approx(1.2)


def test_the_error_of_a_frequency_covers_what_another_line_leaks_into_it():
    t = np.arange(10000) * 0.1
    alone, rounding = spectrum.frequency_with_error(t, np.cos(1.013 * t + 1), 1.0125)
    assert alone == pytest.approx(1.013, abs=1e-9)
    assert rounding < 1e-9
    with_another = np.cos(1.013 * t + 1) + 0.5 * np.cos(1.15 * t)
    found, error = spectrum.frequency_with_error(t, with_another, 1.0125)
    assert abs(found - 1.013) < error < 1e-5
