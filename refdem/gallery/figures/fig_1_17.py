"""Figure 1.17: amplitude of the driven linear oscillator over the frequency of the drive, for
several dampings (1.105), (1.106).
"""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.runs import Array, observed, observed_at
from refdem.mechanics.response import linear_peak

DAMPINGS = (0.1, 0.15, 0.2, 0.3, 0.5)
SETTLED = 24.0
"""Times 1/delta after which the transient is round-off."""


def figure() -> Figure:
    """Amplitudes of settled runs, and the maxima that (1.106) predicts."""
    drives = np.linspace(0.05, 2.0, 118)
    curves = []
    numbers = {}
    for ink, delta in enumerate(DAMPINGS):
        a = np.array([steady_amplitude(w, delta) for w in drives])
        curves.append(Series(x=drives, y=a, label=f"delta = {delta:g}", ink=ink))
        numbers[f"largest |A| seen, delta = {delta:g} [m]"] = float(a.max())
    observed("driven-oscillator", delta=DAMPINGS[0], drive=drives[57])
    dampings = np.geomspace(DAMPINGS[0], 0.7, 60)
    peaks = np.array([linear_peak(1.0, delta, 1.0) for delta in dampings])
    maxima = Series(x=peaks[:, 0], y=peaks[:, 1], label="maxima (1.106)", ink=GREY, dashed=True)
    panel = Panel(
        series=(*curves, maxima),
        x=Axis(title="frequency w of the drive [rad/s]"),
        y=Axis(title="|A| [m]"),
        size=(560, 340),
    )
    caption = (
        "w0 = 1, f0 = 1. Each point is a run that has settled: its place and velocity at one"
        " instant give the amplitude. The maxima lie at w^2 = w0^2 - 2 delta^2 and are f0/(2 delta"
        " sqrt(w0^2 - delta^2)) high, as long as delta < w0/sqrt 2."
    )
    return Figure(
        id="1.17", title="Resonance", caption=caption, panels=(panel,), numbers=numbers, digits=4
    )


def steady_amplitude(drive: float, delta: float) -> float:
    """hypot(x, v/w) [m] of the reference's run from rest, SETTLED/delta later."""
    late: Array = np.array([0.0, SETTLED / delta])
    run = observed_at("driven-oscillator", late, delta=delta, drive=float(drive), x0=0, v0=0)
    return float(np.hypot(run["x"][-1], run["v"][-1] / drive))
