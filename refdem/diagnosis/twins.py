"""Diagnosis by twins: runs of the transparent engine, with one fault or another integrator, on the
same scene are compared with the run of a code.

The amplitude of a fault of variable size is fitted. A fault is named only if its twin agrees with
the run to three digits, is a thousand times nearer to it than the same twin without the fault, and,
if there is a run of the code at another step, agrees with that one at the same amplitude. The
thresholds are higher for an amplitude that is not a simple number, because one free parameter can
fit three digits of many runs. All faults that explain a run equally well are named.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, isfinite, log10
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.engine import Engine
from refdem.core.judgement import distances
from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.diagnosis import amplitude_fit
from refdem.diagnosis.effective_faults import acts, recording_parts
from refdem.diagnosis.scaled_faults import ScaledFault, continued, misread, paced
from refdem.faults.catalogue import faults
from refdem.faults.fault import Carrier, Fault
from refdem.faults.settings import SETTINGS
from refdem.faults.transparent import METHODS, Transparent

Array = NDArray[np.float64]

LEAST_DIGITS = 3.0
"""Least number of digits of the scale to which a twin must agree."""
MAX_RESIDUAL = 1e-3
"""Largest part of the defect of the twin without fault that a fault may leave unexplained."""
UNUSUAL_DIGITS = 6.0
"""The same as LEAST_DIGITS, for a fitted amplitude that is not a simple number."""
UNUSUAL_RESIDUAL = 1e-5
"""The same as MAX_RESIDUAL, for a fitted amplitude that is not a simple number."""
SIMPLE_FACTORS: tuple[float, ...] = (-1.0, 0.5, 2.0, 4.0, 0.25, 10.0, 0.1, 1e3, 1e-3)
"""Plausible factors of misread numbers: a sign, a half, a unit."""
SIMPLE_AMPLITUDES: tuple[float, ...] = (1.0, -1.0, 0.5, 2.0)
"""Plausible amplitudes of known faults: 1, reversed, half, and twice."""
SIMPLE = 1e-3
"""Largest relative difference of a fitted amplitude from a simple number."""
SECONDS = 120.0
"""Run time [s] of a search for twins, after which it ends with what was tried; small scenes take
10 s.
"""
MAX_EQUALS = 5
"""Largest number of equally good explanations that are named."""
FINER = 4
"""Number of steps of the best method in one step of the code, so that its discretisation error is
small.
"""
USUAL_METHODS = ("euler", "verlet", "rk4")
"""Methods in which every fault is tried."""
MOST_STEPS = 600
"""Largest number of steps of the code's run that are compared."""
EXPLAINED = 1e-11
"""Distance of a twin without fault below which no fault is searched."""
CORRECT = 1e-9
"""Largest distance from a twin without fault that the order of floating-point sums can explain."""
ALIKE = 10.0
"""Ratio of distances below which two twins explain a run equally well."""
FLOOR = 1e-12
"""Distance below which all twins explain a run equally well up to round-off."""
NO_EFFECT = 1e-9
"""Relative change of a twin's distance below which a fault does not act on the scene."""
MAX_DISTANCE_RATIO = 10.0
"""A method is rejected if its twin without fault is more than this times as far as the nearest one.
"""
MAX_EARLY_RESIDUAL = 0.3
"""Largest part of the defect in the first window that a known fault may leave to be run to the end.
"""
MAX_FULL_RUNS = 12
"""Largest number of known faults, the nearest ones, that are run to the end."""
MOST_DIGITS = 16.0
"""Digits of a twin that agrees exactly: those of binary64."""


