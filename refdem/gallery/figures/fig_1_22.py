"""Figure 1.22: phase flow of the pendulum; two heads are sheared, their areas are kept (1.112)."""

from dataclasses import replace

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.outline import Outline, carried
from refdem.gallery.portrait import arrows, heads, trajectories
from refdem.gallery.runs import observed

WIDE = (-4.0, 9.5)
HIGH = (-2.4, 3.4)


def figure() -> Figure:
    """Swinging and rotating, and two heads: one inside the separatrix, one outside."""
    series = flow()
    inside = carried(8.0, 8, flow="pendulum", centre=(1.3, 0), size=0.45)
    outside = unrolled(carried(4.5, 12, flow="pendulum", centre=(-2.6, 1.9), size=0.45))
    series += [*heads(inside, (0, 2, 4, 6, 8)), *heads(outside, (0, 4, 8, 12), ink=1)]
    panel = Panel(
        series=tuple(series),
        x=Axis(title="theta [rad]", ends=WIDE),
        y=Axis(title="theta' [rad/s]", ends=HIGH),
        size=(800, 320),
    )
    numbers = {
        "points of the two outlines": float(inside.x.shape[1] + outside.x.shape[1]),
        "area of each at the start": float(inside.area[0]),
        "largest change of the area inside": float(np.ptp(inside.area)),
        "largest change of the area outside": float(np.ptp(outside.area)),
    }
    caption = (
        "l = g = 1. One head swings, the other goes over the top. What is farther out swings"
        " slower, so that both are sheared and wound up; their areas stay what they were."
    )
    return Figure(
        id="1.22",
        title="Phase flow of the pendulum",
        caption=caption,
        panels=(panel,),
        numbers=numbers,
        digits=6,
    )


def flow() -> list[Series]:
    """Curves of swinging and of rotating pendulums in the plane of angle and rate, with arrows."""
    names = ("theta", "thetadot")
    clock = {"gravity": 1, "samples": 400}
    swings = [
        observed("pendulum", theta0=a, thetadot0=0, duration="13", **clock)
        for a in ("1/2", "1.2", "2", "2.8")
    ]
    rotations = [
        observed("pendulum", theta0="-3", thetadot0=v, duration="7", **clock)
        for v in ("1.2", "1.9", "2.6")
    ]
    series = trajectories(swings, names=names)
    for run in rotations:
        # The angle continues over the top.
        angle = np.unwrap(run["theta"])
        series.append(Series(x=angle, y=run["thetadot"], ink=GREY, width=1))
    series.append(arrows(swings, 50, (-2.5, 2.5), names=names))
    return series


def unrolled(outline: Outline) -> Outline:
    """The same with angles that continue over the top from sample to sample."""
    turns = np.unwrap(outline.x[:, 0]) - outline.x[:, 0]
    return replace(outline, x=outline.x + turns[:, None])
