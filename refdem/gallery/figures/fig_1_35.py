"""Figure 1.35: neighbouring trajectories of a stable and of an unstable system (1.131)-(1.133)."""

import numpy as np

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.gallery.runs import Array, observed
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
    stable = [observed("pendulum", theta0=start, **clock) for start in ("1", "1.000001")]
    unstable = [
        observed("double-pendulum", theta0=(start, "5/2"), **clock) for start in ("2", "2.000001")
    ]
    t = stable[0].t
    stable_angles = [run["theta"] for run in stable]
    stable_rates = [run["thetadot"] for run in stable]
    unstable_angles = [np.unwrap(run["theta1"]) for run in unstable]
    unstable_rates = [run["thetadot1"] for run in unstable]
    stable_distance = distance(stable_angles, stable_rates)
    unstable_distance = distance(unstable_angles, unstable_rates)
    panels = (
        angles_panel("pendulum", t, stable_angles, ink=0),
        angles_panel("double pendulum", t, unstable_angles, ink=1),
        distances_panel(t, stable_distance, unstable_distance),
    )
    numbers = measured("pendulum", growth(t, stable_distance))
    numbers |= measured("double pendulum", growth(t, unstable_distance))
    caption = (
        "Each is started twice, 1e-6 rad apart. The two pendulums part as a power of the time, here"
        " in proportion to it; the two double pendulums exponentially, until they have nothing to"
        " do with one another: Lyapunov unstable."
    )
    return Figure(
        id="1.35",
        title="Stable and unstable",
        caption=caption,
        panels=panels,
        columns=2,
        numbers=numbers,
        digits=3,
    )


def distance(angles: list[Array], rates: list[Array]) -> Array:
    """The distance (T,) of two neighbours in phase space, from the angles and rates of both."""
    separation: Array = np.hypot(angles[1] - angles[0], rates[1] - rates[0])
    return separation


def angles_panel(name: str, t: Array, angles: list[Array], *, ink: int) -> Panel:
    """The angles of two neighbours over the time."""
    first = Series(x=t, y=angles[0], ink=ink, width=2.0)
    second = Series(x=t, y=angles[1], ink=ink, dashed=True, width=1.5)
    # Whole numbers: angles of a chaotic motion differ in late digits from run to run.
    ends = (float(np.floor(np.min(angles))), float(np.ceil(np.max(angles))))
    return Panel(
        series=(first, second),
        x=Axis(title="t [s]"),
        y=Axis(title="angle [rad]", ends=ends),
        title=name,
        size=(370, 220),
    )


def distances_panel(t: Array, stable: Array, unstable: Array) -> Panel:
    """The distances of both pairs of neighbours over the time."""
    series = (
        Series(x=t, y=stable, ink=0, label="pendulum"),
        Series(x=t, y=unstable, ink=1, label="double pendulum"),
    )
    return Panel(
        series=series,
        x=Axis(title="t [s]"),
        y=Axis(title="distance in phase space", ends=(1e-7, 30.0), is_log=True),
        size=(370, 220),
    )
