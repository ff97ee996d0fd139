"""Figure 1.35: neighbouring trajectories of a stable and of an unstable system (1.131)-(1.133)."""

import numpy as np

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.gallery.runs import seen
from refdem.mechanics.stability import Growth, growth


def measured(name: str, divergence: Growth) -> dict[str, float]:
    """How two neighbours part: an exponent where the growth is exponential, else the power of the
    time that it is.
    """
    if not divergence.is_exponential():
        return {f"{name}: power of the time": divergence.power}
    return {
        f"{name}: exponent [1/s]": divergence.exponent,
        f"{name}: its standard error [1/s]": divergence.error,
    }


def figure() -> Figure:
    """A pendulum and a double pendulum, each started twice, and how far the two of each are
    apart.
    """
    clock = {"duration": 16, "samples": 1600}
    stable = [seen("pendulum", theta0=start, **clock) for start in ("1", "1.000001")]
    unstable = [
        seen("double-pendulum", theta0=(start, "5/2"), **clock) for start in ("2", "2.000001")
    ]
    panels: list[Panel] = []
    numbers: dict[str, float] = {}
    pairs = {"pendulum": ([r["theta"] for r in stable], [r["thetadot"] for r in stable])}
    pairs["double pendulum"] = (
        [np.unwrap(r["theta1"]) for r in unstable],
        [r["thetadot1"] for r in unstable],
    )
    t = stable[0].t
    gaps = []
    for n, (name, (angles, rates)) in enumerate(pairs.items()):
        first = Series(x=t, y=angles[0], ink=n, width=2.0)
        second = Series(x=t, y=angles[1], ink=n, dashed=True, width=1.5)
        panels.append(
            Panel(
                series=(first, second),
                x=Axis(title="t [s]"),
                y=Axis(title="angle [rad]"),
                title=name,
                size=(370, 220),
            )
        )
        gap = np.hypot(angles[1] - angles[0], rates[1] - rates[0])
        gaps.append(Series(x=t, y=gap, ink=n, label=name))
        numbers |= measured(name, growth(t, gap))
    gap_axis = Axis(title="distance in phase space", ends=(1e-7, 30.0), is_log=True)
    panels.append(Panel(series=tuple(gaps), x=Axis(title="t [s]"), y=gap_axis, size=(370, 220)))
    caption = (
        "Each is started twice, 1e-6 rad apart. The two pendulums part as a power of the time, here"
        " in proportion to it; the two double pendulums exponentially, until they have nothing to"
        " do with one another: Lyapunov unstable."
    )
    return Figure(
        id="1.35",
        title="Stable and unstable",
        caption=caption,
        panels=tuple(panels),
        columns=2,
        numbers=numbers,
    )
