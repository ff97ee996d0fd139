"""Slips of the source chapter about oscillators: periods, flows, spectra and damping.

Each has the measurement that settles it, made on demand.
"""

import math
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from refdem.core.discovery import truth_of
from refdem.manual.slip import KnownSlip, Measured, number

Array = NDArray[np.float64]
CYCLE_START = "2.000413678"
"""Place [m] at which van der Pol's cycle with mu = 0.2 turns back."""
CYCLE_PERIOD = 6.29887671
"""Its period [s], by the Runge-Kutta method of order 8 at tolerance 2.3e-14."""
CYCLE_SAMPLES = 64
"""Samples of a cycle: harmonics beyond the 32nd are below rounding."""


def period_of_the_drive() -> Measured:
    """How far a certified steady motion under exp(i w t) is off after w, and after 2 pi/w."""
    truth = truth_of("driven-oscillator", delta="1/2", drive="3")
    # After 80 s the transient, which falls as exp(-t/2), is below 1e-17.
    late = Fraction(80)
    # Truth takes rational times: 2 pi/3 s to 2^-40 s.
    period = Fraction(round(2 * math.pi / 3 * 2**40), 2**40)
    x, after_drive, after_period = (
        float(truth.at(t)["x"].mid) for t in (late, late + 3, late + period)
    )
    amplitude = float(truth.scalars()["steady_amplitude"].mid)
    what = "steady x, of its amplitude, w = 3 rad/s: after"
    return (
        (f"change of the {what} 2 pi/w = 2.0944 s", number(_rounded(after_period - x, amplitude))),
        (f"change of the {what} w = 3 s", number(_rounded(after_drive - x, amplitude))),
    )


def _rounded(change: float, amplitude: float) -> float:
    """The change of a place as a part of the amplitude, to 1e-9: the period is off by 2^-41 s."""
    return round(change / amplitude, 9)


def flow_and_attractor() -> Measured:
    """The certified area of the outline of phase-flow after 10 s, as a part of the area at first,
    for three flows.
    """
    shown = []
    for flow in ("harmonic", "viscous", "coulomb"):
        truth = truth_of("phase-flow", flow=flow)
        start, end = (float(truth.at(Fraction(t))["area"].mid) for t in (0, 10))
        shown.append((f"area after 10 s over that at first, flow {flow}", number(end / start)))
    return tuple(shown)


def peak_of_a_periodic_motion() -> Measured:
    """The half-power width of the first line of van der Pol's certified cycle, and of a cosine of
    the same frequency, in records of two lengths.
    """
    truth = truth_of("van-der-pol", p="0", x0=CYCLE_START, v0="0")
    period = Fraction(CYCLE_PERIOD)
    place = [float(truth.at(period * k / CYCLE_SAMPLES)["x"].mid) for k in range(CYCLE_SAMPLES + 1)]
    cycle = np.array(place[:-1])
    cosine = np.cos(2 * np.pi * np.arange(CYCLE_SAMPLES) / CYCLE_SAMPLES)
    shown = [("x after one period less x at first [m]", f"{abs(place[-1] - place[0]):.0e}")]
    for cycles in (40, 160):
        for name, wave in (("the cycle", cycle), ("a cosine", cosine)):
            width = half_power_width(np.tile(wave, cycles), CYCLE_SAMPLES)
            text = f"width of the line of {name} at half power, of w, {cycles} periods"
            shown.append((text, f"{width:.3g}"))
    third = abs(np.fft.rfft(cycle)[3] / np.fft.rfft(cycle)[1])
    return (*shown, ("amplitude of the line at 3 w over that at w", number(float(third))))


def half_power_width(record: Array, samples: int) -> float:
    """Width at half power of the line at w in a record (n,) of whole periods of `samples` samples,
    as a part of w.
    """
    turns = np.arange(len(record)) / samples

    def power(offset: float) -> float:
        """|X|^2 at the frequency w (1 + offset)."""
        return float(abs(record @ np.exp(-2j * np.pi * (1 + offset) * turns)) ** 2)

    half = power(0.0) / 2
    # The line of n periods is 0 at the offsets +- 1/n: bisection inside of them.
    widths = []
    for side in (-1, 1):
        inside = 0.0
        outside = samples / len(record)
        for _ in range(40):
            middle = (inside + outside) / 2
            if power(side * middle) > half:
                inside = middle
            else:
                outside = middle
        widths.append(inside)
    return sum(widths)


def damping_removes_the_jumps() -> Measured:
    """How many steady amplitudes (1.120) has at a frequency beyond the fold, for dampings from none
    on.
    """
    shown = []
    for delta in ("0", "1/10", "1/5", "2/5"):
        many = steady_amplitudes(Fraction(delta), drive=Fraction(9, 5))
        what = "amplitudes of (1.120) at w = 9/5, alpha = 1, beta = 0.4, f0 = 1.5, delta"
        shown.append((f"{what} = {delta}", str(many)))
    return tuple(shown)


def steady_amplitudes(delta: Fraction, *, drive: Fraction) -> int:
    """The number of amplitudes of harmonic balance, exactly: 3, or 1 without hysteresis.

    S = A^2 solves h^2 S^3 + 2 g h S^2 + (g^2 + d) S - f0^2 = 0 with g = alpha - w^2, h = 3 beta/4
    and d = 4 delta^2 w^2; its real roots are positive, and there are 3 where its discriminant is.
    """
    g = 1 - drive**2
    h = Fraction(3, 4) * Fraction(2, 5)
    d = 4 * delta**2 * drive**2
    p3 = h**2
    p2 = 2 * g * h
    p1 = g**2 + d
    p0 = -Fraction(9, 4)
    discriminant = (
        18 * p3 * p2 * p1 * p0
        - 4 * p2**3 * p0
        + p2**2 * p1**2
        - 4 * p3 * p1**3
        - 27 * p3**2 * p0**2
    )
    if discriminant > 0:
        return 3
    return 1


SLIPS = (
    KnownSlip(
        cases=("driven-oscillator",),
        where="section 1.4.2, before (1.101)",
        says="the force exp(i w t) has the period w",
        holds="w is its angular frequency, and its period is 2 pi/w",
        measure=period_of_the_drive,
    ),
    KnownSlip(
        cases=("phase-flow",),
        where="section 1.4.3, before (1.107)",
        says="the flow in phase space is also called the attractor",
        holds=(
            "the flow carries every start; an attractor is a set that motions from around it tend"
            " to, and where the flow keeps areas, as without friction, there is none"
        ),
        measure=flow_and_attractor,
    ),
    KnownSlip(
        cases=("van-der-pol",),
        where="section 1.5.4, on figure 1.25",
        says="the peak of the free oscillator is broad because its motion is no exact sine",
        holds=(
            "a periodic motion has sharp lines, at w, 3 w, 5 w and so on; the width is that of the"
            " record, the same for a cosine, and falls as one over its length"
        ),
        measure=peak_of_a_periodic_motion,
    ),
    KnownSlip(
        cases=("driven-duffing",),
        where="section 1.7.2, on figure 1.24",
        says="the jumps of the resonance curve show that damping can destroy stability",
        holds=(
            "they come from the cube of the spring, are there without damping, and end when there"
            " is enough of it; damping that destabilises is that inside a shaft that turns"
        ),
        measure=damping_removes_the_jumps,
    ),
)
