"""Figure 1.24: hysteresis of the nonlinear resonance: the path up and the path down."""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.runs import Array
from refdem.gallery.sweep import ALPHA, BETA, FORCE, amplitudes, remember_run
from refdem.mechanics.response import balanced_drives, hysteresis

DELTA = 0.1
"""The damping of the figure [1/s]."""
DRIVES = np.round(np.arange(0.8, 2.6, 0.03), 3)


def figure() -> Figure:
    """Amplitudes of a sweep up and of a sweep down, with the points A to F where they part and
    meet.
    """
    up = amplitudes(DELTA, tuple(DRIVES.tolist()))
    down = amplitudes(DELTA, tuple(DRIVES[::-1].tolist()))[::-1]
    jumps = hysteresis(DRIVES, up, down)
    assert jumps is not None
    lowest, highest = jumps
    first = int(np.argmin(abs(DRIVES - lowest)))
    last = int(np.argmin(abs(DRIVES - highest)))
    series = (
        Series(x=DRIVES, y=up, ink=0, width=2.5, label="frequency raised: A B C E F"),
        Series(x=DRIVES, y=down, ink=1, label="frequency lowered: F E D B A"),
        middle_branch(lowest, highest),
        letters(up, down, first, last),
    )
    remember_run(DELTA, float(DRIVES[first]))
    panel = Panel(
        series=series,
        x=Axis(title="frequency W of the drive [rad/s]"),
        y=Axis(title="amplitude A [m]", ends=(0.0, 4.0)),
        size=(560, 340),
    )
    caption = (
        "alpha = 1, beta = 0.4, f0 = 1.5, delta = 0.1. Each amplitude is that of a settled run"
        " which went on from the one before. Going up it falls at C, coming down it leaps at D:"
        " which of two amplitudes it has at one frequency depends on the past."
    )
    numbers = {
        "lowest frequency with two amplitudes [rad/s]": lowest,
        "highest frequency with two amplitudes [rad/s]": highest,
    }
    return Figure(
        id="1.24",
        title="Hysteresis of the resonance",
        caption=caption,
        panels=(panel,),
        numbers=numbers,
        digits=3,
    )


def middle_branch(lowest: float, highest: float) -> Series:
    """The branch of (1.121) on which no run settles: where the frequency rises with the amplitude
    again, near the frequencies [rad/s] between which there are two amplitudes.
    """
    grid = np.linspace(0.3, 4.2, 4000)
    _, drives = balanced_drives(grid, ALPHA, BETA, DELTA, FORCE)
    is_near = (drives > lowest - 0.05) & (drives < highest + 0.12)
    branch = np.where(is_near & (np.gradient(drives) > 0), drives, np.nan)
    return Series(x=branch, y=grid, ink=GREY, dashed=True, label="never settled on (1.121)")


def letters(up: Array, down: Array, first: int, last: int) -> Series:
    """The letters A to F above the curves; `first` and `last` are the numbers of the lowest and of
    the highest frequency with two amplitudes.
    """
    # Number of the frequency, amplitude [m], and how far the letter is moved to the right.
    points = [
        (0, up[0], 0.0),
        (first, up[first], -0.03),
        (last, up[last], 0.0),
        (first, down[first], -0.03),
        (last + 1, up[last + 1], 0.02),
        (len(DRIVES) - 1, up[-1], 0.0),
    ]
    x = [DRIVES[number] + offset for number, _, offset in points]
    y = [amplitude + 0.16 for _, amplitude, _ in points]
    return Series(x=np.array(x), y=np.array(y), mark="text", ink=GREY, words=tuple("ABCDEF"))
