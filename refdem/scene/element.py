"""The base classes of all elements of a scene: frozen, JSON-typed records of one force, constraint
or field each.
"""

from functools import cache
from typing import Any, ClassVar, get_type_hints

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.scene.dimension import Dimension, Position

Array = NDArray[np.float64]


@cache
def types_of(kind: type) -> dict[str, Any]:
    """The annotated types of a record's fields, with their dimensions (scene/dimension.py).

    Kept, because Python resolves them anew at every call.
    """
    return get_type_hints(kind, include_extras=True)


class Element(
    msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind"
):
    """One force, constraint or field. `kind` is its tag in JSON."""

    conservative: ClassVar[bool] = True
    external: ClassVar[bool] = False  # acts from outside: momentum of the bodies is not kept
    drives: ClassVar[bool] = False  # can bring energy in
    reads_clock: ClassVar[bool] = False  # what it does depends on the time

    @property
    def reversible(self) -> bool:
        """True if the motion runs back once all velocities are flipped.

        A conservative element is reversible; one for which this is not the rule overrides it.
        """
        return self.conservative

    @property
    def kind(self) -> str:
        """The element's name in JSON and in lists of features."""
        return str(self.__struct_config__.tag)

    def dimension(self, field: str) -> Dimension | None:
        """The dimension of one field, from its annotated type; None for one without, as `a`."""
        annotations = getattr(types_of(type(self))[field], "__metadata__", ())
        dimensions = (note for note in annotations if isinstance(note, Dimension))
        return next(dimensions, None)

    def features(self) -> frozenset[str]:
        """Names of what an engine must support to run a scene with this element."""
        return frozenset({self.kind})

    def faults(self) -> list[str]:
        """Sentences about values that are not physical; empty if all is well."""
        return []

    def delayed(self, delay: float) -> "Element":
        """The element for the same motion begun `delay` [s] later.

        It is the same unless the element reads the clock.
        """
        return self

    def potential(self, scene: Any, position: Array, attitude: Array) -> Array:
        """Potential energy (T,) [J] for position (T, N, 3) [m], attitude (T, N, 4); zero by
        default.
        """
        return np.zeros(len(position))

    def kinetic(self, scene: Any, velocity: Array) -> Array:
        """Kinetic energy (T,) [J] of what the element itself moves, for velocity (T, N, 3) [m/s];
        zero by default.
        """
        return np.zeros(len(velocity))

    def power(self, t: Array, position: Array, velocity: Array) -> Array | None:
        """Power (T,) [W] that the element brings into kinetic and potential energy.

        t (T,) [s], position (T, N, 3) [m] and velocity (T, N, 3) [m/s] are those of bodies that do
        not turn. Zero for what conserves energy; None where position and velocity do not tell.
        """
        if self.conservative:
            return np.zeros(len(t))
        return None


class Link(Element, frozen=True, kw_only=True):
    """An element between body `a` and body `b`, or the world (-1); anchors in body axes (world axes
    for the world) [m].
    """

    a: int
    b: int = -1
    anchor_a: Position = (0.0, 0.0, 0.0)
    anchor_b: Position = (0.0, 0.0, 0.0)

    def ends(self, position: Array, attitude: Array) -> tuple[Array, Array]:
        """Anchors of both ends in space, r + R(q) anchor, each (T, 3) [m]."""
        from refdem.mechanics.quaternion import rotated

        def end(body: int, anchor: Position) -> Array:
            """The anchor (T, 3) [m] in space; that of the world (-1) is there already."""
            if body < 0:
                return np.broadcast_to(np.asarray(anchor, float), (len(position), 3))
            if not any(anchor):
                return position[:, body]
            return position[:, body] + rotated(attitude[:, body], np.asarray(anchor, float))

        return end(self.a, self.anchor_a), end(self.b, self.anchor_b)

    def distance(self, position: Array, attitude: Array) -> Array:
        """Distance (T,) [m] between the two anchors."""
        first, second = self.ends(position, attitude)
        distance: Array = np.linalg.norm(first - second, axis=-1)
        return distance

    def has_central_anchors(self) -> bool:
        """True if the link acts on the centres of its bodies, whatever their attitudes are."""
        at_b = self.b < 0 or not any(self.anchor_b)
        return at_b and not any(self.anchor_a)

    def relative_velocity(self, velocity: Array) -> Array:
        """Velocity (T, 3) [m/s] of the centre of a against that of b, or against the world."""
        if self.b < 0:
            return velocity[:, self.a]
        relative: Array = velocity[:, self.a] - velocity[:, self.b]
        return relative
