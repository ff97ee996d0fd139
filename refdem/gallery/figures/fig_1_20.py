"""Figure 1.20: phase flow of the linear oscillator with dry friction; the head ends on a segment,
from above and from below.
"""

import numpy as np

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.gallery.outline import Outline, carried
from refdem.gallery.portrait import arrows, heads, portrait, trajectories
from refdem.gallery.runs import observed

ENDS = (-1.45, 1.45)
FRICTION = 0.15
"""The coefficient of friction of the figure: the block sticks where |x| is below it."""


def figure() -> Figure:
    """Half circles that shrink, the head on its way, and a close look at where it is deposited."""
    starts = ((1.3, 0), (-1.3, 0), (0, 1.3), (0, -1.3), (0.7, 1.1))
    runs = [observed("coulomb-oscillator", x0=x, v0=v, duration=16, samples=640) for x, v in starts]
    outline = carried(5 * np.pi, 20, flow="coulomb")
    flow = [*trajectories(runs), arrows(runs, 40, ENDS)]
    whole = portrait([*flow, *heads(outline, (0, 2, 4, 6, 8, 10)), segment()], ENDS)
    near = [*heads(outline, (9, 11, 13), ink=2), segment()]
    close = Panel(
        series=tuple(near),
        x=Axis(title="x [m]", ends=(-0.4, 0.4)),
        y=Axis(title="v [m/s]", ends=(-0.4, 0.4)),
        size=(300, 300),
        title="splitting, and coming to rest",
    )
    caption = (
        "m = k = 1, f = 0.15. Between turning points the area is kept, at each it is multiplied by"
        " (k|x| - f)/(k|x| + f), point by point; the head is split and put down on the closed"
        " segment |x| <= f/k, v = 0 (thick), part of it from above and part from below. Nothing"
        " moves along the segment."
    )
    return Figure(
        id="1.20",
        title="Phase flow with dry friction",
        caption=caption,
        panels=(whole, close),
        columns=2,
        numbers=numbers(outline),
        digits=6,
    )


def segment() -> Series:
    """The segment |x| <= f/k, v = 0, on which everything stops."""
    return Series(x=np.array([-FRICTION, FRICTION]), y=np.zeros(2), ink=1, width=4)


def numbers(outline: Outline) -> dict[str, float]:
    """Areas after each half period, and from where the points came to the segment."""
    # The velocity (M,) [m/s] of each point at the last sample before it rests.
    rest = outline.v == 0
    last = np.argmax(rest, axis=0) - 1
    points = np.arange(outline.v.shape[1])
    before = outline.v[last, points]
    area = outline.area
    farthest = np.abs(outline.x[-1]).max()
    return {
        "points of the outline": float(outline.x.shape[1]),
        "area at the start": float(area[0]),
        "area after one turning point": float(area[4]),
        "area after two": float(area[8]),
        "area at the end": float(area[-1]),
        "part of the points from above": float(np.mean(before > 0)),
        "part from below": float(np.mean(before < 0)),
        "farthest point from the origin at the end [m]": float(farthest),
    }
