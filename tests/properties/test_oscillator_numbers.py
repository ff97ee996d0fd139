"""What the catalogue says of the oscillators in numbers, measured on motions of the reference."""

from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.mechanics import oscillation, response, spectrum
from refdem.truth.sampled import sampled


def moved(case, times, **given):
    """x and v at the times by the best method of the reference."""
    instance = discovery.case(case).at(**given)
    problem = Motion(instance.scene, np.asarray(times, float))
    run, _ = ENGINE.run(Request(problem=problem, method=ENGINE.best(problem).name))
    seen = instance.observe(run)
    return seen["x"], seen["v"]


@pytest.mark.parametrize("delta", ["0.05", "1", "1.5"])
def test_phase_area_shrinks_as_exp_of_minus_2_delta_t(delta):
    t = np.linspace(0, 6, 49)
    area = oscillation.carried_area(
        *moved("viscous-oscillator", t, delta=delta, gravity="2", v0="-1")
    )
    assert area == pytest.approx(
        area[0] * np.exp(-2 * float(delta) * t[:-2]), rel=1e-6, abs=1e-13 * abs(area[0])
    )


@pytest.mark.parametrize(
    "given", [{}, {"mass": "2", "stiffness": "3", "friction_force": "0.05", "x0": "-0.7"}]
)
def test_turning_points_and_largest_speeds_under_dry_friction_lie_on_one_straight_line(given):
    """x0 - 2 f w0 t/(pi k), the speeds in units of w0; the line ends where the mass has stopped."""
    scalars = discovery.case("coulomb-oscillator").at(**given).truth().scalars()
    p = discovery.case("coulomb-oscillator").at(**given).p
    w0 = np.sqrt(p.stiffness / p.mass)
    end = float(scalars["stop_time"].mid)
    t = np.linspace(0, end * (1 - 1e-9), 20001)
    x, v = moved("coulomb-oscillator", t, **given)
    for when, size in (oscillation.turning_points(t[1:], x[1:], v[1:]), _tops(t, np.abs(v) / w0)):
        assert len(when) >= int(scalars["half_cycles"].mid) - 1
        assert np.abs(size) == pytest.approx(
            abs(p.x0) - 2 * p.friction_force * w0 * when / (np.pi * p.stiffness), abs=2e-4
        )


def _tops(t, size):
    """Times and heights of the largest values."""
    at = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
    return t[at], size[at]


@pytest.mark.parametrize("delta", ["0.1", "0.4", "0.8"])
def test_driven_amplitude_follows_the_resonance_curve(delta):
    t = np.linspace(60, 80, 2001) / float(delta) ** 0.5 * (1 if delta != "0.1" else 2)
    for drive in ("0.3", "0.9", "1", "1.7"):
        x, v = moved("driven-oscillator", np.r_[0.0, t], delta=delta, drive=drive, f0="3/2")
        expected = response.linear_amplitude(float(drive), 1.0, float(delta), 1.5)
        assert oscillation.amplitude(t, x[1:], v[1:]) == pytest.approx(expected, rel=2e-4)


def test_resonance_peaks_below_w0_and_there_is_no_peak_above_w0_over_root_two():
    drives = np.linspace(0.01, 2, 4000)
    curve = response.linear_amplitude(drives, 1.0, 0.4, 1.5)
    where, height = response.linear_peak(1.0, 0.4, 1.5)
    assert drives[np.argmax(curve)] == pytest.approx(where, abs=1e-3)
    assert curve.max() == pytest.approx(height, rel=1e-6)
    assert np.argmax(response.linear_amplitude(drives, 1.0, 0.71, 1.5)) == 0


def test_undamped_at_resonance_the_envelope_grows_as_f0_t_over_2_w0():
    t = np.linspace(0, 200, 20001)
    x, v = moved("driven-oscillator", t, delta="0", drive="2", stiffness="4", f0="3", x0="0")
    when, where = oscillation.turning_points(t[1:], x[1:], v[1:])
    assert np.abs(where)[5:] == pytest.approx(3 * when[5:] / 4, rel=2e-3)
    assert abs(where[-1]) == pytest.approx(3 * when[-1] / 4, rel=1e-5)


@pytest.mark.parametrize("exponent", ["1", "3/2", "2", "3"])
def test_period_of_a_power_law_is_the_formulas(exponent):
    period = discovery.case("power-oscillator").at(exponent=exponent).truth().scalars()["period"]
    t = np.linspace(0, 40, 4001)
    for amplitude in ("1", "1/2"):
        x, v = moved("power-oscillator", t, exponent=exponent, amplitude=amplitude)
        scaled = float(period.mid) * float(Fraction(amplitude)) ** (
            (1 - float(Fraction(exponent))) / 2
        )
        assert oscillation.period(t[1:], x[1:], v[1:]) == pytest.approx(scaled, rel=2e-6)


