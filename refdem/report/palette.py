"""Colours and shapes of charts, distinct without colour vision, legible on white and black."""

from collections.abc import Iterable

from refdem.report.contents import Contents

REFERENCE = "#767676"
ENGINES = ("#0072b2", "#d55e00", "#008a64", "#b65c93", "#8c6d00", "#2a86c8", "#a0522d", "#6a5acd")
"""After Okabe and Ito (2008), darkened or lightened until each has a contrast of 3 with both
backgrounds.
"""

SHAPES = (
    "circle",
    "square",
    "triangle-up",
    "diamond",
    "cross",
    "triangle-down",
    "triangle-right",
    "triangle-left",
)


def engine_colours(contents: Contents) -> dict[str, str]:
    """A colour an engine, the same in every chart of a report; the reference is grey."""
    others = [sheet.engine for sheet in contents.engines if not sheet.is_reference]
    colours = {sheet.engine: REFERENCE for sheet in contents.engines if sheet.is_reference}
    return colours | {name: ENGINES[index % len(ENGINES)] for index, name in enumerate(others)}


def styles(pairs: Iterable[tuple[str, str]], colours: dict[str, str]) -> list[tuple[str, str, str]]:
    """(series, colour, shape) of every (engine, method): colour by engine, shape by method."""
    methods: dict[str, list[str]] = {}
    triples = []
    for engine, method in pairs:
        mine = methods.setdefault(engine, [])
        if method not in mine:
            shape = SHAPES[len(mine) % len(SHAPES)]
            mine.append(method)
            triples.append((f"{engine} {method}", colours[engine], shape))
    return triples
