"""Figure 1.26: a bifurcation scenario: the period doubles again and again, until there is a
continuum of states.
"""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.iterates import doubling, late, remember_run

LOW = 2.8
"""Least eta of the diagram: below, all motions have settled to one period."""
HIGH = 3.68
"""Largest eta of the diagram: well beyond the end of the doublings at 3.57."""
BETWEEN = {1: (2.9, 3.1), 2: (3.4, 3.5), 4: (3.53, 3.55)}


def figure() -> Figure:
    """Settled iterates of the logistic map up to where chaos begins, with the doublings that were
    found.
    """
    doublings = {periods: doubling(periods, *ends) for periods, ends in BETWEEN.items()}
    etas = np.linspace(LOW, HIGH, 440)
    values = [late(float(eta)) for eta in etas]
    cloud = Series(
        x=np.repeat(etas, [len(x) for x in values]),
        y=np.concatenate(values),
        mark="cloud",
        width=1.5,
    )
    remember_run("3.5")
    panel = Panel(
        series=(cloud, *marks(doublings)),
        x=Axis(title="eta", ends=(LOW, HIGH)),
        y=Axis(title="x", ends=(0.25, 1.05)),
        size=(640, 340),
    )
    numbers = {f"{n} values become {2 * n} at": eta for n, eta in doublings.items()}
    one, two, four = doublings.values()
    numbers["length of a window over that of the next"] = (two - one) / (four - two)
    caption = (
        "The values between which a variable settles, over the strength of the nonlinearity: here"
        " the logistic map, whose fixed point splits at 3, at 1 + sqrt 6 = 3.4495, at 3.5441, and"
        " so on, up to a continuum. Marked is where the runs begin to show twice as many values."
    )
    return Figure(
        id="1.26",
        title="Bifurcation scenario",
        caption=caption,
        panels=(panel,),
        numbers=numbers,
        digits=5,
    )


def marks(doublings: dict[int, float]) -> list[Series]:
    """A dashed line at each eta at which a period, the key, doubles, and above it its words."""
    etas = list(doublings.values())
    lines = []
    for eta in etas:
        x = np.array([eta, eta])
        y = np.array([0.27, 0.97])
        lines.append(Series(x=x, y=y, ink=GREY, dashed=True, width=1))
    words = tuple(f"{n} to {2 * n}" for n in doublings)
    # The last one is higher, for it is close to the one before.
    heights = np.array([0.985, 0.985, 1.02])
    texts = Series(x=np.array(etas), y=heights, ink=GREY, mark="text", words=words)
    return [*lines, texts]
