"""A scene: bodies and elements, engine-neutral, SI, frozen, JSON both ways."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np
from msgspec import UNSET
from numpy.typing import NDArray

from refdem.errors import UNREADABLE, SceneError
from refdem.scene import bodies_file
from refdem.scene.bodies import Bodies, Body
from refdem.scene.element import Element
from refdem.scene.elements import AnyElement
from refdem.scene.features import features
from refdem.scene.shapes import Point
from refdem.scene.singularity import Singularity

Array = NDArray[np.float64]
E = TypeVar("E", bound=Element)


class SceneDocument(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A scene as JSON has it; of more than MOST_LISTED bodies it names the file that has them."""

    bodies: list[Body] | bodies_file.BodiesFile
    elements: list[AnyElement] = []


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies as columns, and the elements that act on them.

    Raises SceneError if a number is not finite, a value is unphysical, or an element names a body
    that does not exist.
    """

    bodies: Bodies
    elements: tuple[Element, ...] = ()

    def __post_init__(self) -> None:
        """Raises SceneError, with the place, for an element that is not physical."""
        for number, element in enumerate(self.elements):
            where = f"scene.elements.{number} ({element.kind})"
            for name in element.__struct_fields__:
                value = getattr(element, name)
                if value is UNSET:
                    continue
                # NumPy does not know whole numbers beyond 64 bits; they are finite.
                is_whole = isinstance(value, int)
                if not is_whole and not isinstance(value, str) and not np.all(np.isfinite(value)):
                    raise SceneError(f"{where}.{name} is {value}; expected finite numbers")
            for fault in element.faults():
                raise SceneError(f"{where}: {fault}")
            if hasattr(element, "a"):
                _refuse_ends(element, len(self.bodies), where)

    @classmethod
    def of(cls, bodies: Sequence[Body], elements: Sequence[Element] = ()) -> "Scene":
        """A scene from single bodies."""
        return cls(Bodies.of(list(bodies)), tuple(elements))

    @classmethod
    def from_json(cls, text: bytes | str, file: bytes | Path | None = None) -> "Scene":
        """The scene in a JSON text, and in its bodies' file if it names one.

        Raises SceneError with the path of the first fault.
        """
        try:
            document = msgspec.json.decode(text, type=SceneDocument)
        except UNREADABLE as error:
            raise SceneError(f"scene: {error}") from None
        return cls.of_document(document, file)

    @classmethod
    def of_document(cls, document: SceneDocument, file: bytes | Path | None = None) -> "Scene":
        """The scene of a document, and of its bodies' file; raises SceneError if that is not there
        or not what it should be.
        """
        if not isinstance(document.bodies, bodies_file.BodiesFile):
            return cls.of(document.bodies, document.elements)
        if file is None:
            raise SceneError(
                f"scene.bodies names the file {document.bodies.file}, which was not supplied with"
                " it"
            )
        return cls(bodies_file.unpacked(file, document.bodies), tuple(document.elements))

    @property
    def has_bodies_file(self) -> bool:
        """True if there are more bodies than JSON should list."""
        return len(self.bodies) > bodies_file.MOST_LISTED

    def document(self, most_listed: float = bodies_file.MOST_LISTED) -> SceneDocument:
        """The scene as JSON has it; more bodies than `most_listed` are referred to."""
        elements = list(self.elements)
        if len(self.bodies) > most_listed:
            return SceneDocument(bodies=bodies_file.reference(self.bodies), elements=elements)
        return SceneDocument(bodies=self.bodies.single(), elements=elements)

    def to_json(self) -> bytes:
        """The scene as JSON; the same bytes for the same scene."""
        return encoded(self.document())

    def all(self, kind: type[E]) -> list[E]:
        """The elements of one kind, in their order."""
        return [element for element in self.elements if isinstance(element, kind)]

    def with_state(self, **columns: Array) -> "Scene":
        """The same scene with other positions, velocities, attitudes or omegas, each (N, ...)."""
        return replace(self, bodies=self.bodies.with_state(**columns))

    @cached_property
    def features(self) -> frozenset[str]:
        """Names of what an engine must support to run the scene (scene/features.py)."""
        return features(self.bodies, self.elements)

    def is_isolated(self) -> bool:
        """No element acts from outside and no body is fixed: momentum is kept."""
        return not self.bodies.fixed.any() and not any(e.external for e in self.elements)

    def is_conservative(self) -> bool:
        """Every element has a potential or does no work."""
        return all(e.conservative for e in self.elements)

    def is_reversible(self) -> bool:
        """True if the motion runs back once all velocities are flipped."""
        return all(e.reversible for e in self.elements)

    def is_driven(self) -> bool:
        """True if some element does work on the scene."""
        return any(e.drives for e in self.elements)

    def is_kinked(self) -> bool:
        """True if the force of some element is not smooth at some place: a touch, a stop, the edge
        of a field, a root of the stretch.
        """
        return any(element.is_kinked for element in self.elements)

    def singularities(self) -> list[tuple[Element, Singularity]]:
        """Every element whose force is not smooth where a motion may pass, with its singularity."""
        pairs = ((element, element.singularity()) for element in self.elements)
        return [(element, singular) for element, singular in pairs if singular is not None]

    def potential(self, position: Array, attitude: Array) -> Array:
        """Potential energy of every element (T,) [J] for position (T, N, 3) [m] and attitude (T, N,
        4).
        """
        total: Any = sum(e.potential(self, position, attitude) for e in self.elements)
        return np.broadcast_to(np.asarray(total, float), (len(position),))

    def has_shapes(self) -> bool:
        """True if some body can touch another one or a wall."""
        return any(not isinstance(shape, Point) for shape in self.bodies.shape)


def encoded(document: Any) -> bytes:
    """JSON of a document; NumPy's numbers become plain ones."""
    return msgspec.json.encode(document, enc_hook=_plain)


def _plain(value: Any) -> Any:
    """A NumPy number as Python's; raises TypeError for anything else that JSON does not know."""
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} cannot be written as JSON")


def _refuse_ends(link: Any, count: int, where: str) -> None:
    """Raises SceneError if an element names bodies that do not exist."""
    if not 0 <= link.a < count or not -1 <= link.b < count or link.a == link.b:
        raise SceneError(
            f"{where}: joins bodies {link.a} and {link.b}; expected two different ones of"
            f" 0..{count - 1}, b may be -1 (the world)"
        )
