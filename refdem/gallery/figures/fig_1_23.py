"""Figure 1.23: amplitude and frequency of the driven Duffing oscillator by harmonic balance
(1.121), and as it runs.
"""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.sweep import ALPHA, BETA, FORCE, amplitudes, remember_run
from refdem.mechanics.response import balanced_drives, balanced_frequency, fold

DAMPINGS = (0.05, 0.1, 0.2, 0.3)
AMPLITUDES = np.linspace(0.3, 4.5, 4000)
DRIVES = tuple(np.round(np.arange(0.7, 2.5, 0.06), 3).tolist())


def figure() -> Figure:
    """Curves of harmonic balance, with the amplitudes of runs whose frequency was raised step by
    step, and lowered.
    """
    series = []
    for ink, delta in enumerate(DAMPINGS):
        series += resonance(delta, ink)
    free = balanced_frequency(AMPLITUDES, ALPHA, BETA)
    series.append(Series(x=free, y=AMPLITUDES, ink=GREY, dashed=True, label="free, undamped"))
    grid = np.linspace(0.5, 3.0, 20001)
    numbers = {}
    for delta in DAMPINGS:
        frequency = fold(grid, ALPHA, BETA, delta, FORCE)
        if frequency is not None:
            numbers[f"fold of (1.121), delta = {delta:g} [rad/s]"] = frequency
    remember_run(DAMPINGS[1], 1.5)
    panel = Panel(
        series=tuple(series),
        x=Axis(title="frequency W of the drive [rad/s]", ends=(0.6, 2.6)),
        y=Axis(title="amplitude A [m]", ends=(0.0, 4.2)),
        size=(600, 380),
    )
    caption = (
        "alpha = 1, beta = 0.4, f0 = 1.5. Curves: (1.121); dots: runs of the reference, settled,"
        " with the frequency raised step by step and lowered. The resonance leans over; between its"
        " two branches no run ever settles on the middle one."
    )
    return Figure(
        id="1.23",
        title="Leaning resonance",
        caption=caption,
        panels=(panel,),
        numbers=numbers,
        digits=5,
    )


def resonance(delta: float, ink: int) -> list[Series]:
    """One damping [1/s]: both branches of (1.121) as one curve, and the amplitudes of a sweep up
    and of a sweep down as points.
    """
    lower, higher = balanced_drives(AMPLITUDES, ALPHA, BETA, delta, FORCE)
    x = np.r_[lower, higher[::-1]]
    y = np.r_[AMPLITUDES, AMPLITUDES[::-1]]
    # A gap where (1.121) has no real root.
    drives = np.where(np.isfinite(x), x, np.nan)
    series = [Series(x=drives, y=y, ink=ink, label=f"delta = {delta:g}")]
    up = amplitudes(delta, DRIVES)
    down = amplitudes(delta, DRIVES[::-1])[::-1]
    for settled in (up, down):
        series.append(Series(x=np.array(DRIVES), y=settled, ink=ink, mark="points"))
    return series
