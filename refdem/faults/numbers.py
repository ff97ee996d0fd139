"""The numbers of a scene and the misreading of each by a factor: mass, inertia, radius, initial
state, and every number of an element.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np

from refdem.core.problem import Request
from refdem.scene import Scene, Sphere
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.rod import Rod
from refdem.scene.shapes import Shape

NOT_FACTORS = frozenset({"a", "b", "axis", "normal"})
"""Fields of elements that name bodies or directions."""
FEW_BODIES = 3
"""Largest number of bodies whose numbers are misread one by one; those of more bodies are misread
together.
"""

Misreading = Callable[[Request, float], Request]
"""From a request and a factor, the request with a number multiplied by that factor."""


@dataclass(frozen=True, kw_only=True)
class Number:
    """A number of a scene: its name, and the function that misreads it in a request."""

    name: str
    misread: Misreading


def numbers(scene: Scene) -> Iterator[Number]:
    """Every number of a scene that may be misread by a factor, except those that are 0, which no
    factor changes.
    """
    yield from _of_elements(scene)
    yield from _of_bodies(scene)
    if scene.all(Rod):
        yield Number(name="length of the rods", misread=of_lengths)


def _of_elements(scene: Scene) -> Iterator[Number]:
    """The numbers of elements. The lengths of rods are left out: they are misread together with the
    positions that they constrain.
    """
    kinds = [element.kind for element in scene.elements]
    for place, element in enumerate(scene.elements):
        words = element.kind.replace("_", " ")
        if kinds.count(element.kind) > 1:
            words += f" {kinds[:place].count(element.kind)}"
        if isinstance(element, PiecewiseField):
            # Its force is continuous: both flanks are misread together.
            yield Number(name=f"strength of the {words}", misread=of_fields(place, "k1", "k2"))
            yield Number(name=f"edges of the {words}", misread=of_fields(place, "x1", "x2"))
            continue
        for name in element.__struct_fields__:
            value = getattr(element, name)
            if name in NOT_FACTORS or isinstance(element, Rod):
                continue
            if is_numeric(value) and np.any(value):
                title = name.replace("_", " ")
                yield Number(name=f"{title} of the {words}", misread=of_fields(place, name))


def _of_bodies(scene: Scene) -> Iterator[Number]:
    """The numbers of bodies: of each body, or of all if there are more than FEW_BODIES."""
    bodies = scene.bodies
    count = len(bodies)
    if count == 1:
        groups: list[tuple[str, Any]] = [("", 0)]
    elif count <= FEW_BODIES:
        groups = [(f" of body {body}", body) for body in range(count)]
    else:
        groups = [(" of the bodies", slice(None))]
    columns = {"mass": "mass", "velocity": "velocity", "omega": "spin"}
    if not scene.all(Rod):
        columns["position"] = "position"
    for column, title in columns.items():
        for owner, where in groups:
            if np.any(getattr(bodies, column)[where]):
                yield Number(name=title + owner, misread=of_column(column, where))
    for owner, where in groups:
        yield from _of_moments(scene, owner, where)
    if any(isinstance(shape, Sphere) for shape in bodies.shapes):
        yield Number(name="radius of the spheres", misread=of_radii)


def _of_moments(scene: Scene, owner: str, where: Any) -> Iterator[Number]:
    """The moments of inertia of the bodies at an index: all three at once where they are equal."""
    moments = np.atleast_2d(scene.bodies.inertia[where])
    if not np.any(moments):
        return
    if np.all(moments == moments[:, :1]):
        yield Number(name=f"inertia{owner}", misread=of_column("inertia", where))
        return
    for axis in range(3):
        name = f"moment of inertia {axis + 1}{owner}"
        yield Number(name=name, misread=of_column("inertia", (where, axis)))


def of_fields(number: int, *names: str) -> Misreading:
    """The misreading of some fields of element `number` of the scene."""

    def change(request: Request, factor: float) -> Request:
        scene = request.problem.scene
        elements = list(scene.elements)
        misread: dict[str, Any] = {}
        for name in names:
            value = getattr(elements[number], name)
            if isinstance(value, tuple):
                misread[name] = tuple(factor * x for x in value)
            else:
                misread[name] = factor * value
        elements[number] = msgspec.structs.replace(elements[number], **misread)
        return request.with_scene(Scene(scene.bodies, tuple(elements)))

    return change


def of_column(name: str, where: Any) -> Misreading:
    """The misreading of the column `name` of the bodies at an index `where` of NumPy."""

    def change(request: Request, factor: float) -> Request:
        scene = request.problem.scene
        column = np.array(getattr(scene.bodies, name), float)
        column[where] *= factor
        changed: dict[str, Any] = {name: column}
        bodies = replace(scene.bodies, **changed)
        return request.with_scene(Scene(bodies, scene.elements))

    return change


def of_radii(request: Request, factor: float) -> Request:
    """The request with all radii multiplied by a factor."""
    scene = request.problem.scene
    shapes: list[Shape] = []
    for shape in scene.bodies.shape:
        if isinstance(shape, Sphere):
            shapes.append(Sphere(radius=factor * shape.radius))
        else:
            shapes.append(shape)
    bodies = replace(scene.bodies, shape=tuple(shapes))
    return request.with_scene(Scene(bodies, scene.elements))


def of_lengths(request: Request, factor: float) -> Request:
    """The request with all rods multiplied by a factor, and with consistent initial states:
    positions relative to the anchor in the world, and velocities, are multiplied by it too.

    For a body without a rod to the world the first anchor is used, or the origin without any.
    """
    scene = request.problem.scene
    elements = tuple(
        msgspec.structs.replace(element, length=factor * element.length)
        if isinstance(element, Rod)
        else element
        for element in scene.elements
    )
    in_world = {rod.a: np.array(rod.anchor_b) for rod in scene.all(Rod) if rod.b < 0}
    first = next(iter(in_world.values()), np.zeros(3))
    position = np.array(scene.bodies.position, float)
    for body in range(len(position)):
        anchor = in_world.get(body, first)
        position[body] = anchor + factor * (position[body] - anchor)
    velocity = factor * np.array(scene.bodies.velocity, float)
    bodies = replace(scene.bodies, position=position, velocity=velocity)
    return request.with_scene(Scene(bodies, elements))


def is_numeric(value: Any) -> bool:
    """True of a float and of a tuple of floats."""
    return isinstance(value, float) or (
        isinstance(value, tuple) and all(isinstance(x, float) for x in value)
    )
