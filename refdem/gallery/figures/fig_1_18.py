"""Figure 1.18: phase flow of the linear oscillator without damping; the area of the head is kept
(Liouville).
"""

import numpy as np

from refdem.core.figure import Figure
from refdem.gallery.outline import carried
from refdem.gallery.portrait import arrows, heads, portrait, trajectories
from refdem.gallery.runs import observed

ENDS = (-1.45, 1.45)


def figure() -> Figure:
    """Circles, and the head after every fifth of a period."""
    clock = {"duration": repr(2 * np.pi), "samples": 240}
    starts = ("1/4", "1/2", "3/4", "1", "5/4")
    runs = [observed("harmonic-oscillator", x0=x, v0=0, **clock) for x in starts]
    outline = carried(2 * np.pi, 10, flow="harmonic")
    series = [*trajectories(runs), arrows(runs, 30, ENDS), *heads(outline, (0, 2, 4, 6, 8))]
    panel = portrait(series, ENDS)
    numbers = {
        "points of the outline": float(outline.x.shape[1]),
        "area at the start": float(outline.area[0]),
        "largest change of the area": float(np.ptp(outline.area)),
    }
    caption = (
        "m = k = 1. The flow turns the cat's head (of our own drawing) about the origin, clockwise,"
        " once a period; neither its shape nor its area changes: Liouville's theorem."
    )
    return Figure(
        id="1.18",
        title="Phase flow without damping",
        caption=caption,
        panels=(panel,),
        numbers=numbers,
        digits=6,
    )
