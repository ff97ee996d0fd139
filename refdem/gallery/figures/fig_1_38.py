"""Figure 1.38: a collision of wedges whose force differs between approach and separation: energy is
lost without any damping.
"""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.runs import ObservedRun, observed


def figure() -> Figure:
    """The motion of the wedge in space and time, and the force over the overlap."""
    run = observed("wedge-collision", duration="3", samples=3000)
    d = run["overlap"]
    v = run["v"]
    m = run.instance.p.mass
    deepest = int(np.argmax(d))
    numbers = {
        "kinetic energy before [J]": float(m * v[0] ** 2 / 2),
        "kinetic energy after [J]": float(m * v[-1] ** 2 / 2),
        "largest overlap [m]": float(d[deepest]),
    }
    caption = (
        "On its way in the force grows as k2 d^2, on its way out it falls as k1 d: the wedge has"
        " turned over. The two areas differ, so kinetic energy is lost though nothing depends on a"
        " velocity; the slopes of the lines on the left are the speeds."
    )
    return Figure(
        id="1.38",
        title="Wedge collision",
        caption=caption,
        panels=(motion(run, deepest), force_loop(run, deepest)),
        columns=2,
        numbers=numbers,
    )


def motion(run: ObservedRun, deepest: int) -> Panel:
    """The overlap over the time, before and after the sample at which it is largest, and the flight
    before the contact.
    """
    t = run.t
    d = run["overlap"]
    approach = slice(0, deepest + 1)
    separation = slice(deepest, None)
    wall = Series(x=np.array([-0.6, 3.0]), y=np.zeros(2), ink=GREY, width=3)
    flight = np.array([-0.6 * run["v"][0], 0.0])
    series = (
        wall,
        Series(x=np.array([-0.6, 0.0]), y=flight, ink=0, width=2),
        Series(x=t[approach], y=d[approach], ink=0, width=2, label="approach, edge first"),
        Series(
            x=t[separation],
            y=d[separation],
            ink=1,
            width=2,
            label="separation, flat side first",
        ),
    )
    return Panel(
        series=series,
        x=Axis(title="time [s]", ends=(-0.6, 3.0)),
        y=Axis(title="space: overlap [m]", ends=(-0.7, 0.75)),
        size=(430, 300),
    )


def force_loop(run: ObservedRun, deepest: int) -> Panel:
    """The force over the overlap, on the way in and on the way out."""
    t = run.t
    v = run["v"]
    # F = -m dv/dt by central differences, at all samples but the first and the last.
    force = -run.instance.p.mass * (v[2:] - v[:-2]) / (t[2:] - t[:-2])
    sample = np.arange(1, len(t) - 1)
    overlap = run["overlap"][1:-1]
    touches = overlap > 1e-3
    # The difference at the sample of the largest overlap mixes both forces: it is left out.
    approach = touches & (sample < deepest)
    separation = touches & (sample > deepest + 1)
    return Panel(
        series=(
            Series(x=overlap[approach], y=force[approach], ink=0, width=2),
            Series(x=overlap[separation], y=force[separation], ink=1, width=2),
        ),
        x=Axis(title="overlap [m]"),
        y=Axis(title="force [N]"),
        size=(330, 300),
    )
