"""Questions without time: mass properties of solids, and programs of rotation algebra."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.algebra import SIZES
from refdem.core.problem_kinds import Problem
from refdem.errors import UsageError
from refdem.scene.shapes import Polyhedron, Sphere

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
Positive = Annotated[float, msgspec.Meta(gt=0)]


class Static(Problem):
    """A question with one answer; it is sample 0."""

    @property
    def times(self) -> Array:  # type: ignore[override]
        """The only sample (1,), at time 0."""
        return np.zeros(1)

    @property
    def interval(self) -> float:
        """There is none; one second stands for it."""
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

    Asked for are mass, centre of mass, and the tensor of inertia about it, or about the point
    `about` [m] in space.
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
"""What is asked of a solid: [kg], [m], [kg m^2];

`inertia.xy` is the entry of the tensor, minus the integral of x y.
"""


@dataclass(frozen=True, eq=False)
class Solid(Static):
    """Mass properties: values `<solid>.<one of MASS_PROPERTIES>` (1,); what an engine cannot say is
    left out.
    """

    kind: ClassVar[str] = "solid"
    words: ClassVar[str] = "mass properties"
    content: SolidDocument

    @property
    def features(self) -> frozenset[str]:
        """The shapes, and what is done with them."""
        return frozenset(name for piece in self.content.solids for name in of_piece(piece))

    def document(self) -> SolidDocument:
        """The solids, as written to JSON."""
        return self.content

    def perturbed(self, ulps: int) -> "Solid":
        """The same solids with densities moved up by some ulps."""
        moved = [
            msgspec.structs.replace(piece, density=piece.density * (1 + ulps * 2.0**-52))
            for piece in self.content.solids
        ]
        return Solid(SolidDocument(solids=moved))


def of_piece(piece: Piece) -> frozenset[str]:
    """What one solid needs: its shape, and what is done with it."""
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
    """The values of every solid of which `of` says something: some of MASS_PROPERTIES by name."""
    found = {piece.name: of(piece) for piece in problem.content.solids}
    return {
        f"{name}.{entry}": np.array([value])
        for name, entries in found.items()
        for entry, value in (entries or {}).items()
    }


def body(mass: float, centre: Array, inertia: Array) -> dict[str, float]:
    """All of MASS_PROPERTIES of a mass [kg], a centre (3,) [m] and a tensor (3, 3) [kg m^2]."""
    entries = [
        inertia["xyz".index(name[-2]), "xyz".index(name[-1])] for name in MASS_PROPERTIES[4:]
    ]
    return dict(zip(MASS_PROPERTIES, map(float, (mass, *centre, *entries)), strict=True))


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
        known: dict[str, int] = {}
        for each in self.content.operations:
            expected, result = SIZES.get(each.operation, ((), -1))
            got = tuple(_size(operand, known) for operand in each.operands)
            fits = len(got) == len(expected) and all(
                b in (0, a) and a >= 0 for a, b in zip(got, expected, strict=True)
            )
            if result < 0 or not fits or each.name in known:
                told = (
                    f"operation {each.name} ({each.operation}) has operands of sizes {got} (-1:"
                    " unknown)"
                )
                wanted = str(expected)
                if result <= 0:
                    wanted = f"one of {', '.join(SIZES)}"
                raise UsageError(f"{told}; expected {wanted}, each name once")
            known[each.name] = result

    @property
    def features(self) -> frozenset[str]:
        """The names of the operations, each of which an engine must support."""
        return frozenset(f"identity:{each.operation}" for each in self.content.operations)

    def document(self) -> IdentityDocument:
        """The operations, as written to JSON."""
        return self.content

    def perturbed(self, ulps: int) -> "Identity":
        """The same operations with every operand moved up by some ulps."""
        moved = 1 + ulps * 2.0**-52

        def shifted(each: Operation) -> Operation:
            operands: list[list[float] | str] = []
            for operand in each.operands:
                if isinstance(operand, str):
                    operands.append(operand)
                else:
                    operands.append([x * moved for x in operand])
            return msgspec.structs.replace(each, operands=operands)

        return Identity(
            IdentityDocument(operations=[shifted(each) for each in self.content.operations])
        )


def _size(operand: list[float] | str, known: Mapping[str, int]) -> int:
    """How many numbers an operand has; -1 for the name of a result that is not known."""
    if isinstance(operand, str):
        return known.get(operand, -1)
    return len(operand)


def _value(operand: list[float] | str, found: Mapping[str, Array]) -> Array:
    """The numbers (k,) of an operand: its own, or those of the result that it names."""
    if isinstance(operand, str):
        value: Array = found[operand][0]
        return value
    return np.array(operand)


def results(problem: Identity, answers: Mapping[str, Callable[..., Any]]) -> dict[str, Array]:
    """The result (1, k) of every operation that is in `answers` and whose operands are known; a
    function takes arrays (k,).
    """
    found: dict[str, Array] = {}
    for each in problem.content.operations:
        if each.operation in answers and all(
            not isinstance(x, str) or x in found for x in each.operands
        ):
            operands = [_value(operand, found) for operand in each.operands]
            found[each.name] = np.asarray(answers[each.operation](*operands), float).reshape(1, -1)
    return found
