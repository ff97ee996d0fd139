"""Figure 1.29: settled trajectories of the stick-slip oscillator for several frequencies of the
drive (1.125).
"""

from typing import Any

import numpy as np

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.gallery.belt import orbit

ETAS = ("0.5", "1", "1.2", "1.25", "1.5", "2")


def figure() -> Figure:
    """Place and velocity, the beginning left out."""
    panels = []
    fastest = []
    for n, eta in enumerate(ETAS):
        run = orbit(eta, periods=20)
        curve = Series(x=run["x"][1:], y=run["v"][1:], ink=n, width=1)
        fastest.append(float(run["v"][1:].max()))
        # Titles below the last row and left of the first column.
        if n > 2:
            below = "x [m]"
        else:
            below = ""
        if n % 3 == 0:
            beside = "v [m/s]"
        else:
            beside = ""
        axes: dict[str, Any] = {
            "x": Axis(title=below, ends=(-4, 4)),
            "y": Axis(title=beside, ends=(-4, 1.4)),
        }
        panels.append(Panel(series=(curve,), title=f"eta = {eta}", size=(230, 170), **axes))
    caption = (
        "a = 10, gamma = 0.5, belt 1 m/s. While it sticks it moves exactly as the belt: the flat"
        " top of every orbit. Sixty periods of the drive are left out, twenty shown: what is one"
        " closed line is periodic, what fills a band is not."
    )
    numbers = {"largest velocity of all [m/s]": float(np.max(fastest))}
    return Figure(
        id="1.29",
        title="Stick-slip orbits",
        caption=caption,
        panels=tuple(panels),
        columns=3,
        numbers=numbers,
    )