@dataclass(frozen=True, kw_only=True)
class Twin:
    """A twin's run compared with the code's: its fault, its method and the largest distance.

    A twin without a fault and without a scaled fault is correct. `distance` is in units of each
    scale, and `beside` is the distance of the twin of the same method and step without the fault.
    """

    method: str
    step: float
    distance: float
    fault: Fault | None = None
    scaled: ScaledFault | None = None
    amplitude: float = 1.0
    beside: float = inf

    @property
    def digits(self) -> float:
        """The number of decimal digits of the scale to which both agree."""
        if self.distance == 0:
            return MOST_DIGITS
        return max(0.0, min(MOST_DIGITS, -log10(self.distance)))

    @property
    def name(self) -> str:
        """The name of the fault; empty for a correct twin."""
        if self.scaled is not None:
            return self.scaled.name
        if self.fault:
            return self.fault.name
        return ""

    @property
    def behaviour(self) -> str:
        """A description of the twin's fault and method."""
        if self.scaled is not None:
            return f"{self.scaled.name}: {self.scaled.says(self.amplitude)} ({self.method})"
        if self.fault is None:
            return f"{self.method} without a fault"
        return f"{self.fault.name}: {self.fault.sentence.rstrip('.')} ({self.method})"

    @property
    def explains_run(self) -> bool:
        """True if the twin explains the run: `digits` is large enough, and the distance is a small
        enough part of that of the same twin without the fault.
        """
        if self.has_unusual_amplitude:
            digits = UNUSUAL_DIGITS
            left = UNUSUAL_RESIDUAL
        else:
            digits = LEAST_DIGITS
            left = MAX_RESIDUAL
        is_near = self.digits >= digits
        if not self.name:
            return is_near and self.distance <= CORRECT
        return is_near and isfinite(self.beside) and self.distance <= left * self.beside

    @property
    def has_unusual_amplitude(self) -> bool:
        """True of a fitted amplitude that is no simple number."""
        if self.scaled is None:
            return False
        if self.fault is None:
            # A number that is misread is multiplied by 1 + amplitude.
            number = 1.0 + self.amplitude
            simple = SIMPLE_FACTORS
        else:
            number = self.amplitude
            simple = SIMPLE_AMPLITUDES
        return all(abs(number - value) > SIMPLE * abs(value) for value in simple)


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """All twins that were run to the end, nearest first, and the distance `defect` of the code's
    run from the right motion.

    `refuted` are the names of faults that explain this run but not the code's run at another step.
    `seconds` [s] is the run time after which the search ended, 0 if all faults were tried.
    """

    twins: tuple[Twin, ...]
    defect: float
    refuted: frozenset[str] = field(default=frozenset())
    seconds: float = 0.0

    @property
    def _explaining(self) -> list[Twin]:
        """Twins that explain the run, nearest first."""
        return [twin for twin in self.twins if twin.explains_run and twin.name not in self.refuted]

    @property
    def explanation(self) -> Twin | None:
        """The twin that explains the run, the simplest one of equally good ones; None without."""
        explaining = self._explaining
        if not explaining:
            return None
        nearest = explaining[0]
        alike = [twin for twin in explaining if _is_alike(twin, nearest)]
        return min(alike, key=_complexity)

    @property
    def alike(self) -> tuple[str, ...]:
        """The names of other faults that explain the run equally well."""
        explanation = self.explanation
        if explanation is None or not explanation.name:
            return ()
        names = [
            twin.name
            for twin in self._explaining
            if _is_alike(twin, self._explaining[0]) and twin.name != explanation.name
        ]
        return tuple(dict.fromkeys(name for name in names if name))

    def sentence(self) -> str:
        """What the run behaves as, or which twin is nearest and that it is no diagnosis."""
        if not self.twins:
            return "cannot be diagnosed: the engine with known faults does not support this scene"
        if np.isfinite(self.defect):
            ending = f"; the error of the run is {_size(self.defect)}"
        else:
            ending = ""
        if self.seconds:
            ending += (
                f"; the search stopped at its time limit of {self.seconds:g} s before all known"
                " faults were tried; raise it with --seconds"
            )
        explanation = self.explanation
        if explanation is not None:
            agreement = f"agrees to {explanation.digits:.1f} digits"
            return f"behaves as {explanation.behaviour}, {agreement}{self._equals()}{ending}"
        nearest = self.twins[0]
        return (
            "no known fault reproduces this run (not a diagnosis); the nearest is"
            f" {nearest.behaviour}, which agrees to {nearest.digits:.1f} digits, a difference of"
            f" {_size(nearest.distance)}{ending}"
        )

    def _equals(self) -> str:
        """The clause that names other faults which explain the run as well; empty without any."""
        names = self.alike
        if not names:
            return ""
        named = ", ".join(names[:MAX_EQUALS])
        if len(names) > MAX_EQUALS:
            named += f" and {len(names) - MAX_EQUALS} more"
        return f"; {named} reproduce the run equally well: it cannot distinguish them"


def _complexity(twin: Twin) -> int:
    """The rank of an explanation among equals: nothing wrong, a known fault as it is, a number
    misread by a factor, a known fault of another size.
    """
    if not twin.name:
        return 0
    if twin.scaled is None:
        return 1
    if twin.fault is None:
        return 2
    return 3