def exact_frequency(amplitude, alpha="1", beta="1"):
    """2 pi/T of the certified period."""
    truth = discovery.case("duffing").at(alpha=alpha, beta=beta, amplitude=amplitude).truth()
    return (
        Fraction("6.28318530717958647692528676655900576839433879875")
        / truth.scalars()["period"].mid
    )


@pytest.mark.parametrize("beta", ["1", "-1"])
def test_harmonic_balance_misses_by_3_over_256_and_1_116_by_21_over_256(beta):
    amplitude = "1/1000"
    part = Fraction(beta) * Fraction(amplitude) ** 2
    w = exact_frequency(amplitude, beta=beta)
    first_order = 1 + 3 * part / 8
    root = 1 + 3 * part / 8 - 9 * part**2 / 128 + 27 * part**3 / 1024  # of 1 + 3 part/4
    assert float((root - w) / part**2) == pytest.approx(3 / 256, rel=1e-4)
    assert float((first_order - w) / part**2) == pytest.approx(21 / 256, rel=1e-4)
    assert response.balanced_frequency(1e-3, 1.0, float(beta)) == pytest.approx(
        float(root), rel=1e-15
    )


def test_third_harmonic_is_beta_a_cubed_over_32_alpha():
    w = float(exact_frequency("1/10", alpha="2", beta="3"))
    t = np.arange(4096) * (2 * np.pi / w * 64 / 4096)
    x, _ = moved("duffing", t, alpha="2", beta="3", amplitude="1/10")
    assert abs(spectrum.line(t, x, 3 * w)) == pytest.approx(3 * 0.1**3 / (32 * 2), rel=0.02)
    assert abs(spectrum.line(t, x, 2 * w)) < 1e-10


def settled(drive, delta, x, v, periods):
    """The state after so many periods of the drive, and half the height of the last."""
    period = 2 * np.pi / drive
    t = np.r_[0.0, (periods - 1) * period + np.arange(65) * period / 64]
    given = {"delta": repr(delta), "drive": repr(drive), "x0": f"{x:.15g}", "v0": f"{v:.15g}"}
    x, v = moved("driven-duffing", t, **given)
    return x[-1], v[-1], float(np.ptp(x[1:])) / 2


def sweep(drives, delta):
    """Amplitudes at the frequencies one after another, each going on where the one before has
    settled.
    """
    x = 0.1
    v = 0.0
    found = []
    for drive in drives.tolist():
        x, v, amplitude = settled(drive, delta, x, v, round(3 / delta) + 10)
        found.append(amplitude)
    return np.array(found)


@pytest.mark.parametrize(("delta", "lowest"), [(0.05, 1.6266), (0.1, 1.6153), (0.2, 1.5664)])
def test_sweeps_up_and_down_differ_above_the_fold(delta, lowest):
    drives = np.round(np.arange(1.5, 1.9, 0.02), 3)
    found = response.hysteresis(drives, sweep(drives, delta), sweep(drives[::-1], delta)[::-1])
    balanced = response.fold(np.linspace(0.5, 3, 200001), 1.0, 0.4, delta, 1.5)
    assert balanced == pytest.approx(lowest, abs=5e-5)
    assert found is not None
    assert found[0] == pytest.approx(lowest, abs=0.03)
    assert found[1] == (1.88 if delta < 0.2 else pytest.approx(1.64, abs=0.03))


def certified_amplitude(drive, x0):
    """The largest certified |x| in the last quarter of 96 s, by when exp(-delta t) is 1e-4."""
    given = {"drive": drive, "x0": x0, "duration": "96", "samples": "384"}
    instance = discovery.case("driven-duffing").at(**given)
    x = sampled(instance.truth(), instance.times.tolist()).value("x")
    return float(np.abs(x[288:]).max())


def test_certified_motions_settle_on_two_amplitudes_above_the_fold_and_on_one_below():
    """The fold is at 1.6153; at 9/5 the three roots S of (1.120) are those of a cubic."""
    detuning = 1 - 1.8**2
    cubic = 0.75 * 0.4
    roots = np.roots(
        [cubic**2, 2 * cubic * detuning, detuning**2 + (0.2 * 1.8) ** 2, -(1.5**2)]
    ).real
    low, _, high = np.sqrt(np.sort(roots))
    assert certified_amplitude("9/5", "3") == pytest.approx(high, rel=0.05)
    assert certified_amplitude("9/5", "0") == pytest.approx(low, rel=0.02)
    assert certified_amplitude("3/2", "3") == pytest.approx(
        certified_amplitude("3/2", "0"), rel=1e-3
    )


