"""Sweeps of the driven Duffing oscillator: each frequency goes on where the one before has
settled.
"""

from functools import cache

import numpy as np

from refdem.gallery.runs import Array, observed, observed_at

ALPHA = 1.0
"""Linear stiffness over mass [1/s^2] of Duffing's oscillator in figures 1.23 and 1.24."""
BETA = 0.4
"""Cubic stiffness over mass [1/(m^2 s^2)] there."""
FORCE = 1.5
"""Amplitude of the drive over mass [m/s^2] there."""
PER_PERIOD = 32
"""Samples in the last period, from which the amplitude is read: to (pi/32)^2/2 = 0.5 %."""
SETTLED = 9.0
"""Times 1/delta after which a run is at its amplitude to 1e-4."""


@cache
def amplitudes(delta: float, drives: tuple[float, ...]) -> Array:
    """The amplitudes (M,) [m] of settled motions at the frequencies (M,) [rad/s] of the drive.

    The frequencies are taken in their order, and each motion continues from the one before: where
    two amplitudes are possible the order decides.
    """
    x = 0.1
    v = 0.0
    settled_amplitudes = []
    for drive in drives:
        x, v, amplitude = settled(delta, drive, x, v)
        settled_amplitudes.append(amplitude)
    return np.array(settled_amplitudes)


def settled(delta: float, drive: float, x: float, v: float) -> tuple[float, float, float]:
    """Place, velocity and amplitude after SETTLED/delta seconds and more, in whole periods of the
    drive.
    """
    period = 2 * np.pi / drive
    periods = int(np.ceil(SETTLED / delta / period)) + 6
    # The start, then the last period.
    last_period = (periods - 1 + np.arange(PER_PERIOD + 1) / PER_PERIOD) * period
    t = np.r_[0.0, last_period]
    run = observed_at("driven-duffing", t, delta=delta, drive=drive, x0=x, v0=v)
    amplitude = float(np.ptp(run["x"][1:])) / 2
    return float(run["x"][-1]), float(run["v"][-1]), amplitude


def remember_run(delta: float, drive: float) -> None:
    """Remembers the command of one run of a sweep."""
    observed("driven-duffing", delta=delta, drive=drive)
