"""Figure 1.31: the return map of the stick-slip oscillator over the frequency of the drive, twice
magnified (1.125).
"""

from typing import Any

import numpy as np

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.gallery.belt import section

WINDOWS = ((0.9, 2.5, 320), (1.1, 1.35, 120), (1.2, 1.24, 100))
SKIP = 80
"""Periods of the drive before the section is drawn: the start is forgotten by then."""
KEEP = 120
"""Periods of the drive whose points are drawn."""


def figure() -> Figure:
    """Places of the passages v = 0, x > 0 for every frequency; each panel is a part of the one
    before.
    """
    panels = []
    numbers = {}
    for n, (low, high, count) in enumerate(WINDOWS):
        eta = np.linspace(low, high, count)
        passages = section(eta, skip=SKIP, keep=KEEP)
        x = np.repeat(eta, [len(places) for places in passages.places])
        y = np.concatenate(passages.places)
        if n == 0:
            height = 300
        else:
            height = 220
        axes: dict[str, Any] = {
            "x": Axis(title="eta [rad/s]", ends=(low, high)),
            "y": Axis(title="x [m]"),
        }
        cloud = Series(x=x, y=y, mark="cloud", ink=n)
        title = f"eta from {low:g} to {high:g}"
        panels.append(Panel(series=(cloud,), size=(780, height), title=title, **axes))
        is_periodic = passages.exponent.regimes() == "periodic"
        numbers[f"periodic from {low:g} to {high:g} [parts of 1]"] = float(np.mean(is_periodic))
    caption = (
        "After 80 periods of the drive, the places at which the velocity passes zero with x > 0"
        " during 120 more. Few dots above one frequency are a periodic motion, many a motion that"
        " never closes. With gamma = 0.5 windows of the one alternate with stretches of the other;"
        " magnified, the map does not repeat itself."
    )
    title = "Return map of the stick-slip oscillator"
    return Figure(id="1.31", title=title, caption=caption, panels=tuple(panels), numbers=numbers)
