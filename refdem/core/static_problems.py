"""Problems without time: mass properties of solids, and programs of rotation algebra.

A `Solid` requests mass, centre of mass and tensor of inertia of a list of pieces, an `Identity`
the results of a list of operations (core/algebra.py), each of which may use earlier results.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.algebra import COUNTING_OPERANDS, SIZES
from refdem.core.problem_kinds import Problem
from refdem.errors import UsageError
from refdem.scene.shapes import Polyhedron, Sphere

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
Positive = Annotated[float, msgspec.Meta(gt=0)]


class Static(Problem):
    """A problem without time; its result is sample 0."""

    @property
    def times(self) -> Array:  # type: ignore[override]
        """The only sample (1,), at time 0."""
        return np.zeros(1)

    @property
    def interval(self) -> float:
        """The value 1.0 [s], since there is no interval between samples."""
        return 1.0

    def when(self, sample: float) -> str:
        """An empty phrase, since the problem has no time."""
        return "once"


class Cuboid(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag="cuboid",
    tag_field="kind",
    forbid_unknown_fields=True,
):
    """A box with full `sides` [m] along its axes, about its centre."""

    sides: tuple[Positive, Positive, Positive]


class Ellipsoid(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag="ellipsoid",
    tag_field="kind",
    forbid_unknown_fields=True,
):
    """An ellipsoid with these half axes [m], about its centre."""

    half_axes: tuple[Positive, Positive, Positive]


class Cylinder(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag="cylinder",
    tag_field="kind",
    forbid_unknown_fields=True,
):
    """An elliptical cylinder with half axes [m] in x and y and a `height` [m] along z, about its
    centre.
    """

    half_axes: tuple[Positive, Positive]
    height: Positive


class Polygon(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag="polygon",
    tag_field="kind",
    forbid_unknown_fields=True,
):
    """A flat plate in x-y: vertices [m], counter-clockwise, convex or not; its density is in
    kg/m^2.
    """

    vertices: tuple[tuple[float, float], ...]


class Points(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag="points",
    tag_field="kind",
    forbid_unknown_fields=True,
):
    """Masses [kg] at positions [m]; a density does not count."""

    mass: tuple[Positive, ...]
    position: tuple[Vector, ...]


SolidShape = Sphere | Polyhedron | Cuboid | Ellipsoid | Cylinder | Polygon | Points


class Piece(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A solid of uniform `density` [kg/m^3] at the origin, turned by `attitude`; `hollow` is cut
    out of it before.

    The answer has the mass, the centre of mass, and the tensor of inertia about it, or about the
    point `about` [m] in space.
    """

    name: str
    shape: SolidShape
    density: Positive = 1.0
    hollow: SolidShape | None = None
    attitude: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    about: Vector | None = None


class SolidDocument(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag="solid",
    tag_field="kind",
    forbid_unknown_fields=True,
):
    """The solids of a request, each on its own."""

    solids: list[Piece]


MASS_PROPERTIES = (
    "mass",
    *(f"centre.{x}" for x in "xyz"),
    *(f"inertia.{ij}" for ij in ("xx", "yy", "zz", "xy", "xz", "yz")),
)
"""The properties of a solid that a problem requests, in [kg], [m] and [kg m^2].

`inertia.xy` is the entry of the tensor, minus the integral of x y.
"""


@dataclass(frozen=True, eq=False)
class Solid(Static):
    """Mass properties: values `<solid>.<one of MASS_PROPERTIES>`, each (1,), except those that an
    engine does not compute.
    """

    kind: ClassVar[str] = "solid"
    words: ClassVar[str] = "mass properties"
    content: SolidDocument

    @property
    def features(self) -> frozenset[str]:
        """The features of all solids: their shapes, and hollow, turned, or about a point."""
        return frozenset(name for piece in self.content.solids for name in of_piece(piece))

    def document(self) -> SolidDocument:
        """The solids, as written to JSON."""
        return self.content

    def perturbed(self, ulps: int) -> "Solid":
        """The same solids with densities moved up by some ulps."""
        pieces = [
            msgspec.structs.replace(piece, density=piece.density * (1 + ulps * 2.0**-52))
            for piece in self.content.solids
        ]
        return Solid(SolidDocument(solids=pieces))


def of_piece(piece: Piece) -> frozenset[str]:
    """The features of one solid: its shape, and whether it is hollow, turned, or about a point."""
    names = {f"solid:{piece.shape.__struct_config__.tag}"}
    if piece.hollow:
        names.add("solid:hollow")
    if any(piece.attitude[1:]):
        names.add("solid:turned")
    if piece.about:
        names.add("solid:about")
    return frozenset(names)


def properties(
    problem: Solid, of: Callable[[Piece], Mapping[str, float] | None]
) -> dict[str, Array]:
    """The values `<solid>.<property>`, each (1,), of all solids of the problem.

    `of(piece)` returns some of MASS_PROPERTIES by name, or None if it has none of that piece.
    """
    values: dict[str, Array] = {}
    for piece in problem.content.solids:
        entries = of(piece) or {}
        for entry, value in entries.items():
            values[f"{piece.name}.{entry}"] = np.array([value])
    return values


