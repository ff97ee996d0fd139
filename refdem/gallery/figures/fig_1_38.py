"""Figure 1.38: a collision of wedges whose force differs between approach and separation: energy is
lost without any damping.
"""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.runs import seen


def figure() -> Figure:
    """The way of the wedge in space and time, and the force over the overlap."""
    run = seen("wedge-collision", duration="3", samples=3000)
    t = run.t
    d = run["overlap"]
    v = run["v"]
    turn = int(np.argmax(d))
    m = run.instance.p.mass
    wall = Series(x=np.array([-0.6, 3.0]), y=np.zeros(2), ink=GREY, width=3)
    before = Series(x=np.array([-0.6, 0.0]), y=np.array([-0.6 * v[0], 0.0]), ink=0, width=2)
    approach = slice(0, turn + 1)
    separation = slice(turn, None)
    way = Panel(
        series=(
            wall,
            before,
            Series(x=t[approach], y=d[approach], ink=0, width=2, label="approach, edge first"),
            Series(
                x=t[separation],
                y=d[separation],
                ink=1,
                width=2,
                label="separation, flat side first",
            ),
        ),
        x=Axis(title="time [s]", ends=(-0.6, 3.0)),
        y=Axis(title="space: overlap [m]", ends=(-0.7, 0.75)),
        size=(430, 300),
    )
    # F = -m dv/dt by central differences, at all samples but the first and the last.
    force = -m * (v[2:] - v[:-2]) / (t[2:] - t[:-2])
    sample = np.arange(1, len(t) - 1)
    overlap = d[1:-1]
    inside = overlap > 1e-3
    first = inside & (sample < turn)
    last = inside & (sample > turn + 1)
    loop = Panel(
        series=(
            Series(x=overlap[first], y=force[first], ink=0, width=2),
            Series(x=overlap[last], y=force[last], ink=1, width=2),
        ),
        x=Axis(title="overlap [m]"),
        y=Axis(title="force [N]"),
        size=(330, 300),
    )
    numbers = {
        "kinetic energy before [J]": float(m * v[0] ** 2 / 2),
        "kinetic energy after [J]": float(m * v[-1] ** 2 / 2),
        "largest overlap [m]": float(d[turn]),
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
        panels=(way, loop),
        columns=2,
        numbers=numbers,
    )
