"""Lines of the linear response, and those that a square makes of them, by certified motions."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.mechanics.response import (
    balanced_drives,
    balanced_force,
    fold,
    folds,
    linear_amplitude,
    linear_line,
    mixed_line,
)
from refdem.mechanics.spectral_lines import line_map, mixed_lines
from refdem.truth.sampled import sampled

DELTA = 0.25
DRIVES = (0.5, 0.8)
"""No line of three drives, as 2 w1 - w2, is at one of two."""
FORCE = 0.125
DURATION = "251.327412287183"
"""Four common periods 2 pi/0.1: lines of higher order are orthogonal to those that are fitted."""
GIVEN = {"delta": "1/4", "f0": "1/8,1/8", "drive": "1/2,4/5", "x0": "0", "duration": DURATION}


def certified_lines(eps: str) -> dict[str, complex]:
    """The lines of the last half of the certified motion, when its start is forgotten."""
    instance = discovery.case("quadratic-response").at(eps=eps, samples="256", **GIVEN)
    truth = sampled(instance.truth(), instance.times.tolist())
    settled = slice(128, 256)
    lines = mixed_lines(DRIVES, 2)
    nothing_else = np.empty((0, 128))
    rows = line_map(instance.times[settled], lines, nothing_else)
    assert rows is not None
    amplitudes = rows @ truth.value("x")[settled]
    return dict(zip([line.name for line in lines], amplitudes.tolist(), strict=True))


def predicted_lines(eps: float) -> dict[str, complex]:
    """The same to first order in eps (1.123)."""
    a1, a2 = (linear_line(FORCE, w, 1.0, DELTA) for w in DRIVES)
    w1, w2 = DRIVES

    def mixed(a: complex, b: complex, frequency: float) -> complex:
        return mixed_line(a, b, frequency, 1.0, DELTA, eps)

    # Each drive alone shifts the mean and makes a line at its double.
    shift_of_first = mixed(a1, a1.conjugate(), 0.0) / 2
    shift_of_second = mixed(a2, a2.conjugate(), 0.0) / 2
    double_of_first = mixed(a1, a1, 2 * w1) / 2
    double_of_second = mixed(a2, a2, 2 * w2) / 2
    # Both together make lines at their sum and their difference.
    total = mixed(a1, a2, w1 + w2)
    difference = mixed(a2, a1.conjugate(), w2 - w1)
    return {
        "shift": shift_of_first + shift_of_second,
        "2w1": double_of_first,
        "2w2": double_of_second,
        "w1+w2": total,
        "w2-w1": difference,
    }


def test_the_modulus_of_a_linear_line_is_the_steady_amplitude() -> None:
    amplitude = linear_amplitude(np.array([0.8]), 1.0, DELTA, FORCE)[0]
    assert abs(linear_line(FORCE, 0.8, 1.0, DELTA)) == pytest.approx(amplitude, rel=1e-15)


def test_the_shift_is_minus_eps_times_the_mean_square_over_the_stiffness() -> None:
    a1, a2 = (linear_amplitude(np.array([w]), 1.0, DELTA, FORCE)[0] for w in DRIVES)
    expected = -0.125 * (a1**2 + a2**2) / 2
    assert predicted_lines(0.125)["shift"] == pytest.approx(expected, rel=1e-14)


def test_lines_of_certified_motions_are_those_of_first_order_up_to_the_square_of_eps() -> None:
    """Halving eps quarters the relative difference, in amplitude and phase together; where it is
    small, the next term, eps^4, is, too.
    """
    of_large = certified_lines("1/16")
    of_small = certified_lines("1/32")
    for name, expected in predicted_lines(1 / 32).items():
        small = abs(of_small[name] / expected - 1)
        large = abs(of_large[name] / (2 * expected) - 1)
        assert small < 0.01
        assert large / small == pytest.approx(4.0, abs=0.1)


def test_lines_at_the_drives_are_linear_up_to_the_square_of_eps() -> None:
    of_large = certified_lines("1/16")
    of_small = certified_lines("1/32")
    for name, w in zip(("w1", "w2"), DRIVES, strict=True):
        expected = linear_line(FORCE, w, 1.0, DELTA)
        small = abs(of_small[name] / expected - 1)
        large = abs(of_large[name] / expected - 1)
        assert small < 0.01
        assert large / small == pytest.approx(4.0, abs=0.1)


def test_lines_of_a_square_change_sign_with_it() -> None:
    """Lines of an even number of drives are odd in eps, those of an odd number even."""
    plus = certified_lines("1/16")
    minus = certified_lines("-1/16")
    for name in ("shift", "2w1", "2w2", "w1+w2", "w2-w1"):
        assert minus[name] == pytest.approx(-plus[name], rel=1e-7)
    for name in ("w1", "w2"):
        assert minus[name] == pytest.approx(plus[name], rel=1e-7)


@pytest.mark.parametrize(("delta", "frequency"), [(0.05, 1.6266), (0.1, 1.6153), (0.2, 1.5664)])
def test_the_lower_fold_is_where_the_curve_of_the_figure_turns(
    delta: float, frequency: float
) -> None:
    found = folds(1.0, 0.4, delta, 1.5)
    assert found is not None
    assert found.lower[0] == pytest.approx(frequency, abs=5e-5)
    on_curve = fold(np.linspace(0.5, 3.0, 20001), 1.0, 0.4, delta, 1.5)
    assert found.lower[0] == pytest.approx(on_curve, abs=1e-7)


def test_at_a_fold_the_drive_neither_rises_nor_falls_with_the_amplitude() -> None:
    found = folds(1.0, 0.4, 0.1, 1.5)
    assert found is not None
    for drive, amplitude in found:
        assert balanced_force(amplitude, drive, 1.0, 0.4, 0.1) == pytest.approx(1.5, rel=1e-13)
        # The force at a fixed drive has an extremum by the amplitude there.
        step = 1e-4
        beside = [balanced_force(amplitude + side, drive, 1.0, 0.4, 0.1) for side in (-step, step)]
        assert beside[1] - beside[0] == pytest.approx(0.0, abs=1e-9)


def test_a_spring_that_softens_leans_the_resonance_to_lower_drives() -> None:
    """The larger amplitudes belong to the lower fold, and the drive has an extremum at both."""
    found = folds(1.0, -0.05, 0.02, 0.1)
    assert found is not None
    assert found.lower[0] < found.upper[0] < 1
    assert found.lower[1] > found.upper[1]
    for drive, amplitude in found:
        beside = [
            balanced_drives(np.array(amplitude + side), 1.0, -0.05, 0.02, 0.1)[0]
            for side in (-1e-5, 0.0, 1e-5)
        ]
        assert beside[1] == pytest.approx(drive, rel=1e-13)
        assert beside[2] - beside[0] == pytest.approx(0.0, abs=1e-9)


def test_between_the_folds_of_a_spring_that_softens_a_drive_has_three_amplitudes() -> None:
    """They are the roots S of h^2 S^3 + 2 h g S^2 + (g^2 + 4 delta^2 w^2) S = f0^2, g = alpha -
    w^2, but one near the barrier at 4.8 m, if there is one.
    """
    found = folds(1.0, -0.05, 0.02, 0.1)
    assert found is not None
    h = -0.0375

    def count(drive: float) -> int:
        g = 1 - drive**2
        roots = np.roots([h * h, 2 * h * g, g * g + (0.04 * drive) ** 2, -0.01])
        real = roots.real[abs(roots.imag) < 1e-9]
        return int(np.sum(np.sqrt(real) < 4.8))

    below, above = found.lower[0], found.upper[0]
    assert [count(below - 1e-3), count(below + 1e-3)] == [1, 3]
    assert [count(above - 1e-3), count(above + 1e-3)] == [3, 1]


@pytest.mark.parametrize(
    ("delta", "f0"),
    [
        pytest.param(0.1, 0.1, id="too much damping"),
        pytest.param(0.01, 0.3, id="both branches go on to the barrier"),
        pytest.param(2.0, 0.1, id="no resonance at all"),
    ],
)
def test_a_spring_that_softens_has_no_folds(delta: float, f0: float) -> None:
    assert folds(1.0, -0.05, delta, f0) is None


@pytest.mark.parametrize("delta", [0.25, 0.3, 2.0])
def test_much_damping_leaves_no_fold(delta: float) -> None:
    assert folds(1.0, 0.4, delta, 1.5) is None
