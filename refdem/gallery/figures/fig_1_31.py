"""Figure 1.31: the return map of the stick-slip oscillator over the frequency of the drive, twice
magnified (1.125).
"""

from typing import Any

import numpy as np

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.gallery.belt import CHAOTIC, section
from refdem.mechanics.dimension import box_dimension, correlation_dimension, return_map

WHOLE = (0.9, 2.5, 320)
"""Ends and number of the frequencies eta [rad/s] of the whole map."""
WINDOWS = (WHOLE, (1.1, 1.35, 120), (1.2, 1.24, 100))
SKIP = 80
"""Periods of the drive before the section is drawn: the transient has decayed by then."""
KEEP = 120
"""Periods of the drive whose points are drawn."""
DENSE = 2**16
"""Periods of the drive from which a dimension is counted: 256 boxes of a line and a curve through
512 times 512 of the plane are then visited.
"""
PAIRED = 2**13
"""Passages whose pairs are all counted, 34 million."""
DENSE_ETA = 1.22
"""Frequency [rad/s] of the drive at which it is counted."""


def figure() -> Figure:
    """Places of the passages v = 0, x > 0 for every frequency: of the weak drive, then of the
    strong one, of which each panel is a part of the one before.
    """
    weak, numbers = map_of("gamma = 0.5, quadratic law", WHOLE, 0, {})
    panels = [weak]
    for n, window in enumerate(WINDOWS):
        panel, found = map_of("gamma = 2, linear law", window, n + 1, CHAOTIC)
        panels.append(panel)
        numbers |= found
    caption = (
        "After 80 periods of the drive, the places at which the velocity passes zero with x > 0"
        " during 120 more; each panel below the second is a part of the one before. Few dots above"
        " one frequency are a periodic motion, many a motion that never closes. At gamma = 0.5 and"
        " the quadratic law, which fit the chapter's axes, no frequency has an exponent above zero"
        " by three standard errors: what fills a line there is quasi-periodic. The chapter, which"
        " calls it chaos, gives no gamma. At gamma = 2 and the linear law many exponents are"
        " positive; magnified, the map does not repeat itself. At eta = 1.22 the points of the"
        " plane that a place and the next one make lie on a curve in both motions. Pairs of places"
        " weigh the ends of the intervals, where passages crowd, more than boxes do: their"
        " dimension is below 1 and rises as distances halve, where that of a fractal would stay."
    )
    title = "Return map of the stick-slip oscillator"
    return Figure(
        id="1.31",
        title=title,
        caption=caption,
        panels=tuple(panels),
        numbers={**numbers, **dimensions(), **correlations()},
        digits=3,
    )


def map_of(
    drive: str, window: tuple[float, float, int], ink: int, parameters: dict[str, Any]
) -> tuple[Panel, dict[str, float]]:
    """The panel of a window, which parts of its frequencies are periodic and chaotic, and the
    largest exponent with its error.
    """
    low, high, count = window
    eta = np.linspace(low, high, count)
    passages = section(eta, skip=SKIP, keep=KEEP, **parameters)
    x = np.repeat(eta, [len(places) for places in passages.places])
    y = np.concatenate(passages.places)
    height = 220
    if window == WHOLE:
        height = 300
    axes: dict[str, Any] = {
        "x": Axis(title="eta [rad/s]", ends=(low, high)),
        "y": Axis(title="x [m]"),
    }
    cloud = Series(x=x, y=y, mark="cloud", ink=ink)
    title = f"{drive}: eta from {low:g} to {high:g}"
    panel = Panel(series=(cloud,), size=(780, height), title=title, **axes)
    regimes = passages.exponent.regimes()
    largest = int(np.argmax(passages.exponent.value))
    numbers = {
        f"{title}: periodic [parts of 1]": float(np.mean(regimes == "periodic")),
        f"{title}: chaotic [parts of 1]": float(np.mean(regimes == "chaotic")),
        f"{title}: largest exponent [1/s]": float(passages.exponent.value[largest]),
        f"{title}: its standard error [1/s]": float(passages.exponent.error[largest]),
    }
    return panel, numbers


def dimensions() -> dict[str, float]:
    """Box dimensions at one frequency: of a motion that is quasi-periodic, and of a chaotic one
    with its exponent.
    """
    eta = np.array([DENSE_ETA])
    quasi_periodic = section(eta, skip=SKIP, keep=DENSE)
    chaotic = section(eta, skip=SKIP, keep=DENSE, **CHAOTIC)
    of_quasi_periodic, _ = box_dimension(quasi_periodic.places[0], 2, 8)
    of_chaotic, error = box_dimension(chaotic.places[0], 2, 8)
    first_in_plane, first_error = box_dimension(return_map(quasi_periodic.places[0]), 5, 9)
    second_in_plane, second_error = box_dimension(return_map(chaotic.places[0]), 5, 9)
    return {
        "box dimension at eta = 1.22": of_quasi_periodic,
        "exponent at eta = 1.22, gamma = 2, linear law [1/s]": float(chaotic.exponent.value[0]),
        "its standard error [1/s]": float(chaotic.exponent.error[0]),
        "box dimension there (1: no fractal)": of_chaotic,
        "its standard error": error,
        "box dimension of the points (x, next x) at eta = 1.22": first_in_plane,
        "standard error of that": first_error,
        "box dimension of the points (x, next x) there (1: a curve)": second_in_plane,
        "standard error of this": second_error,
    }


def correlations() -> dict[str, float]:
    """Correlation dimensions of both motions with their errors, from large and from small distances
    of places, and from points of the plane.
    """
    eta = np.array([DENSE_ETA])
    numbers = {}
    for motion, parameters in (
        ("gamma = 0.5, quadratic law", {}),
        ("gamma = 2, linear law", CHAOTIC),
    ):
        passages = section(eta, skip=SKIP, keep=DENSE, **parameters)
        places = passages.places[0][:PAIRED]
        what = f"correlation dimension at eta = 1.22, {motion}"
        parts = {
            f"{what}, of distances from 1/8 to 1/128": correlation_dimension(places, 3, 7),
            f"{what}, from 1/128 to 1/2048": correlation_dimension(places, 7, 11),
            f"{what}, of points (x, next x)": correlation_dimension(return_map(places), 6, 11),
        }
        for name, (value, error) in parts.items():
            numbers[name] = value
            numbers[f"{name}: its standard error"] = error
    return numbers
