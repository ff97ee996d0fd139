"""Figures 1.15 and 1.16: three oscillators that lose their energy in three ways."""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.runs import ObservedRun, observed
from refdem.mechanics.oscillation import turning_points

DURATION = 16
"""Duration [s] of the motions, several periods, in which the decay is seen."""
SAMPLES = 1600
"""Sample intervals: 100 a second, so that curves look smooth."""


def decaying(name: str, quantity: str, title: str, caption: str) -> Figure:
    """The figure `name` of the place x or the velocity v, as `quantity` says, over the time."""
    clock = {"duration": DURATION, "samples": SAMPLES}
    free = observed("harmonic-oscillator", x0=1, v0=0, **clock)
    viscous = observed("viscous-oscillator", x0=1, v0=0, delta="0.1", **clock)
    dry = observed("coulomb-oscillator", x0=1, v0=0, friction_force="0.15", **clock)
    curves = (
        Series(x=free.t, y=free[quantity], label="undamped", ink=GREY, dashed=True),
        Series(x=viscous.t, y=viscous[quantity], label="viscous, delta = 0.1", ink=0),
        Series(x=dry.t, y=dry[quantity], label="Coulomb, f = 0.15", ink=1, width=2),
    )
    unit = {"x": "x [m]", "v": "v [m/s]"}[quantity]
    panel = Panel(
        series=(*curves, *envelopes(dry, quantity)),
        x=Axis(title="t [s]", ends=(0.0, DURATION)),
        y=Axis(title=unit),
        size=(620, 300),
    )
    numbers = {}
    if quantity == "x":
        numbers = turns_and_stop(dry)
    return Figure(id=name, title=title, caption=caption, panels=(panel,), numbers=numbers, digits=6)


def envelopes(dry: ObservedRun, quantity: str) -> list[Series]:
    """The two straight lines through the extrema of x or v under dry friction, until they meet."""
    p = dry.instance.p
    w0 = float(np.sqrt(p.stiffness / p.mass))
    # Dry friction f takes 2 f/k off the amplitude in each half period pi/w0.
    slope = 2 * p.friction_force * w0 / (np.pi * p.stiffness)
    if quantity == "x":
        first = p.x0
        fall = slope
    else:
        # The largest speed, w0 (x0 - f/k), comes a quarter of a period after the start.
        largest = w0 * (p.x0 - p.friction_force / p.stiffness)
        first = largest + slope * w0 * np.pi / (2 * w0)
        fall = slope * w0
    # Where the straight line from `first` meets the axis of time.
    ends = np.array([0.0, first / fall])
    return [
        Series(x=ends, y=np.array([sign * first, 0.0]), ink=GREY, dashed=True, width=1)
        for sign in (1, -1)
    ]


def turns_and_stop(dry: ObservedRun) -> dict[str, float]:
    """Time and place at which dry friction stops the motion, and its first turning points."""
    numbers = {
        "stop of the dry one [s]": dry.trajectory.events[0].time,
        "its place there [m]": float(dry["x"][-1]),
    }
    _, places = turning_points(dry.t, dry["x"], dry["v"])
    for n, x in enumerate(places[:3], 1):
        numbers[f"turning point {n} [m]"] = float(x)
    return numbers