def _is_alike(twin: Twin, nearest: Twin) -> bool:
    """True if a twin explains the run as well as the nearest one: its distance is at most ALIKE
    times as large, or round-off.
    """
    return twin.distance <= max(ALIKE * nearest.distance, FLOOR)


def diagnosis(
    instance: Instance,
    request: Request,
    run: Trajectory,
    other: tuple[Request, Trajectory] | None = None,
    seconds: float = SECONDS,
) -> Diagnosis:
    """The twins of a run that answers `request`, nearest first.

    `other` is a run of the code at another step, to confirm the diagnosis. The search ends after
    `seconds` [s] of run time with the twins that were tried until then.
    """
    beside = TwinComparison(instance, request, run, seconds)
    sound = beside.sound
    if not sound:
        return Diagnosis(twins=(), defect=inf)
    twins = list(sound.values())
    if min(twin.distance for twin in twins) > EXPLAINED:
        twins += beside.faulty()
    finest = [twin.distance for twin in sound.values() if twin.step < (request.step or inf)]
    twins.sort(key=lambda twin: (twin.distance, _is_from_other_cases(twin, instance)))
    refuted = _refuted(instance, [twin for twin in twins if twin.name and twin.explains_run], other)
    if beside.is_cut_short:
        ended_after = seconds
    else:
        ended_after = 0.0
    defect = min(finest, default=inf)
    return Diagnosis(twins=tuple(twins), defect=defect, refuted=refuted, seconds=ended_after)


def _refuted(
    instance: Instance, twins: list[Twin], other: tuple[Request, Trajectory] | None
) -> frozenset[str]:
    """Names of faults that explain a run but, with the same amplitude, not the code's run at
    another step.
    """
    if other is None or not twins:
        return frozenset()
    elsewhere = TwinComparison(instance, *other)
    # A method without steps can be compared at any step, here 1.0.
    other_step = other[0].step
    if other_step is None:
        other_step = 1.0
    ratio = other_step / twins[0].step
    explained: dict[str, bool] = {}
    for twin in twins:
        # A twin at the code's step is compared at the step of the other run, and one at the finer
        # step at the step of the other run over FINER.
        if twin.step == twins[0].step:
            step = twin.step * ratio
        else:
            step = other_step / FINER
        # One twin of a name that explains both runs is enough.
        again = elsewhere.twin(twin, step)
        if again is not None and again.explains_run:
            explained[twin.name] = True
        else:
            explained.setdefault(twin.name, False)
    return frozenset(name for name, is_explained in explained.items() if not is_explained)


def _is_from_other_cases(twin: Twin, instance: Instance) -> bool:
    """True if the fault is known from other cases only. Of two equal explanations the fault known
    from this case is named first.
    """
    return twin.fault is not None and instance.case.id not in {
        SETTINGS[name].case for name in twin.fault.on
    }


