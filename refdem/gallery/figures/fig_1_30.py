"""Figure 1.30: trajectories of the stick-slip oscillator over the frequency of the drive, cut by
the plane v = 0 (1.125).
"""

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.belt import CHAOTIC, exponents, orbit, section
from refdem.gallery.runs import Array
from refdem.gallery.space import axis, projected

ETAS = ("0.95", "1.05", "1.15", "1.25", "1.35")
LOW = 0.95
"""Least frequency ratio eta of the surface, the first of ETAS."""
HIGH = 1.35
"""Largest frequency ratio eta of the surface, the last of ETAS."""
STRETCH = 36.0
"""Factor on eta in the picture: 0.4 of eta becomes as long as the other axes."""
MANY = np.linspace(LOW, HIGH, 121)


def figure() -> Figure:
    """Orbits side by side, their crossings of v = 0 where x > 0, and the crossings of many more
    frequencies in between.
    """
    crossings = section(MANY, skip=60, keep=40, **CHAOTIC)
    etas = np.repeat(MANY, [len(x) for x in crossings.places])
    places = np.column_stack((np.concatenate(crossings.places), etas, np.zeros(len(etas))))
    series = [drawn(places, mark="cloud", ink=GREY, width=2), *orbits(), *frame()]
    panel = Panel(
        series=tuple(series), x=Axis(is_hidden=True), y=Axis(is_hidden=True), size=(640, 420)
    )
    caption = (
        "gamma = 2 and the linear law. Settled orbits at five frequencies of the drive (lines) and"
        " where they pass v = 0 with x > 0 (dots of their colour); grey dots are such passages at"
        " 121 frequencies between: one dimension less, and figure 1.31 is all that is left to look"
        " at. The first four are chaotic, with a positive exponent; the last one is periodic."
    )
    return Figure(
        id="1.30",
        title="Poincare section of the stick-slip oscillator",
        caption=caption,
        panels=(panel,),
        numbers={**counted(crossings), **exponents_shown()},
        digits=4,
    )


def orbits() -> list[Series]:
    """The orbits at ETAS as curves, and their crossings of v = 0 as points."""
    series = []
    for n, eta in enumerate(ETAS):
        run = orbit(eta, periods=6, **CHAOTIC)
        # The first sample stands for the periods that were left out.
        x = run["x"][1:]
        v = run["v"][1:]
        points = np.column_stack((x, np.full(len(x), float(eta)), v))
        series.append(drawn(points, ink=n, label=f"eta = {eta}"))
    for n, eta in enumerate(ETAS):
        x = section(np.array([float(eta)]), skip=60, keep=6, **CHAOTIC).places[0]
        points = np.column_stack((x, np.full(len(x), float(eta)), np.zeros(len(x))))
        series.append(drawn(points, mark="points", ink=n))
    return series


def frame() -> list[Series]:
    """The three axes x, eta and v along edges of the box that is drawn, with their names."""
    edges = [
        ((-8, LOW, -6), (4, LOW, -6), "x [m]"),
        ((4, LOW, -6), (4, HIGH, -6), "eta"),
        ((-8, LOW, -6), (-8, LOW, 5), "v"),
    ]
    series: list[Series] = []
    for begin, end, name in edges:
        first, last = stretched(np.array([begin, end]))
        series += axis(first, last, name)
    return series


def counted(crossings: object) -> dict[str, float]:
    """How many passages were drawn, and the largest place."""
    places = np.concatenate(crossings.places)  # type: ignore[attr-defined]
    return {"passages": float(len(places)), "farthest passage [m]": float(places.max())}


def exponents_shown() -> dict[str, float]:
    """The largest exponents at ETAS with their errors [1/s]."""
    found = exponents(np.array([float(eta) for eta in ETAS]), **CHAOTIC)
    numbers = {}
    for eta, value, error in zip(ETAS, found.value, found.error, strict=True):
        numbers[f"eta = {eta}: exponent [1/s]"] = float(value)
        numbers[f"eta = {eta}: its standard error [1/s]"] = float(error)
    return numbers


def stretched(points: Array) -> Array:
    """x, eta, v with the frequencies drawn apart."""
    return points * [1.0, STRETCH, 1.0] - [0.0, STRETCH * LOW, 0.0]


def drawn(points: Array, **style: object) -> Series:
    """A curve, or dots, through points (N, 3) of x, eta and v, as they are seen from above."""
    right, up, _ = projected(stretched(points))
    return Series(x=right, y=up, **style)  # type: ignore[arg-type]
