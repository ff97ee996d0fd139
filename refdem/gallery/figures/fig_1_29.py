"""Figure 1.29: settled trajectories of the stick-slip oscillator for several frequencies of the
drive (1.125).
"""

from typing import Any

import numpy as np

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.gallery.belt import CHAOTIC, exponents, orbit

WEAK = ("0.5", "1.2", "1.25")
"""Frequencies eta [rad/s] at gamma = 0.5 and the quadratic law."""
STRONG = ("1", "1.05", "1.25")
"""Frequencies eta [rad/s] at gamma = 2 and the linear law: one periodic motion, and two chaotic."""


def figure() -> Figure:
    """Place and velocity, the beginning left out, with the largest exponents."""
    weak = {"x": Axis(ends=(-4, 4)), "y": Axis(ends=(-4, 1.4))}
    strong = {"x": Axis(ends=(-8.5, 4.5)), "y": Axis(ends=(-6, 5))}
    upper, exponents_of_weak = row(WEAK, weak, {})
    lower, exponents_of_strong = row(STRONG, strong, CHAOTIC)
    caption = (
        "a = 10, belt 1 m/s; above gamma = 0.5 and the quadratic law, which fit the chapter's axes;"
        " below gamma = 2 and the linear law. While it sticks it moves exactly as the belt: the"
        " flat top of an orbit. Sixty periods of the drive are left out, twenty shown. Above, what"
        " fills a band is not chaos: its largest exponent is 0 within its error. The chapter gives"
        " no gamma, so that its own motions may be others. The exponent is positive below at eta ="
        " 1.05 and 1.25, chaos, whose titles have it."
    )
    return Figure(
        id="1.29",
        title="Stick-slip orbits",
        caption=caption,
        panels=(*upper, *lower),
        columns=3,
        numbers={**exponents_of_weak, **exponents_of_strong},
        digits=3,
    )


def row(
    etas: tuple[str, ...], axes: dict[str, Axis], parameters: dict[str, Any]
) -> tuple[list[Panel], dict[str, float]]:
    """A panel for each frequency, and the exponents with their errors."""
    found = exponents(np.array([float(eta) for eta in etas]), **parameters)
    regimes = found.regimes()
    gamma = parameters.get("gamma", "0.5")
    panels = []
    numbers = {}
    for n, eta in enumerate(etas):
        run = orbit(eta, periods=20, **parameters)
        value = float(found.value[n])
        error = float(found.error[n])
        curve = Series(x=run["x"][1:], y=run["v"][1:], ink=n, width=1)
        title = f"eta = {eta}: {regimes[n]}"
        if regimes[n] == "chaotic":
            title = f"eta = {eta}: {value:.4f} +- {error:.4f} 1/s"
        panels.append(Panel(series=(curve,), title=title, size=(250, 180), **titled(axes, n)))
        what = f"gamma = {gamma}, eta = {eta}"
        numbers[f"{what}: exponent [1/s]"] = value
        numbers[f"{what}: its standard error [1/s]"] = error
        numbers[f"{what}: largest velocity [m/s]"] = float(run["v"][1:].max())
    return panels, numbers


def titled(axes: dict[str, Axis], column: int) -> dict[str, Any]:
    """The axes of a panel; a row shares the title of the upward one."""
    beside = ""
    if column == 0:
        beside = "v [m/s]"
    across = Axis(title="x [m]", ends=axes["x"].ends)
    return {"x": across, "y": Axis(title=beside, ends=axes["y"].ends)}
