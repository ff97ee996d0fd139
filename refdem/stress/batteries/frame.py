"""The same scene far away, fast, rotated, later, and in other units."""

from collections.abc import Callable, Iterator

import numpy as np

from refdem.core.case import Instance
from refdem.core.symmetry import Symmetry
from refdem.core.variant import Change
from refdem.stress.measures.frame import Frame
from refdem.stress.sweep import ELASTIC_SPHERES, Battery, Sweep, scene_words

FAR = ("1", "1e2", "1e4", "1e6", "1e8", "1e10", "1e12", "1e14", "1e16")
ANGLES = ("1e-12", "1e-9", "1e-6", "1e-3", "1/10", "1", "2", "3")
LATER = ("1", "1e2", "1e4", "1e6", "1e8", "4e9")
UNITS = ("1e1", "1e2", "1e4", "1e6", "1e9", "1e12", "1e15", "1e20", "1e30")
WHERE = np.array([1.0, -0.5, 0.25])
"""Direction of shifts and boosts, along no axis of symmetry."""


def along(instance: Instance) -> np.ndarray:
    """A direction (3,) that keeps the scene's dimension: x alone, in the plane x-y, or in
    space.
    """
    features = instance.scene.features
    is_free = np.array([1.0, "dimension:1" not in features, "dimension:3" in features])
    direction: np.ndarray = WHERE * is_free
    return direction


def dyadic(x: float) -> float:
    """The power of two nearest to x: units that cause no rounding."""
    return float(2.0 ** np.round(np.log2(x)))


def turned(instance: Instance, x: float) -> Symmetry:
    """The rotation by x rad, about z for a motion in a plane."""
    if "dimension:3" in instance.scene.features:
        axis = np.array([2.0, 1.0, 2.0]) / 3
    else:
        axis = np.array([0.0, 0.0, 1.0])
    return Symmetry(turn=np.array([np.cos(x / 2), *(np.sin(x / 2) * axis)]))


def units(mass: int, length: int, time: int) -> Callable[[Instance, float], Symmetry]:
    """Changes of units by the given powers of x, in mass, length and time."""
    return lambda instance, x: Symmetry(
        units=(dyadic(x) ** mass, dyadic(x) ** length, dyadic(x) ** time)
    )


FRAMES: tuple[
    tuple[str, str, Change, tuple[str, ...], str, str, Callable[[Instance, float], Symmetry]], ...
] = (
    (
        "far away",
        "distance / L",
        "shifted",
        FAR,
        "1e8",
        "positions are rounded in proportion to their size, by u",
        lambda instance, x: Symmetry(shift=dyadic(x) * instance.scales.length * along(instance)),
    ),
    (
        "boosted",
        "speed / (L/tau)",
        "boosted",
        FAR,
        "1e8",
        "positions and velocities are rounded in proportion to their size, by u",
        lambda instance, x: Symmetry(boost=dyadic(x) * instance.scales.speed * along(instance)),
    ),
    (
        "turned",
        "angle [rad]",
        "rotated",
        ANGLES,
        "3",
        "a rotated vector is rounded in every component",
        turned,
    ),
    (
        "later",
        "start / interval of samples",
        "delayed",
        LATER,
        "1e8",
        "samples are whole numbers of intervals, exact up to 2^32",
        lambda instance, x: Symmetry(delay=dyadic(x) * instance.motion.interval),
    ),
    (
        "longer",
        "unit of length",
        "rescaled",
        UNITS,
        "1e12",
        "changing to units that are powers of two causes no rounding",
        units(0, 1, 0),
    ),
    (
        "shorter",
        "1 / unit of length",
        "rescaled",
        UNITS,
        "1e12",
        "changing to units that are powers of two causes no rounding",
        units(0, -1, 0),
    ),
    (
        "slower",
        "unit of time",
        "rescaled",
        UNITS,
        "1e12",
        "changing to units that are powers of two causes no rounding",
        units(0, 0, 1),
    ),
    (
        "heavier",
        "unit of mass",
        "rescaled",
        UNITS,
        "1e12",
        "changing to units that are powers of two causes no rounding",
        units(1, 0, 0),
    ),
)
"""Name, point in words, symmetry, points, promised point, its basis, and the transformation of a
point.
"""
RUBBING_SPHERES = "two-spheres[damping=1 friction=1/4 angle=1/2]"
CASES = {
    "far away": (
        "harmonic-oscillator",
        RUBBING_SPHERES,
        ELASTIC_SPHERES,
        "pendulum",
        "free-rigid-body",
    ),
    "boosted": (RUBBING_SPHERES, ELASTIC_SPHERES, "newtons-first-law"),
    "turned": (RUBBING_SPHERES, ELASTIC_SPHERES, "pendulum", "free-rigid-body"),
    "later": ("driven-oscillator", "pendulum"),
    "longer": ("harmonic-oscillator", RUBBING_SPHERES, ELASTIC_SPHERES, "pendulum"),
    "shorter": (RUBBING_SPHERES, "pendulum"),
    "slower": ("harmonic-oscillator", "two-body-orbit"),
    "heavier": (RUBBING_SPHERES, ELASTIC_SPHERES, "free-rigid-body"),
}
"""The cases on which each frame is tried, unless a case is named."""
EXEMPT = {
    "turned": {
        "euler-angles": (
            "1e-9",
            "Euler's angles belong to axes of space, and truncation error depends on these",
        )
    }
}
"""Methods with a lower promise for a frame, with the reason."""


def _sweeps() -> Iterator[Sweep]:
    """A sweep for every frame on every one of its cases."""
    for name, along, change, points, promised, basis, show in FRAMES:
        for case in CASES[name]:
            yield Sweep(
                name=f"{name}: {scene_words(case)}",
                case=case,
                along=along,
                points=points,
                measure=Frame(change, show),
                is_general=True,
                costly=name == "far away",
                promised=promised,
                basis=basis,
                exempt=EXEMPT.get(name, {}),
            )


BATTERY = Battery(
    id="frame",
    title="Scenes shifted, boosted, rotated, delayed and in other units",
    question=(
        "The laws of mechanics are the same there, so only round-off of larger"
        " numbers may differ. How far does that hold?"
    ),
    sweeps=tuple(_sweeps()),
)