def test_with_much_damping_there_is_no_hysteresis():
    drives = np.round(np.arange(1.2, 1.7, 0.05), 3)
    assert response.hysteresis(drives, sweep(drives, 0.3), sweep(drives[::-1], 0.3)[::-1]) is None
    assert response.fold(np.linspace(0.5, 3, 200001), 1.0, 0.4, 0.3, 1.5) is None


def test_harmonic_balance_solves_its_own_equation():
    """(1.120) without the root: A^2 ((k - W^2)^2 + 4 delta^2 W^2) = f0^2."""
    amplitude = np.array([0.5, 1.0, 2.0, 3.0])
    for drive in response.balanced_drives(amplitude, 1.0, 0.4, 0.1, 1.5):
        seen = np.isfinite(drive)
        stiffness = 1.0 + 0.3 * amplitude**2
        left = amplitude**2 * ((stiffness - drive**2) ** 2 + 0.04 * drive**2)
        assert seen.any()
        assert left[seen] == pytest.approx(2.25, rel=1e-12)


def test_a_square_doubles_the_frequency_and_shifts_the_middle():
    w = 0.3125
    t = np.arange(8192) * 0.125 + 400
    given = {"eps": "1/50", "delta": "1/20", "f0": "1/5,0", "drive": "0.3125,1", "x0": "0"}
    x, _ = moved("quadratic-response", np.r_[0.0, t], **given)
    x = x[1:]
    a = abs(spectrum.line(t, x, w))
    assert a == pytest.approx(0.2 / np.hypot(1 - w**2, 0.1 * w), rel=1e-3)
    assert abs(spectrum.line(t, x, 2 * w)) == pytest.approx(
        0.02 * a**2 / 2 / np.hypot(1 - 4 * w**2, 0.1 * 2 * w), rel=5e-3
    )
    assert spectrum.line(t, x, 0).real == pytest.approx(-0.02 * a**2 / 2, rel=5e-3)


def test_two_drives_mix_to_their_sum_and_difference():
    w1 = 0.3125
    w2 = 0.5
    t = np.arange(8192) * 0.125 + 400
    given = {"eps": "1/50", "delta": "1/20", "f0": "1/5,1/5", "drive": "0.3125,0.5", "x0": "0"}
    x = moved("quadratic-response", np.r_[0.0, t], **given)[0][1:]
    a1, a2 = (abs(spectrum.line(t, x, w)) for w in (w1, w2))
    for w in (w1 + w2, w2 - w1):
        assert abs(spectrum.line(t, x, w)) == pytest.approx(
            0.02 * a1 * a2 / np.hypot(1 - w**2, 0.1 * w), rel=2e-2
        )
    frequencies, heights = spectrum.spectrum(t, x)
    floor = heights[np.abs(frequencies - 0.65).argmin()]
    assert all(
        heights[np.abs(frequencies - w).argmin()] > 30 * floor
        for w in (w1 + w2, w2 - w1, 2 * w1, 2 * w2, 0.0)
    )


def test_free_van_der_pol_has_amplitude_2_00041_and_frequency_0_99751():
    t = np.linspace(150, 250, 20001)
    x, v = moved("van-der-pol", np.r_[0.0, t], p="0")
    assert oscillation.amplitude(t, x[1:], v[1:]) == pytest.approx(2.00041, abs=1e-5)
    assert 2 * np.pi / oscillation.period(t, x[1:], v[1:]) == pytest.approx(0.99751, abs=1e-5)


def test_a_driven_van_der_pol_has_lines_at_2w_less_wd_and_3w_less_2wd():
    t = np.arange(16384) * 0.0625 + 100
    x = moved("van-der-pol", np.r_[0.0, t], p="1/25")[0][1:]
    w = spectrum.frequency_of(t, x, 0.9975)
    lines = {
        name: abs(spectrum.line(t, x, at))
        for name, at in (("first", 2 * w - 1.15), ("second", 3 * w - 2.3), ("drive", 1.15))
    }
    assert (2 * w - 1.15, 3 * w - 2.3) == pytest.approx((0.85, 0.7), abs=0.02)
    assert lines["drive"] > lines["first"] > lines["second"] > 1e-3
    between = abs(spectrum.line(t, x, (5 * w - 3.45) / 2))
    assert lines["second"] > 10 * between
    free = moved("van-der-pol", np.r_[0.0, t], p="0")[0][1:]
    assert abs(spectrum.line(t, free, 2 * w - 1.15)) < 1e-4