class TwinComparison:
    """A run of a code, and the twins that are compared with it."""

    def __init__(
        self, instance: Instance, request: Request, run: Trajectory, seconds: float = SECONDS
    ) -> None:
        self.begun = monotonic()
        self.seconds = seconds
        self.is_cut_short = False
        """True if the search ended before all faults were tried."""
        self.instance = instance
        self.request = request
        self.run = run
        self.step = request.step or abs(request.problem.interval) / FINER
        self.like = amplitude_fit.states(instance, run, run)
        self.answers: dict[tuple[str, float | None, int], Trajectory] = {}
        self.called: dict[str, set[str]] = {}
        """Names of the parts of the engine that each method calls."""
        self.plain: dict[tuple[str, float, int], Array | None] = {}

    @cached_property
    def sound(self) -> dict[tuple[str, float], Twin]:
        """Twins without fault by method and step: every method at the code's own step, the best one
        at a finer step.
        """
        engine = Transparent()
        supported_methods = [
            method.name
            for method in METHODS
            if engine.unsupported(self.request.problem, method) is None
        ]
        candidates = [
            (name, self.step) for name in supported_methods if self.request.step is not None
        ]
        best = next(
            (name for name in ("rk4", "verlet", "suzuki") if name in supported_methods), None
        )
        if best is not None:
            candidates.append((best, self.step / FINER))
        twins = {}
        for method, step in candidates:
            called = self.called.setdefault(method, set())
            distance = self.distance(self.ran(Transparent(recording_parts(called)), method, step))
            if distance is not None:
                twins[method, step] = Twin(method=method, step=step, distance=distance)
        return twins

    def ran(
        self, engine: Engine, method: str, step: float, samples: int | None = None
    ) -> Trajectory | None:
        """A twin's run over the first `samples` (None: all); None if its fault makes it fail."""
        motion = self.request.problem
        request = replace(self.request, method=method, step=step, tolerance=None).with_scene(
            motion.scene, motion.times[:samples]
        )
        try:
            with np.errstate(all="ignore"):
                if isinstance(engine, Carrier) and engine.fault.after is not None:
                    return engine.fault.after(request, self._answer(request))
                return engine.run(request)[0]
        except (
            Exception
        ):  # a fault may break anything; such a twin explains no run that went on to its end
            return None

    def _answer(self, request: Request) -> Trajectory:
        """The run of the twin without fault, cached for all faults that change the answer alone."""
        key = (request.method, request.step, len(request.problem.times))
        if key not in self.answers:
            self.answers[key] = Transparent().run(request)[0]
        return self.answers[key]

    def distance(self, twin: Trajectory | None) -> float | None:
        """Largest distance of a twin's run; None if there is none to compare."""
        if twin is None:
            return None
        return distance(self.instance, self.run, twin)

    def twin(self, reference: Twin, step: float) -> Twin | None:
        """The same fault with the same amplitude at another step, compared with this run; None if
        the twin without the fault, or the one with it, has no run to compare.
        """
        sound = self.sound.get((reference.method, step))
        if sound is None:
            return None
        faulty = self.ran(_engine(reference), reference.method, step)
        faulty_distance = self.distance(faulty)
        if faulty_distance is None:
            return None
        return replace(reference, step=step, distance=faulty_distance, beside=sound.distance)

    @cached_property
    def counts(self) -> list[int]:
        """Numbers of samples of growing windows; the first is as short as the defect of the nearest
        correct twin allows.
        """
        nearest = min(self.sound.values(), key=lambda twin: twin.distance)
        twin = self.ran(Transparent(), nearest.method, nearest.step)
        assert twin is not None
        return amplitude_fit.windows(
            np.abs(amplitude_fit.states(self.instance, twin, self.run) - self.like).max(axis=1)
        )

    def faulty(self) -> Iterator[Twin]:
        """Twins with known faults, and with faults of a fitted amplitude, in every method that may
        be the code's.
        """
        first = {key: self._first_window_distance(Transparent(), *key) for key in self.sound}
        best = min(first.values())
        # The code's step first: a fault that does not act there is not tried at the finer step,
        # which takes longest.
        followed = sorted(
            (key for key, distance in first.items() if distance <= MAX_DISTANCE_RATIO * best),
            key=lambda key: -key[1],
        )
        yield from self._known(followed, first)
        scene = self.request.problem.scene
        scaled_faults = [
            *misread(scene),
            *paced(),
            *(scaled for fault in faults() if (scaled := continued(fault))),
        ]
        for scaled in scaled_faults:
            if self._is_out_of_time():
                return
            yield from self._fitted(scaled, followed)

    def _is_out_of_time(self, part: float = 1.0) -> bool:
        """True if this part of the run time is spent; the search is then cut short."""
        if monotonic() - self.begun < part * self.seconds:
            return False
        self.is_cut_short = True
        return True

    def _first_window_distance(self, engine: Engine, method: str, step: float) -> float:
        """Largest difference of states in the first window; infinite if the twin cannot run."""
        off = self.difference(engine, method, step, self.counts[0])
        if off is None or not np.all(np.isfinite(off)):
            return inf
        return float(np.abs(off).max())

    def difference(self, engine: Engine, method: str, step: float, samples: int) -> Array | None:
        """Twin minus run (M,) over the first samples, in units of the scales.

        None if the twin cannot run.
        """
        twin = self.ran(engine, method, step, samples)
        if (
            twin is None
            or twin.position.shape[1:] != self.run.position.shape[1:]
            or len(twin.t) != samples
        ):
            return None
        short = Trajectory(
            **{
                name: getattr(self.run, name)[:samples]
                for name in ("t", "position", "velocity", "attitude", "omega")
            }
        )
        return np.asarray(
            (amplitude_fit.states(self.instance, twin, short) - self.like[:samples]).ravel()
        )

    def _trial_settings(
        self, fault: Fault | None, followed: list[tuple[str, float]]
    ) -> Iterator[tuple[str, float]]:
        """Methods and steps in which a fault is tried: the common ones, its own, and the finer
        step.
        """
        for method, step in followed:
            is_usual = method in USUAL_METHODS or step < self.step
            is_own = fault is not None and method == fault.method
            if not (is_usual or is_own):
                continue
            request = replace(self.request, method=method)
            if fault is None or acts(fault, request, self.called[method]):
                yield method, step

    def _known(
        self, followed: list[tuple[str, float]], first: dict[tuple[str, float], float]
    ) -> Iterator[Twin]:
        """Twins with faults of the catalogue, ordered by their distance in the first window."""
        early = []
        for number, fault in enumerate(faults()):
            inert = set()
            # Half of the time is for the first window of each fault.
            if self._is_out_of_time(0.5):
                break
            for method, step in self._trial_settings(fault, followed):
                if method in inert:
                    continue
                distance = self._first_window_distance(fault.carrier(), method, step)
                plain = first[method, step]
                if abs(distance - plain) <= NO_EFFECT * plain:
                    inert.add(method)
                elif distance <= MAX_EARLY_RESIDUAL * plain:
                    early.append((distance, number, fault, method, step))
        for _, _, fault, method, step in sorted(early, key=lambda item: item[:2])[:MAX_FULL_RUNS]:
            if self._is_out_of_time():
                return
            whole = self.distance(self.ran(fault.carrier(), method, step))
            if whole is not None:
                yield Twin(
                    fault=fault,
                    method=method,
                    step=step,
                    distance=whole,
                    beside=self.sound[method, step].distance,
                )

    def _fitted(self, scaled: ScaledFault, followed: list[tuple[str, float]]) -> Iterator[Twin]:
        """Twins with a fault of any amplitude, one in each method that can explain the run: at the
        amplitude at which it is nearest to the run.
        """
        inert = set()
        for method, step in self._trial_settings(scaled.fault, followed):
            if self._is_out_of_time():
                return
            if method in inert:
                continue
            amplitude = amplitude_fit.amplitude(
                self._differences(scaled, method, step), self.counts
            )
            if amplitude is None:
                continue
            if amplitude == 0.0:
                # The fault does not act in this method, at whatever step.
                inert.add(method)
                continue
            distance = self.distance(self.ran(scaled.carrier(amplitude), method, step))
            if distance is not None:
                yield Twin(
                    fault=scaled.fault,
                    scaled=scaled,
                    amplitude=amplitude,
                    method=method,
                    step=step,
                    distance=distance,
                    beside=self.sound[method, step].distance,
                )

    def _differences(
        self, scaled: ScaledFault, method: str, step: float
    ) -> amplitude_fit.Difference:
        """A function: twin minus run at an amplitude over a number of samples. Results at amplitude
        0 are cached.
        """

        def difference(amplitude: float, samples: int) -> Array | None:
            if amplitude:
                return self.difference(scaled.carrier(amplitude), method, step, samples)
            key = (method, step, samples)
            if key not in self.plain:
                self.plain[key] = self.difference(Transparent(), method, step, samples)
            return self.plain[key]

        return difference


