"""Figure 1.21: period and amplitude of the linear oscillator, the oscillator with a square, and the
pendulum (1.92), (1.112), (1.113).
"""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.runs import ObservedRun, observed, observed_at
from refdem.mechanics.oscillation import period

CLOCK = {"duration": 14, "samples": 700}
ISOCHRONOUS = "1.195254"
"""The amplitude [m] at which n = 2 has the period 2 pi."""
AMPLITUDES = np.geomspace(0.1, 3.0, 48)
LONG = np.linspace(0.0, 45.0, 901)
"""Samples [s] from which a period is measured: the longest is 20 s."""
INKS = {"linear": GREY, "n = 2": 0, "pendulum": 1}


def figure() -> Figure:
    """Motions from two amplitudes, and the periods over the amplitude."""
    numbers = {
        f"period of n = 2 at {ISOCHRONOUS} m [s]": measured("n = 2", float(ISOCHRONOUS)),
        "period of n = 2 at 2 m [s]": measured("n = 2", 2.0),
        "period of the pendulum at 2 rad [s]": measured("pendulum", 2.0),
    }
    caption = (
        "All of them with m = k = 1, l = g = 1. Solid: amplitude 2; dashed: the amplitude at which"
        " the period is 2 pi (for the pendulum, which has it at no amplitude, 1/5; for the linear"
        " one, which has it at every amplitude, 1). A force that grows slower than its stretch"
        " makes the period longer with the amplitude, one that grows faster makes it shorter."
    )
    return Figure(
        id="1.21",
        title="Period and amplitude",
        caption=caption,
        panels=(motions(), periods()),
        columns=2,
        numbers=numbers,
        digits=7,
    )


def motions() -> Panel:
    """Each oscillator released at a large and at a small amplitude, over the time."""
    pairs = {
        "linear": [linear(2), linear(1)],
        "n = 2": [square(2), square(ISOCHRONOUS)],
        "pendulum": [swing(2), swing("1/5")],
    }
    curves = []
    for kind, (large, small) in pairs.items():
        name = "x"
        if kind == "pendulum":
            name = "theta"
        curves.append(Series(x=large.t, y=large[name], ink=INKS[kind], label=kind))
        curves.append(Series(x=small.t, y=small[name], ink=INKS[kind], dashed=True))
    return Panel(
        series=tuple(curves),
        x=Axis(title="t [s]", ends=(0, 14)),
        y=Axis(title="x [m], angle [rad]"),
        size=(430, 300),
    )


def periods() -> Panel:
    """The period of each oscillator over the amplitude."""
    curves = []
    for kind, ink in INKS.items():
        values = np.array([measured(kind, a) for a in AMPLITUDES])
        curves.append(Series(x=AMPLITUDES, y=values, ink=ink, label=kind))
    return Panel(
        series=tuple(curves),
        x=Axis(title="amplitude [m], of the pendulum [rad]"),
        y=Axis(title="period [s]", ends=(0.0, 20.0)),
        size=(330, 300),
    )


def linear(amplitude: object) -> ObservedRun:
    """The linear oscillator released at an amplitude [m]."""
    return observed("harmonic-oscillator", x0=amplitude, v0=0, **CLOCK)


def square(amplitude: object) -> ObservedRun:
    """The oscillator whose force grows as the square."""
    return observed("power-oscillator", exponent=2, amplitude=amplitude, **CLOCK)


def swing(amplitude: object) -> ObservedRun:
    """The pendulum released at an angle [rad]."""
    return observed("pendulum", gravity=1, theta0=amplitude, **CLOCK)


def measured(kind: str, amplitude: float) -> float:
    """The period [s] from the turning points of a run."""
    a = float(amplitude)
    if kind == "pendulum":
        run = observed_at("pendulum", LONG, gravity=1, theta0=a)
        return period(run.t, run["theta"], run["thetadot"])
    if kind == "linear":
        run = observed_at("harmonic-oscillator", LONG, x0=a, v0=0)
    else:
        run = observed_at("power-oscillator", LONG, exponent=2, amplitude=a)
    return period(run.t, run["x"], run["v"])
