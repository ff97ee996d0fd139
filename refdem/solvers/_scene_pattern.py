"""Tables of which scenes a method supports; the reason for refusing a scene is derived from the
table.
"""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from refdem.core.problem import Motion
from refdem.scene import Bodies, Element, Polyhedron, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.solvers import _single_point as single
from refdem.solvers.solver import Solver

WORDS = {1: "one", 2: "two"}


@dataclass(frozen=True)
class Count:
    """An allowed number of things: from `least` up to `most`, or unlimited if that is None."""

    least: int
    most: int | None = None

    def __contains__(self, number: int) -> bool:
        return self.least <= number and (self.most is None or number <= self.most)

    def __str__(self) -> str:
        least = WORDS.get(self.least, str(self.least))
        if self.most is None:
            return f"at least {least}"
        most = WORDS.get(self.most, str(self.most))
        if self.least == self.most:
            return most
        if self.least == 0:
            return f"at most {most}"
        return f"{least} to {most}"


ANY = Count(0)
OPTIONAL = Count(0, 1)
ONE = Count(1, 1)
TWO = Count(2, 2)
SOME = Count(1)


@dataclass(frozen=True, kw_only=True)
class ScenePattern:
    """What a scene must consist of.

    Conditions on values and positions are a solver's `unsupported_values`.
    """

    elements: Mapping[type[Element], Count] = field(default_factory=dict)
    """How many elements of each kind there may be; kinds that are not listed are refused."""
    bodies: Count = ANY
    shape: type[Sphere | Polyhedron] | None = None
    """The shape of every body; any shape if None."""
    law: str | None = None
    """The law of all contacts; any law if None."""
    may_be_fixed: bool = False
    may_spin: bool = True
    """A body may turn at the start."""
    has_inertia: bool = False
    """Every body has inertia about all of its axes."""
    only_points: bool = False
    """As far as the motion goes every body is a point: no rotation, and links at the centres."""
    in_plane: bool = False
    """The motion stays in the plane x-y."""
    irreversible: str = ""
    """Why the method runs forward in time only; empty if it runs both ways."""

    def unsupported(self, problem: Motion) -> str | None:
        """None if the scene has this pattern, else the first difference."""
        scene = problem.scene
        return (
            self._of_elements(scene)
            or self._of_bodies(scene.bodies)
            or self._of_motion(problem)
            or self._of_law(scene)
        )

    def _of_elements(self, scene: Scene) -> str | None:
        """None if kinds and numbers of elements are allowed, else the reason."""
        for element in scene.elements:
            if not isinstance(element, tuple(self.elements)):
                return f"an element of kind {element.kind}; expected {self._kinds()}"
        for kind, allowed in self.elements.items():
            number = len(scene.all(kind))
            if number not in allowed:
                return f"{number or 'no'} elements of kind {_name(kind)}; expected {allowed}"
        return None

    def _kinds(self) -> str:
        """The kinds of the elements in words."""
        if not self.elements:
            return "none"
        return "only " + ", ".join(_name(kind) for kind in self.elements)

    def _of_bodies(self, bodies: Bodies) -> str | None:
        """None if number, shape, inertia and spin of the bodies are allowed, else the reason."""
        if len(bodies) not in self.bodies:
            return f"{len(bodies)} bodies; expected {self.bodies}"
        if self.shape is not None:
            for number, shape in enumerate(bodies.shape):
                if not isinstance(shape, self.shape):
                    return f"body {number} is no {_name(self.shape)}"
        if bodies.fixed.any() and not self.may_be_fixed:
            return "a body is fixed; expected bodies that are free to move"
        if self.has_inertia and not np.all(bodies.inertia > 0):
            return "a body without inertia about one of its axes"
        if np.any(bodies.omega) and not self.may_spin:
            return "a body turns at the start"
        return None

    def _of_motion(self, problem: Motion) -> str | None:
        """None if direction of time and dimension of the motion are allowed, else the reason."""
        if self.irreversible and problem.interval < 0:
            return f"time runs backwards, but {self.irreversible}"
        if self.in_plane and "dimension:3" in problem.scene.features:
            return "the motion is not in the plane x-y"
        if self.only_points:
            return single.turning(problem.scene)
        return None

    def _of_law(self, scene: Scene) -> str | None:
        """None if every contact has the law, else the reason."""
        if self.law is None:
            return None
        for contact in scene.all(Contact):
            if contact.law != self.law:
                return f"contact law {contact.law}; expected {self.law}"
        return None


def _name(kind: Any) -> str:
    """The name of an element or of a shape in JSON."""
    return str(kind.__struct_config__.tag)


class SceneSolver(Solver):
    """A method whose scenes have a pattern."""

    pattern: ScenePattern

    def unsupported(self, problem: Motion) -> str | None:
        """None if the scene has the pattern, and its values and places fit the method."""
        return self.pattern.unsupported(problem) or self.unsupported_values(problem)

    @abstractmethod
    def unsupported_values(self, problem: Motion) -> str | None:
        """None if values and places fit the method; asked only of scenes that have the pattern."""
