"""Figure 1.31: the return map of the stick-slip oscillator over the frequency of the drive, twice
magnified (1.125).
"""

from typing import Any

import numpy as np

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.gallery.belt import section
from refdem.mechanics.dimension import box_dimension

WINDOWS = ((0.9, 2.5, 320), (1.1, 1.35, 120), (1.2, 1.24, 100))
SKIP = 80
"""Periods of the drive before the section is drawn: the start is forgotten by then."""
KEEP = 120
"""Periods of the drive whose points are drawn."""
DENSE = 2**14
"""Periods of the drive from which a dimension is counted: 256 boxes are then all visited."""
DENSE_ETA = 1.22
"""Frequency [rad/s] of the drive at which it is counted."""


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
    # One motion of each kind that never closes; the law of the second is linear in the slip.
    quasi_periodic = section(np.array([DENSE_ETA]), skip=SKIP, keep=DENSE)
    numbers["box dimension at eta = 1.22"], _ = box_dimension(quasi_periodic.places[0], 2, 8)
    chaotic = section(
        np.array([DENSE_ETA]), skip=SKIP, keep=DENSE, gamma="2", friction_law="linear"
    )
    numbers["exponent at eta = 1.22, gamma = 2, linear law [1/s]"] = float(
        chaotic.exponent.value[0]
    )
    numbers["its standard error [1/s]"] = float(chaotic.exponent.error[0])
    dimension, error = box_dimension(chaotic.places[0], 2, 8)
    numbers["box dimension there (1: no fractal)"] = dimension
    numbers["its standard error"] = error
    caption = (
        "After 80 periods of the drive, the places at which the velocity passes zero with x > 0"
        " during 120 more. Few dots above one frequency are a periodic motion, many a motion that"
        " never closes. With gamma = 0.5 windows of the one alternate with stretches of the other;"
        " magnified, the map does not repeat itself."
    )
    title = "Return map of the stick-slip oscillator"
    return Figure(id="1.31", title=title, caption=caption, panels=tuple(panels), numbers=numbers)
