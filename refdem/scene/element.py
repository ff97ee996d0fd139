"""The base classes of all elements of a scene: frozen, JSON-typed records of one force, constraint
or field each.

An element owns its mechanics: its force, its potential and its power, where its force is not
smooth, whose torque it exerts, which symmetry it breaks. What reads a scene asks the element, so
that a new one is one file in `elements/`.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any, ClassVar, get_type_hints

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Vector
from refdem.scene.dimension import Dimension, Position
from refdem.scene.singularity import Singularity

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
    reads_velocity: ClassVar[bool] = False  # its force is smooth and depends on velocities
    resists: ClassVar[bool] = False  # grows with the speed until it balances a weight
    pauses: ClassVar[bool] = False  # its force is constant, or acts only for a while
    rubs: ClassVar[bool] = False  # its force has a constant size and opposes the motion
    switches: ClassVar[bool] = False  # begins or ends to act at once
    is_kinked: ClassVar[bool] = False  # has a force that is not smooth at some place
    meaning: ClassVar[str] = ""
    """What it is, in a few words for people."""

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

    def singularity(self) -> Singularity | None:
        """Where its force is not smooth; None for one that is wherever a motion passes."""
        return None

    def torque_reason(self) -> str | None:
        """None if its torques about the origin add up to zero over all bodies, else why they do
        not.
        """
        if self.external:
            return f"the element {self.kind} exerts an external torque"
        return None

    def breaks(self, symmetry: str) -> str | None:
        """None if a scene with the element keeps a symmetry of core/symmetry.py, else why not.

        Whatever acts from outside is at rest in space.
        """
        if symmetry == "boosted" and self.external:
            return "some part of the scene is fixed in space"
        return None

    def potential(self, scene: Any, position: Array, attitude: Array) -> Array:
        """Potential energy (T,) [J] for position (T, N, 3) [m], attitude (T, N, 4); zero by
        default.
        """
        return np.zeros(len(position))

    def potential_terms(self, position: Array, attitude: Array) -> Array:
        """Sum (T,) [J] of the absolute terms of a potential whose terms may cancel, to which its
        rounding is relative; zero by default, for a potential of one term.
        """
        return np.zeros(len(position))

    def has_arbitrary_zero(self) -> bool:
        """True if the zero of its potential energy lies anywhere, as that of a weight does."""
        return False

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


class Field(Element, frozen=True, kw_only=True):
    """An element that acts on every body that is not fixed, and not between bodies."""

    def force(self, t: float, mass: float, r: Vector, v: Vector) -> Vector:
        """The force (3) [N] on a body of that mass [kg] at the time t [s], whose centre is at r (3)
        [m] with the velocity v (3) [m/s].
        """
        raise NotImplementedError


class Link(Element, frozen=True, kw_only=True):
    """An element between body `a` and body `b`, or the world (-1); anchors in body axes (world axes
    for the world) [m].
    """

    has_force: ClassVar[bool] = False  # time, places and velocities of its ends tell its force
    acts_along_line: ClassVar[bool] = False  # its force points along the line between its ends

    a: int
    b: int = -1
    anchor_a: Position = (0.0, 0.0, 0.0)
    anchor_b: Position = (0.0, 0.0, 0.0)

    def force(self, t: float, d: Vector, w: Vector) -> Vector:
        """The force (3) [N] on the end at `a` at the time t [s], the end at `b` feels the reaction.

        d (3) [m] is the vector from the end at b to that at a, w (3) [m/s] the velocity of a
        against b. Only a link that `has_force` tells it.
        """
        raise NotImplementedError

    def torque_reason(self) -> str | None:
        """None for forces along the line between two bodies, or between a body's centre and the
        origin: r x F cancels between the ends, or vanishes.
        """
        if self.b >= 0 and not self.acts_along_line:
            return (
                f"a {self.kind} also acts transverse to the line between its ends and so exerts a"
                " torque"
            )
        meets_origin = self.acts_along_line and not any((*self.anchor_a, *self.anchor_b))
        if self.b >= 0 or meets_origin:
            return None
        return super().torque_reason()

    def branch(self, places: Sequence[Vector]) -> Vector:
        """The vector d (3) [m] from the end at b to that at a, for links between centres."""
        if self.b < 0:
            return vec.minus(places[self.a], self.anchor_b)
        return vec.minus(places[self.a], places[self.b])

    def approach(self, velocities: Sequence[Vector]) -> Vector:
        """The velocity w (3) [m/s] of the centre of a against that of b, or against the world."""
        if self.b < 0:
            return velocities[self.a]
        return vec.minus(velocities[self.a], velocities[self.b])

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