def body(mass: float, centre: Array, inertia: Array) -> dict[str, float]:
    """All of MASS_PROPERTIES of a mass [kg], a centre (3,) [m] and a tensor (3, 3) [kg m^2]."""
    values = [float(mass), *map(float, centre)]
    for name in MASS_PROPERTIES[4:]:
        # The name ends in the two axes of the entry, as in inertia.xy.
        row = "xyz".index(name[-2])
        column = "xyz".index(name[-1])
        values.append(float(inertia[row, column]))
    return dict(zip(MASS_PROPERTIES, values, strict=True))


class Operation(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One operation of rotation algebra; an operand is numbers, or the name of an earlier
    operation, whose result it is.
    """

    name: str
    operation: str
    operands: list[list[float] | str]


class IdentityDocument(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag="identity",
    tag_field="kind",
    forbid_unknown_fields=True,
):
    """The operations of a request, in their order."""

    operations: list[Operation]


@dataclass(frozen=True, eq=False)
class Identity(Static):
    """Rotation algebra: the result of every operation by name, (1, k)."""

    kind: ClassVar[str] = "identity"
    words: ClassVar[str] = "rotation algebra"
    content: IdentityDocument

    def __post_init__(self) -> None:
        """Raises UsageError for an unknown operation, operands of wrong sizes, a name given
        twice.
        """
        result_sizes: dict[str, int] = {}
        for step in self.content.operations:
            sizes = tuple(_size(operand, result_sizes) for operand in step.operands)
            actual = (
                f"operation {step.name} ({step.operation}) has operands of sizes {sizes} (-1:"
                " unknown)"
            )
            if step.operation not in SIZES:
                known = ", ".join(SIZES)
                raise UsageError(f"{actual}; expected one of {known}, each name once")
            expected, result = SIZES[step.operation]
            if not _fit(sizes, expected) or step.name in result_sizes:
                raise UsageError(f"{actual}; expected {expected}, each name once")
            result_sizes[step.name] = result

    @property
    def features(self) -> frozenset[str]:
        """The names of the operations, each of which an engine must support."""
        return frozenset(f"identity:{step.operation}" for step in self.content.operations)

    def document(self) -> IdentityDocument:
        """The operations, as written to JSON."""
        return self.content

    def perturbed(self, ulps: int) -> "Identity":
        """The same operations with all operands moved up by some ulps, except COUNTING_OPERANDS."""
        factor = 1 + ulps * 2.0**-52

        def perturbed_step(step: Operation) -> Operation:
            """The operation with its numbers moved; references to results are not changed."""
            counting = COUNTING_OPERANDS.get(step.operation, ())
            operands: list[list[float] | str] = []
            for place, operand in enumerate(step.operands):
                if isinstance(operand, str) or place in counting:
                    operands.append(operand)
                else:
                    operands.append([x * factor for x in operand])
            return msgspec.structs.replace(step, operands=operands)

        operations = [perturbed_step(step) for step in self.content.operations]
        return Identity(IdentityDocument(operations=operations))


def _fit(sizes: tuple[int, ...], expected: tuple[int, ...]) -> bool:
    """True if operands of these sizes are as many as expected, each known and of its size."""
    if len(sizes) != len(expected):
        return False
    # 0 expects any size; a size of -1 is that of an unknown result.
    return all(
        size >= 0 and needed in (0, size) for size, needed in zip(sizes, expected, strict=True)
    )


def _size(operand: list[float] | str, result_sizes: Mapping[str, int]) -> int:
    """Count of numbers of an operand; -1 for the name of a result that is not known."""
    if isinstance(operand, str):
        return result_sizes.get(operand, -1)
    return len(operand)


def _value(operand: list[float] | str, earlier: Mapping[str, Array]) -> Array:
    """The numbers (k,) of an operand: given ones, or those of the earlier result that it names."""
    if isinstance(operand, str):
        value: Array = earlier[operand][0]
        return value
    return np.array(operand)


def results(problem: Identity, answers: Mapping[str, Callable[..., Any]]) -> dict[str, Array]:
    """The results (1, k) of the problem's operations by name, computed one after the other.

    `answers` has a function of arrays (k,) for each kind of operation that an engine supports. An
    operation is omitted if it has no function, if the function returns None, or if it uses a result
    that was omitted.
    """
    computed: dict[str, Array] = {}
    for step in problem.content.operations:
        references = [operand for operand in step.operands if isinstance(operand, str)]
        is_computable = all(name in computed for name in references)
        if step.operation in answers and is_computable:
            operands = [_value(operand, computed) for operand in step.operands]
            result = answers[step.operation](*operands)
            if result is not None:
                computed[step.name] = np.asarray(result, float).reshape(1, -1)
    return computed
