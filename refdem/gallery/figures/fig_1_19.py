"""Figure 1.19: phase flow of the linear oscillator in a fluid; the area falls as exp(-2 delta
t).
"""

import numpy as np

from refdem.core.figure import Figure
from refdem.gallery.outline import carried
from refdem.gallery.portrait import arrows, heads, portrait, trajectories
from refdem.gallery.runs import observed

ENDS = (-1.45, 1.45)


def figure() -> Figure:
    """Spirals, and the head shrinking."""
    starts = ((1.3, 0), (-1.3, 0), (0, 1.3), (0, -1.3))
    runs = [
        observed("viscous-oscillator", x0=x, v0=v, delta="0.1", duration=20, samples=800)
        for x, v in starts
    ]
    outline = carried(3 * np.pi, 9, flow="viscous")
    series = [*trajectories(runs), arrows(runs, 60, ENDS), *heads(outline, (0, 2, 4, 6, 8))]
    panel = portrait(series, ENDS)
    # A(t) = A(0) exp(-2 delta t).
    area = outline.area
    expected = area[0] * np.exp(-0.2 * outline.t)
    distance = np.abs(area - expected).max()
    numbers = {
        "points of the outline": float(outline.x.shape[1]),
        "area at the start": float(area[0]),
        "area at the end": float(area[-1]),
        "largest distance from exp(-2 delta t)": float(distance),
    }
    caption = (
        "m = k = 1, delta = 0.1. The spirals end in the origin, after infinite time. The head keeps"
        " its shape, its area falls exponentially, and the density (1.111) grows in turn."
    )
    return Figure(
        id="1.19",
        title="Phase flow with viscous damping",
        caption=caption,
        panels=(panel,),
        numbers=numbers,
        digits=6,
    )
