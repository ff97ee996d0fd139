"""Spectra of sampled signals: the amplitude of a line, the whole spectrum, and the frequency of a
line.

A Hann window makes the leakage of every other line fall as the inverse cube of its distance in
units of 2 pi/T.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def hann(count: int) -> Array:
    """The periodic Hann window (count,): 1 - cos(2 pi k/count), of mean 1."""
    return 1.0 - np.cos(2 * np.pi * np.arange(count) / count)


def line(t: Array, x: Array, frequency: float) -> complex:
    """Complex amplitude c of the line Re(c exp(i w t)) at w = `frequency` [rad/s]; of the mean for
    w = 0.

    t (T,) [s] evenly spaced, x (T,). Other lines leak in by (2 pi/(T dw))^3.
    """
    found = np.mean(hann(len(t)) * x * np.exp(-1j * frequency * t))
    if frequency == 0:
        return complex(found)
    # Half of a real line is at -w.
    return complex(2 * found)


def spectrum(t: Array, x: Array) -> tuple[Array, Array]:
    """Frequencies (F,) [rad/s] and amplitudes (F,) of evenly spaced samples x (T,) at t (T,) [s]; a
    line a cos(w t) has height a.
    """
    count = len(t)
    amplitude = 2 * np.abs(np.fft.rfft(hann(count) * x)) / count
    amplitude[0] /= 2
    frequency = 2 * np.pi * np.fft.rfftfreq(count, t[1] - t[0])
    return frequency, amplitude


def frequency_of(t: Array, x: Array, near: float) -> float:
    """The frequency [rad/s] of the line next to `near`, which is within 2 pi/T of it: from its
    phase in two halves of the record.
    """
    half = len(t) // 2
    w = near
    for _ in range(20):
        first = line(t[:half], x[:half], w)
        second = line(t[half : 2 * half], x[half : 2 * half], w)
        # What the phase gains from one half to the next is the error of the frequency.
        gained = float(np.angle(second / first))
        by = gained / float(t[half] - t[0])
        w += by
        if abs(by) < 1e-15 * abs(near):
            break
    return w
