"""Figure 1.24: hysteresis of the nonlinear resonance: the path up and the path down."""

from typing import Any

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.sweep import ALPHA, BETA, FORCE, amplitudes, shown
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
    # The middle branch of (1.121): where the frequency rises with the amplitude again.
    grid = np.linspace(0.3, 4.2, 4000)
    _, higher = balanced_drives(grid, ALPHA, BETA, DELTA, FORCE)
    is_near = (higher > lowest - 0.05) & (higher < highest + 0.12)
    middle = np.where(is_near & (np.gradient(higher) > 0), higher, np.nan)
    first = int(np.argmin(abs(DRIVES - lowest)))
    last = int(np.argmin(abs(DRIVES - highest)))
    # The points A to F: number of the frequency, amplitude [m].
    places = [
        (0, up[0]),
        (first, up[first]),
        (last, up[last]),
        (first, down[first]),
        (last + 1, up[last + 1]),
        (len(DRIVES) - 1, up[-1]),
    ]
    aside = np.array([0.0, -0.03, 0.0, -0.03, 0.02, 0.0])
    letters = Series(
        x=DRIVES[[number for number, _ in places]] + aside,
        y=np.array([amplitude for _, amplitude in places]) + 0.16,
        mark="text",
        ink=GREY,
        words=tuple("ABCDEF"),
    )
    series = (
        Series(x=DRIVES, y=up, ink=0, width=2.5, label="frequency raised: A B C E F"),
        Series(x=DRIVES, y=down, ink=1, label="frequency lowered: F E D B A"),
        Series(x=middle, y=grid, ink=GREY, dashed=True, label="never settled on (1.121)"),
        letters,
    )
    shown(DELTA, float(DRIVES[first]))
    axes: dict[str, Any] = {
        "x": Axis(title="frequency W of the drive [rad/s]"),
        "y": Axis(title="amplitude A [m]", ends=(0.0, 4.0)),
    }
    panel = Panel(series=series, size=(560, 340), **axes)
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
    )
