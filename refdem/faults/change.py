"""Building blocks of faults: changes of requests, of trajectories, and of parts of the engine."""

from collections.abc import Callable
from dataclasses import replace
from itertools import cycle
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults.parts import Parts
from refdem.mechanics.vectors import ZERO
from refdem.scene import Scene
from refdem.scene.element import Element

Array = NDArray[np.float64]
Inside = Callable[[Any], dict[str, Any]]
"""The faulty parts by name, from the sound ones: Parts, or a record of some of them."""


def of_bodies(**change: Callable[[Array], Array]) -> Callable[[Request], Request]:
    """A change of a request: of columns of its bodies, each by a function of the column."""

    def before(request: Request) -> Request:
        scene = request.problem.scene
        columns: dict[str, Any] = {}
        for name, make in change.items():
            columns[name] = np.array(make(getattr(scene.bodies, name)), float)
        bodies = replace(scene.bodies, **columns)
        return request.with_scene(Scene(bodies, scene.elements))

    return before


def of_elements(
    kind: type[Element], **change: Callable[[Any], Any]
) -> Callable[[Request], Request]:
    """A change of a request: of fields of all elements of one kind, each by a function."""

    def made(element: Element) -> Element:
        if not isinstance(element, kind):
            return element
        fields = {name: make(getattr(element, name)) for name, make in change.items()}
        return msgspec.structs.replace(element, **fields)

    def before(request: Request) -> Request:
        scene = request.problem.scene
        elements = tuple(made(element) for element in scene.elements)
        return request.with_scene(Scene(scene.bodies, elements))

    return before


def of_columns(**change: Callable[[Array], Array]) -> Callable[[Request, Trajectory], Trajectory]:
    """A change of a trajectory: of columns, each by a function of the column."""

    def after(request: Request, run: Trajectory) -> Trajectory:
        changed: dict[str, Any] = {
            name: np.array(make(getattr(run, name)), float) for name, make in change.items()
        }
        return replace(run, **changed)

    return after


def digits(number: int) -> Callable[[Array], Array]:
    """Rounding to `number` significant digits, as text in the format `%.{number}g` does it."""
    return lambda values: np.vectorize(lambda value: float(f"{value:.{number}g}"))(values)


def single(values: Array) -> Array:
    """The values rounded to single precision."""
    return values.astype(np.float32).astype(float)


def scaled(factor: float) -> Callable[[Any], Any]:
    """Multiplication of a number, an array or every component of a tuple by a factor."""

    def times_factor(value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(factor * x for x in value)
        return factor * value

    return times_factor


class Late:
    """A part that returns the result of its previous call. The first call of a run returns its own
    result.
    """

    def __init__(self, sound: Callable[..., Any]) -> None:
        self.sound = sound
        self.answers: list[Any] = []
        """The result of the previous call, then that of this one."""

    def __call__(self, *arguments: Any) -> Any:
        """The result of the previous call."""
        self.answers.append(self.sound(*arguments))
        if len(self.answers) > 1:
            return self.answers.pop(0)
        return self.answers[0]


def forgetting(sound: Parts, forget: Callable[[], Any], **parts: Any) -> dict[str, Any]:
    """Faulty parts with a memory, by name; `forget` clears it at the start of every run."""

    def fresh(kept: dict[str, Any]) -> None:
        forget()
        sound.fresh(kept)

    return {"fresh": fresh, **parts}


def late(name: str) -> Inside:
    """The named part returns the result of its previous call."""

    def inside(sound: Parts) -> dict[str, Any]:
        part = Late(getattr(sound, name))
        return forgetting(sound, part.answers.clear, **{name: part})

    return inside


def of_force(kind: type[Element], change: Callable[..., Any]) -> Inside:
    """The force of one kind of element, made by `change` from the sound one."""
    return lambda sound: with_force(sound, kind, change(sound.forces[kind]))


def with_force(sound: Parts, kind: type[Element], force: Callable[..., Any]) -> dict[str, Any]:
    """The parts with another force of one kind of element."""
    return {"forces": {**sound.forces, kind: force}}


def late_force(kind: type[Element]) -> Inside:
    """The force of one kind of element is that of its previous call."""

    def inside(sound: Parts) -> dict[str, Any]:
        force = Late(sound.forces[kind])
        return forgetting(sound, force.answers.clear, **with_force(sound, kind, force))

    return inside


def every_other(name: str) -> Inside:
    """The named part, whose result is a vector, returns zero in every second call."""

    return lambda sound: {name: skipping(getattr(sound, name))}


def skipping(sound: Callable[..., Any]) -> Callable[..., Any]:
    """A function that returns the zero vector instead of its result in every second call."""
    is_sound = cycle((True, False))

    def part(*arguments: Any) -> Any:
        if next(is_sound):
            return sound(*arguments)
        return ZERO

    return part


def of_parts(**parts: Any) -> Inside:
    """Parts that are replaced by other functions or numbers."""
    return lambda sound: parts


def of_results(**change: Callable[[Any], Any]) -> Inside:
    """Parts whose results are changed."""

    def changed(part: Callable[..., Any], make: Callable[[Any], Any]) -> Callable[..., Any]:
        return lambda *arguments: make(part(*arguments))

    return lambda sound: {
        name: changed(getattr(sound, name), make) for name, make in change.items()
    }


def of_arguments(**change: Callable[..., tuple[Any, ...]]) -> Inside:
    """Parts that are called with changed arguments, which `change` computes from the right ones."""

    def changed(part: Callable[..., Any], make: Callable[..., Any]) -> Callable[..., Any]:
        return lambda *arguments: part(*make(*arguments))

    return lambda sound: {
        name: changed(getattr(sound, name), make) for name, make in change.items()
    }


def within(record: str, inside: Inside) -> Inside:
    """Changed parts within one record of parts, such as `maps` or `holding`."""

    def changed(sound: Parts) -> dict[str, Any]:
        sound_record = getattr(sound, record)
        return {record: replace(sound_record, **inside(sound_record))}

    return changed


def of_pace(pace: float, *names: str) -> Inside:
    """Parts whose last argument, the step, is multiplied by the factor `pace`."""

    def longer(part: Callable[..., Any]) -> Callable[..., Any]:
        return lambda *arguments: part(*arguments[:-1], pace * arguments[-1])

    return lambda sound: {name: longer(getattr(sound, name)) for name in names}


def rounded(value: Any) -> Any:
    """A number or a tuple of numbers, rounded to single precision."""
    if isinstance(value, tuple):
        return tuple(float(np.float32(x)) for x in value)
    return float(np.float32(value))
