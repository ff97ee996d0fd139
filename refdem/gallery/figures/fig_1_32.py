"""Figure 1.32: return map of the logistic map, and twice a part of it that looks like the whole
(1.127).
"""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.iterates import late, remember_run
from refdem.mechanics.dimension import box_dimension, correlation_dimension, return_map

WINDOWS = (((2.8, 4.0), (0.0, 1.0)), ((3.44, 3.63), (0.32, 0.62)), ((3.54, 3.5875), (0.455, 0.555)))
"""eta and x of the whole, of the middle branch from its second doubling on, and of the middle
branch of that.
"""
ACCUMULATION = 3.569945671870945
"""eta at which the period has doubled without end (Feigenbaum 1978)."""
PAIRED = 2**13
"""Iterates whose pairs are all counted, 34 million."""
COLUMNS = 380
"""Values of eta across the picture: one for each of its pixels, about."""


def figure() -> Figure:
    """Settled iterates; frames show where the next panel is."""
    panels = []
    for n, (etas, ends) in enumerate(WINDOWS):
        grid = np.linspace(*etas, COLUMNS)
        values = [late(float(eta), chunks=1 + n) for eta in grid]
        x = np.repeat(grid, [len(settled) for settled in values])
        y = np.concatenate(values)
        series = [Series(x=x, y=y, mark="cloud", ink=n, width=1.5)]
        if n + 1 < len(WINDOWS):
            series.append(frame(*WINDOWS[n + 1]))
        across = Axis(title="eta", ends=etas)
        # Panels in one row share the title of their axis.
        if n == 0:
            up = Axis(title="x", ends=ends)
        else:
            up = Axis(title="", ends=ends)
        panels.append(Panel(series=tuple(series), x=across, y=up, size=(255, 255)))
    remember_run("3.57")
    caption = (
        "Iterates of x -> eta x (1 - x) after 4096 others. Each panel is the part of the one before"
        " that is framed: the same forks, upside down every time, 4.67 times narrower."
    )
    chaotic = late(4.0, chunks=8)
    # The end of the doublings, where the map is a fractal, and a place where it fills [0, 1].
    settled = late(ACCUMULATION, chunks=256)
    dimension, error = box_dimension(settled, 4, 14)
    in_plane, error_in_plane = box_dimension(return_map(settled), 4, 14)
    of_pairs, error_of_pairs = correlation_dimension(settled[:PAIRED], 4, 18)
    filled, _ = box_dimension(late(4.0, chunks=256), 2, 8)
    numbers = {
        "least of 1032 iterates at eta = 4": float(chaotic.min()),
        "greatest": float(chaotic.max()),
        "box dimension at eta = 3.569945671870945 (a fractal; Grassberger 1981: 0.538)": dimension,
        "its standard error": error,
        "box dimension of the points (x, next x) there": in_plane,
        "standard error of this": error_in_plane,
        "correlation dimension there (Grassberger and Procaccia 1983: 0.500)": of_pairs,
        "standard error of that": error_of_pairs,
        "box dimension at eta = 4": filled,
    }
    return Figure(
        id="1.32",
        title="Return map of the logistic map",
        caption=caption,
        panels=tuple(panels),
        columns=3,
        numbers=numbers,
        digits=3,
    )


def frame(etas: tuple[float, float], ends: tuple[float, float]) -> Series:
    """The border of a part between these ends of eta and of x."""
    left, right = etas
    low, high = ends
    return Series(
        x=np.array([left, right, right, left, left]),
        y=np.array([low, low, high, high, low]),
        ink=GREY,
        width=1,
    )
