"""Changes of requests and trajectories, and parts that remember: what faults are written with."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults.parts import Parts
from refdem.scene import Scene
from refdem.scene.element import Element

Array = NDArray[np.float64]


def of_bodies(**change: Callable[[Array], Array]) -> Callable[[Request], Request]:
    """A request with columns of its bodies changed."""

    def before(request: Request) -> Request:
        scene = request.problem.scene
        changed: dict[str, Any] = {
            name: np.array(make(getattr(scene.bodies, name)), float)
            for name, make in change.items()
        }
        return request.with_scene(Scene(replace(scene.bodies, **changed), scene.elements))

    return before


def of_elements(
    kind: type[Element], **change: Callable[[Any], Any]
) -> Callable[[Request], Request]:
    """A request with fields of all elements of one kind changed."""

    def made(element: Element) -> Element:
        if not isinstance(element, kind):
            return element
        return msgspec.structs.replace(
            element, **{name: make(getattr(element, name)) for name, make in change.items()}
        )

    def before(request: Request) -> Request:
        scene = request.problem.scene
        return request.with_scene(
            Scene(scene.bodies, tuple(made(element) for element in scene.elements))
        )

    return before


def of_columns(**change: Callable[[Array], Array]) -> Callable[[Request, Trajectory], Trajectory]:
    """A trajectory with columns changed."""

    def after(request: Request, run: Trajectory) -> Trajectory:
        changed: dict[str, Any] = {
            name: np.array(make(getattr(run, name)), float) for name, make in change.items()
        }
        return replace(run, **changed)

    return after


def digits(count: int) -> Callable[[Array], Array]:
    """Numbers with so many significant digits, as a text file of `%.{count}g` keeps them."""
    return lambda values: np.vectorize(lambda value: float(f"{value:.{count}g}"))(values)


def single(values: Array) -> Array:
    """Numbers that went through single precision."""
    return values.astype(np.float32).astype(float)


def scaled(factor: float) -> Callable[[Any], Any]:
    """The value times a factor, also component by component."""
    return lambda value: (
        tuple(factor * x for x in value) if isinstance(value, tuple) else factor * value
    )


class Late:
    """A part that answers with what it should have answered the last time; the first time of a run
    it is on time.
    """

    def __init__(self, sound: Callable[..., Any]) -> None:
        self.sound = sound
        self.kept: list[Any] = []

    def __call__(self, *arguments: Any) -> Any:
        """The answer of the call before this one."""
        self.kept.append(self.sound(*arguments))
        if len(self.kept) > 1:
            return self.kept.pop(0)
        return self.kept[0]


def forgetting(p: Parts, part: Late, **parts: Any) -> dict[str, Any]:
    """Faulty parts of which one is late, with what makes it forget the run before."""

    def fresh(kept: dict[str, Any]) -> None:
        part.kept.clear()
        p.fresh(kept)

    return {"fresh": fresh, **parts}


def late(p: Parts, name: str) -> dict[str, Any]:
    """The part of that name, late."""
    part = Late(getattr(p, name))
    return forgetting(p, part, **{name: part})


def rounding(sound: Callable[..., Any]) -> Callable[..., Any]:
    """A part whose numbers go through single precision."""

    def part(*arguments: Any) -> Any:
        found = sound(*arguments)
        if isinstance(found, tuple):
            return tuple(float(np.float32(x)) for x in found)
        return float(np.float32(found))

    return part
