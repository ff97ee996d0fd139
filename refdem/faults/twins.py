"""Diagnosis by twins: the transparent engine with one fault or another integrator on the same scene, laid beside a code's run."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, log10

import numpy as np

from refdem.core.case import Instance
from refdem.core.engine import Engine
from refdem.core.judgement import distances
from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults.catalogue import faults
from refdem.faults.fault import Fault
from refdem.faults.settings import SETTINGS
from refdem.faults.transparent import METHODS, Transparent

NEAR = 0.03
"""A twin explains a run if what is left between them is at most this part of what was between the run and the right one."""
FINER = 4
"""Steps of the best method in one of the code's: its run is then nearer to the motion itself, with the fault or without."""
TOLD = ("euler", "verlet", "rk4")
"""Methods in which every fault is tried."""
MOST_STEPS = 600
"""Steps of the code's run that are looked at."""
TELLING = 1e-11
"""A twin without any fault that is as near as this leaves nothing to explain."""
SAME = 1e-9
"""A fault that changes a twin's distance by no more does not act on this scene."""
MOST_DIGITS = 16.0


@dataclass(frozen=True, kw_only=True)
class Twin:
    """A twin's run beside the code's: the fault it has (None: none), its method, and the largest distance in units of each scale."""

    fault: Fault | None
    method: str
    step: float
    distance: float

    @property
    def digits(self) -> float:
        """To how many digits of the scale both agree."""
        return MOST_DIGITS if self.distance == 0 else max(0.0, min(MOST_DIGITS, -log10(self.distance)))

    @property
    def behaviour(self) -> str:
        """What a code does that behaves so."""
        if self.fault is None:
            return f"{self.method} without any fault"
        return f"{self.fault.name}: {self.fault.sentence.rstrip('.')} ({self.method})"


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """All twins, nearest first, and the distance of the code's run from the right motion."""

    twins: tuple[Twin, ...]
    defect: float

    @property
    def explanation(self) -> Twin | None:
        """The nearest twin if it comes near: one without a fault where that is as near as any other."""
        nearest = self.twins[0]
        plain = next((twin for twin in self.twins if twin.fault is None and twin.distance <= 2 * nearest.distance), None)
        found = plain or nearest
        return found if found.distance <= NEAR * self.defect else None

    def _alike(self, found: Twin) -> list[str]:
        """Other faults that do the same on this scene."""
        names = [twin.fault.name for twin in self.twins if twin.fault and twin.fault is not found.fault and twin.distance <= found.distance]
        return list(dict.fromkeys(names))

    def sentence(self) -> str:
        """What the run behaves as, or that nothing comes near."""
        found = self.explanation
        if found is not None:
            alike = "".join(f" (as does {name})" for name in self._alike(found))
            return (
                f"behaves as {found.behaviour}{alike}, agrees to {found.digits:.1f} digits; the right motion is {_size(self.defect)} away"
            )
        nearest = self.twins[0]
        return (
            f"behaves as no twin: the nearest of {len(self.twins)} is {nearest.behaviour}, {_size(nearest.distance)} away, "
            f"and the right motion {_size(self.defect)}"
        )


def diagnosis(instance: Instance, request: Request, run: Trajectory) -> Diagnosis:
    """The twins of a run that answers `request`, nearest first."""
    sound = {(twin.method, twin.step): twin for twin in _twins(instance, request, run, None)}
    found = list(sound.values())
    told = min((twin.distance for twin in found), default=inf) <= TELLING
    for fault in () if told else faults():
        for twin in _twins(instance, request, run, fault):
            plain = sound.get((twin.method, twin.step))
            if plain is None or abs(twin.distance - plain.distance) > SAME * plain.distance:
                found.append(twin)
    finest = [twin.distance for twin in sound.values() if twin.step < (request.step or inf)]
    found.sort(key=lambda twin: (twin.distance, _is_foreign(twin, instance)))
    return Diagnosis(twins=tuple(found), defect=min(finest, default=inf))


def _is_foreign(twin: Twin, instance: Instance) -> bool:
    """The fault is known from other cases: of two that do the same here, the one known from this case is named first."""
    return twin.fault is not None and instance.case.id not in {SETTINGS[name].case for name in twin.fault.on}


def _twins(instance: Instance, request: Request, run: Trajectory, fault: Fault | None) -> Iterator[Twin]:
    """The fault in every method at the code's own step, and in the best method at finer ones."""
    engine: Engine = fault.carrier() if fault else Transparent()
    methods = [method.name for method in METHODS if engine.refuses(request.problem, method) is None]
    if fault is not None:
        methods = [name for name in methods if name in TOLD or name == fault.method]
    step = request.step or abs(request.problem.interval) / FINER
    fine = next((name for name in ("rk4", "verlet", "suzuki") if name in methods), None)
    asked = [(name, step) for name in methods if request.step is not None]
    for name, size in (*asked, *([(fine, step / FINER)] if fine else [])):
        twin = _run(engine, replace(request, method=name, step=size, tolerance=None))
        if twin is not None and (away := distance(instance, run, twin)) is not None:
            yield Twin(fault=fault, method=name, step=size, distance=away)


def first_part(request: Request) -> Request:
    """The request for as many samples as MOST_STEPS steps reach: enough to tell twins apart, soon enough for hundreds of them."""
    times = request.problem.times
    if request.step is None:
        return request
    count = max(3, min(len(times), MOST_STEPS // request.stride + 1))
    return request.with_scene(request.problem.scene, times[:count])


def _run(engine: Engine, request: Request) -> Trajectory | None:
    """A twin's run; None if its fault breaks it."""
    try:
        with np.errstate(all="ignore"):
            return engine.run(request)[0]
    except Exception:  # a fault may break anything; such a twin explains no run that went on to its end
        return None


def distance(instance: Instance, run: Trajectory, twin: Trajectory) -> float | None:
    """Largest difference of any state or observed quantity at any sample, in units of its scale; None if they are of other shapes."""
    if run.position.shape != twin.position.shape:
        return None
    with np.errstate(all="ignore"):
        found = float(np.max(distances(instance, run, twin)))
        first, second = instance.observe(run), instance.observe(twin)
    for name, quantity in instance.quantities.items():
        if name in first and name in second and not quantity.group and not quantity.angle:
            found = max(found, float(np.max(np.abs(first[name] - second[name]))) / quantity.scale)
    return found if np.isfinite(found) else None


def _size(distance: float) -> str:
    return f"{distance:.1e} of its scale"
