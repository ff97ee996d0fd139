"""Spectra of sampled signals: the amplitude of a line, the whole spectrum, and the frequency of a
line.

With a Hann window another line at distance dw leaks in by about (2 pi/(T dw))^3, T being the length
of the record.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def hann(count: int) -> Array:
    """The periodic Hann window 1 - cos(2 pi k/count) (count,), of mean 1."""
    return 1.0 - np.cos(2 * np.pi * np.arange(count) / count)


def line(t: Array, x: Array, frequency: float) -> complex:
    """Complex amplitude c of the spectral line Re(c exp(i w t)) at w = `frequency` [rad/s], or the
    mean for w = 0.

    It is 2 <window x exp(-i w t)> over evenly spaced samples x (T,) at t (T,) [s].
    """
    component = np.mean(hann(len(t)) * x * np.exp(-1j * frequency * t))
    if frequency == 0:
        return complex(component)
    # A real signal has the other half of its line at -w.
    return complex(2 * component)


def spectrum(t: Array, x: Array) -> tuple[Array, Array]:
    """Frequencies (F,) [rad/s] and amplitudes (F,) of evenly spaced samples x (T,) at t (T,) [s]; a
    cos(w t) gives a peak of height a.
    """
    count = len(t)
    # a_k = 2 |sum window x exp(-i w_k t)|/count, without the factor 2 at w = 0.
    amplitude = 2 * np.abs(np.fft.rfft(hann(count) * x)) / count
    amplitude[0] /= 2
    frequency = 2 * np.pi * np.fft.rfftfreq(count, t[1] - t[0])
    return frequency, amplitude


def frequency_of(t: Array, x: Array, near: float) -> float:
    """The frequency [rad/s] of the line near `near`, less than 2 pi/T away, from its phases in the
    two halves of the record.
    """
    half = len(t) // 2
    w = near
    for _ in range(20):
        first = line(t[:half], x[:half], w)
        second = line(t[half : 2 * half], x[half : 2 * half], w)
        # At the exact frequency the phases in both halves are equal. An error dw makes them differ
        # by dw times the time between them: w <- w + (phase_2 - phase_1)/(t_2 - t_1).
        phase_gain = float(np.angle(second / first))
        correction = phase_gain / float(t[half] - t[0])
        w += correction
        if abs(correction) < 1e-15 * abs(near):
            break
    return w


def frequency_with_error(t: Array, x: Array, near: float) -> tuple[float, float]:
    """The frequency [rad/s] of the line near `near`, and as its error the largest change if the
    first or the last quarter of the record is left out.

    Leakage from other lines decreases with the third power of the length, so that it is larger in
    three quarters of a record than in the whole.
    """
    quarter = len(t) // 4
    whole = frequency_of(t, x, near)
    without_first = frequency_of(t[quarter:], x[quarter:], near)
    without_last = frequency_of(t[:-quarter], x[:-quarter], near)
    error = max(abs(without_first - whole), abs(without_last - whole))
    return whole, error