def _engine(twin: Twin) -> Engine:
    """The engine that runs a given twin."""
    if twin.scaled is not None:
        return twin.scaled.carrier(twin.amplitude)
    if twin.fault:
        return twin.fault.carrier()
    return Transparent()


def first_part(request: Request) -> Request:
    """The request for the samples within MOST_STEPS steps, which distinguish twins and are short
    enough for hundreds of runs.
    """
    times = request.problem.times
    if request.step is None:
        return request
    count = max(3, min(len(times), MOST_STEPS // request.stride + 1))
    return request.with_scene(request.problem.scene, times[:count])


def distance(instance: Instance, run: Trajectory, twin: Trajectory) -> float | None:
    """Largest difference of any state or observed quantity at any sample, in units of its scale.

    None if their shapes differ.
    """
    if run.position.shape != twin.position.shape:
        return None
    with np.errstate(all="ignore"):
        largest = float(np.max(distances(instance, run, twin)))
        first = instance.observe(run)
        second = instance.observe(twin)
    for name, quantity in instance.quantities.items():
        if name in first and name in second and not quantity.group and not quantity.angle:
            largest = max(
                largest, float(np.max(np.abs(first[name] - second[name]))) / quantity.scale
            )
    if np.isfinite(largest):
        return largest
    return None


def _size(distance: float) -> str:
    return f"{distance:.1e} of its scale"
