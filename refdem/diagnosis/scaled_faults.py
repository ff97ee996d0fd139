"""Faults with an amplitude: a number misread by a factor, and every known fault made smaller or
larger.

At amplitude 0 there is no fault, and a fault of the catalogue has amplitude 1. Numbers of the
trajectory or of the result of a part are interpolated: sound + amplitude (faulty - sound).
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from refdem.core.engine import Engine
from refdem.core.problem import Request
from refdem.core.trajectory import STATE, Trajectory
from refdem.faults.change import of_pace, of_results, scaled
from refdem.faults.correct_parts import CORRECT
from refdem.faults.fault import Carrier, Fault
from refdem.faults.numbers import (
    NOT_FACTORS,
    Misreading,
    is_numeric,
    of_column,
    of_fields,
    of_radii,
)
from refdem.faults.transparent import Transparent
from refdem.scene import Scene, Sphere


@dataclass(frozen=True, kw_only=True)
class ScaledFault:
    """A fault of variable amplitude.

    `says` describes the fault at an amplitude in a sentence, and `carrier` makes the transparent
    engine with it. `fault` is the one of the catalogue that it generalises, if any.
    """

    name: str
    says: Callable[[float], str]
    carrier: Callable[[float], Engine]
    fault: Fault | None = None


def misread(scene: Scene) -> Iterator[ScaledFault]:
    """Scaled faults of every number of a scene that may be misread by a factor 1 + a, with the
    amplitude a.

    Numbers that are 0 are left out, because no factor changes them.
    """
    yield from _misread_elements(scene)
    for name in ("mass", "inertia", "velocity", "omega"):
        if np.any(getattr(scene.bodies, name)):
            yield _misread(f"body-{name}", f"{name} of the bodies", of_column(name, ...))
    if np.any(scene.bodies.inertia):
        for axis in range(3):
            column = of_column("inertia", (slice(None), axis))
            yield _misread(f"inertia-{axis + 1}", f"moment of inertia {axis + 1}", column)
    yield from _misread_masses(scene)
    if any(isinstance(shape, Sphere) for shape in scene.bodies.shapes):
        yield _misread("radius", "radius of the spheres", of_radii)


def _misread_elements(scene: Scene) -> Iterator[ScaledFault]:
    """Scaled faults of every field of an element that is a number or a tuple of numbers."""
    for number, element in enumerate(scene.elements):
        kind = element.kind.replace("_", "-")
        for name in element.__struct_fields__:
            value = getattr(element, name)
            if name not in NOT_FACTORS and is_numeric(value) and np.any(value):
                description = f"{name} of element {number} ({kind})"
                yield _misread(f"{kind}-{name}", description, of_fields(number, name))


def _misread_masses(scene: Scene) -> Iterator[ScaledFault]:
    """Scaled faults of the mass of each body in a scene of two bodies; none in other scenes."""
    if len(scene.bodies) != 2:
        return
    for body in range(2):
        yield _misread(f"mass-of-body-{body}", f"mass of body {body}", of_column("mass", body))


def _misread(name: str, description: str, misreading: Misreading) -> ScaledFault:
    """The scaled fault of one misread number, which `description` names in its sentence."""

    def carrier(amplitude: float) -> Engine:
        fault = Fault(
            name=name,
            kind="misread",
            sentence="",
            on=(),
            sees=("", ""),
            before=lambda request: misreading(request, 1.0 + amplitude),
        )
        return Carrier(Transparent(), fault)

    return ScaledFault(
        name=name,
        says=lambda amplitude: (
            f"the {description} is {1.0 + amplitude:.6g} times that of the scene"
        ),
        carrier=carrier,
    )


def paced() -> Iterator[ScaledFault]:
    """Scaled faults of the length of steps of positions, velocities or attitudes, by a factor 1 + a
    with the amplitude a.
    """
    steps = {
        "drift": ("drifted",),
        "kick": ("kicked",),
        "turn": ("axis_turn", "turn_rate"),
        "step": ("drifted", "kicked", "axis_turn", "turn_rate"),
    }
    for name, parts in steps.items():
        yield _paced(name, parts)


def _paced(name: str, parts: tuple[str, ...]) -> ScaledFault:
    """The scaled fault of one kind of step, which the parts of these names make."""

    def carrier(amplitude: float) -> Engine:
        pace = 1.0 + amplitude
        stepped = tuple(part for part in parts if part != "turn_rate")
        changed = of_pace(pace, *stepped)(CORRECT)
        if "turn_rate" in parts:
            # A rate has no step as argument, so that the rate itself is scaled.
            changed |= of_results(turn_rate=scaled(pace))(CORRECT)
        return Transparent(CORRECT.with_(**changed))

    return ScaledFault(
        name=f"{name}-length",
        says=lambda amplitude: f"every {name} is {1.0 + amplitude:.6g} times as long as requested",
        carrier=carrier,
    )


def continued(fault: Fault) -> ScaledFault | None:
    """The scaled fault that is the given fault of the catalogue at amplitude 1.

    None for a fault that changes the request; `misread` has those of variable amplitude.
    """
    if fault.before is not None:
        return None

    def carrier(amplitude: float) -> Engine:
        if fault.inside is not None:
            return Transparent(CORRECT.with_(**_mixed_parts(fault, amplitude)))
        return Carrier(Transparent(), replace(fault, after=_mixed_answer(fault, amplitude)))

    def says(amplitude: float) -> str:
        return f"{fault.sentence.rstrip('.')}, with an effect {amplitude:.6g} times as large"

    return ScaledFault(name=fault.name, says=says, carrier=carrier, fault=fault)


def _mixed_answer(fault: Fault, amplitude: float) -> Callable[[Request, Trajectory], Trajectory]:
    """A change of a trajectory that interpolates each column towards that with the fault."""
    change = fault.after
    assert change is not None

    def after(request: Request, run: Trajectory) -> Trajectory:
        faulty = change(request, run)
        columns: dict[str, Any] = {}
        for name in ("t", *STATE):
            columns[name] = _mixed(getattr(run, name), getattr(faulty, name), amplitude)
        return replace(run, **columns)

    return after


def _mixed_parts(fault: Fault, amplitude: float) -> dict[str, Any]:
    """The parts that the fault replaces, by name, each interpolated with the correct one."""
    assert fault.inside is not None
    parts = {}
    for name, faulty in fault.inside(CORRECT).items():
        # `fresh` begins a run and has no result that could be mixed.
        if name == "fresh":
            parts[name] = faulty
        else:
            parts[name] = _mixed_part(getattr(CORRECT, name), faulty, amplitude)
    return parts


def _mixed_part(sound: Any, faulty: Any, amplitude: float) -> Any:
    """The interpolation of a correct and a faulty part: a function whose results are interpolated,
    a number, or a record or mapping of such parts.
    """
    if is_dataclass(sound) and not isinstance(sound, type):
        return _field_by_field(_mixed_part, sound, faulty, amplitude)
    if sound is faulty:
        return sound
    if isinstance(sound, Mapping):
        return {key: _mixed_part(part, faulty[key], amplitude) for key, part in sound.items()}
    if not callable(sound):
        return _mixed(sound, faulty, amplitude)
    return lambda *arguments: _mixed(sound(*arguments), faulty(*arguments), amplitude)


def _field_by_field(mix: Callable[..., Any], sound: Any, faulty: Any, amplitude: float) -> Any:
    """A record of the class of `sound`, each field of which `mix` makes from those of both."""
    changed = {}
    for field in fields(sound):
        changed[field.name] = mix(
            getattr(sound, field.name), getattr(faulty, field.name), amplitude
        )
    return replace(sound, **changed)


def _mixed(sound: Any, faulty: Any, amplitude: float) -> Any:
    """sound + amplitude (faulty - sound), number by number in arrays, tuples and records.

    Anything else must be the same in both; raises TypeError where it is not.
    """
    # Tested first, because most arguments are plain floats.
    if type(sound) is float:
        return sound + amplitude * (faulty - sound)
    if isinstance(sound, np.ndarray) and sound.shape == np.shape(faulty):
        return sound + amplitude * (faulty - sound)
    if isinstance(sound, tuple | list):
        return type(sound)(_mixed(x, y, amplitude) for x, y in zip(sound, faulty, strict=True))
    if is_dataclass(sound) and not isinstance(sound, type):
        return _field_by_field(_mixed, sound, faulty, amplitude)
    if isinstance(sound, int | float | np.floating) and not isinstance(sound, bool):
        return sound + amplitude * (faulty - sound)
    if sound is faulty or sound == faulty:
        return sound
    raise TypeError(f"{type(sound).__name__} has no amplitude")
