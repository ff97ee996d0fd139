"""The truth of a billiard table, whichever its geometry."""

from collections.abc import Mapping
from fractions import Fraction

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.exact import vector
from refdem.truth.maps.rectangle import Rectangle
from refdem.truth.maps.stadium import Stadium
from refdem.truth.refiner import Size


def truth(p: Parameters, scale: Mapping[str, Size]) -> Truth:
    """Unfolding or the collision map, selected by `geometry`."""
    kind: type[Stadium | Rectangle] = Rectangle
    if p["geometry"] == "stadium":
        kind = Stadium
    return kind(_pair(p, "size"), _pair(p, "start"), _pair(p, "direction"), scale)


def _pair(p: Parameters, name: str) -> tuple[Fraction, Fraction]:
    first, second = vector(p, name)
    return first, second
