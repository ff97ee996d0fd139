"""Scenes: engine-neutral bodies and elements, SI units, JSON both ways."""

from refdem.scene.bodies import Bodies, Body
from refdem.scene.element import Element
from refdem.scene.scene import Scene, SceneDocument
from refdem.scene.shapes import Point, Polyhedron, Sphere, box

__all__ = [
    "Bodies",
    "Body",
    "Element",
    "Point",
    "Polyhedron",
    "Scene",
    "SceneDocument",
    "Sphere",
    "box",
]
