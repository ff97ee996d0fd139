"""The smoke test of an adapter: clock, units, signs, shapes, quaternion order, inertia axes; it
blames no engine.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from refdem.campaign.clock import bounded, counted, refuse_other_shape
from refdem.campaign.force_probes import force_probes
from refdem.campaign.probes import INTERVAL, Expected, Probe, probes
from refdem.campaign.suspicion import suspicion
from refdem.campaign.turning_probes import turning_probes
from refdem.core.engine import Engine, Method
from refdem.core.finding import Finding
from refdem.core.problem import CLOCK_ROUNDINGS, Motion, Request
from refdem.core.trajectory import STATE, Trajectory
from refdem.errors import UnsupportedError
from refdem.mechanics import momentum
from refdem.mechanics.quaternion import conjugate, rotated

Array = NDArray[np.float64]

STEP = INTERVAL / 128
"""[s]. First-order methods are then within 1 % on all probes, whose fastest rate is 20 /s."""
TOLERANCE = 1e-8
BOUND = 0.02
BASIS = (
    "a wrong unit, sign, axis or order changes a probe by more than a tenth"
    " of its scale; truncation error of the method changes it by less than 1"
    " %"
)
START_BOUND = 1e-12
CLOCK_BASIS = (
    "samples are whole multiples of dyadic steps, so a clock that sums the"
    " steps makes at most a few thousand roundings"
)
START_BASIS = (
    "the first sample is the initial state of the scene, which an adapter"
    " converts back and forth with a few roundings"
)


@cache
def every_probe() -> tuple[Probe, ...]:
    """All probes, the simplest first: what is wrong in one is seen there before it is seen in all
    that follow.
    """
    return (*probes(), *force_probes(), *turning_probes())


def smoke(engine: Engine) -> list[Finding]:
    """The clock, then every probe with every method that takes it; one finding for each thing
    compared, of the worst method.
    """
    found = _worst([counted(engine, method) for method in engine.methods])
    for probe in every_probe():
        reasons = {method.name: _unsupported(engine, method, probe) for method in engine.methods}
        takers = [method for method in engine.methods if reasons[method.name] is None]
        if not takers:
            reason = next(iter(reasons.values()), "the engine has no methods")
            found.append(
                Finding(
                    check="smoke",
                    quantity=probe.name,
                    outcome="unsupported",
                    sentence=f"the engine does not support this probe: {reason}",
                )
            )
            continue
        by_method = [_judged(engine, method, probe) for method in takers]
        found += _worst(by_method)
    return found


def _unsupported(engine: Engine, method: Method, probe: Probe) -> str | None:
    """None if the method takes the probe, else why not."""
    if probe.backwards and not method.backward:
        return "no method claims `backward`"
    return engine.unsupported(Motion(probe.scene, probe.times), method)


def _worst(by_method: list[list[Finding]]) -> list[Finding]:
    """The finding for each quantity of the method with the largest error; errors first."""
    worst: dict[str, Finding] = {}
    for finding in (f for findings in by_method for f in findings):
        seen = worst.get(finding.quantity)
        if seen is None or _badness(finding) > _badness(seen):
            worst[finding.quantity] = finding
    return list(worst.values())


def _badness(finding: Finding) -> float:
    if finding.outcome == "unsupported":
        return -1.0
    if finding.outcome == "error" or finding.value is None:
        return np.inf
    return finding.value


def _judged(engine: Engine, method: Method, probe: Probe) -> list[Finding]:
    """The findings of one method on one probe."""
    request = _request(method, probe)
    try:
        trajectory, _ = engine.run(request)
        refuse_other_shape(trajectory, request)
    except UnsupportedError as error:
        return [
            Finding(check="smoke", quantity=probe.name, outcome="unsupported", sentence=str(error))
        ]
    except Exception as error:  # whatever an adapter raises is its fault, and a finding
        sentence = f"{method.name} on {probe.name!r}: {type(error).__name__}: {error}"
        return [Finding(check="smoke", quantity=probe.name, outcome="error", sentence=sentence)]
    findings = [
        _clock(trajectory, request, probe, method),
        _first_sample(trajectory, request, probe, method),
    ]
    right = probe.right
    seen = {
        name: values for name in right if (values := _shown(trajectory, name, probe)) is not None
    }
    seen = {name: values.reshape(right[name].shape) for name, values in seen.items()}
    return findings + [_compared(right, seen, name, request, probe) for name in seen]


def _request(method: Method, probe: Probe) -> Request:
    request = Request(problem=Motion(probe.scene, probe.times), method=method.name)
    if method.control == "step":
        return replace(request, step=STEP)
    if method.control == "tolerance":
        return replace(request, tolerance=TOLERANCE)
    return request


def _few_roundings(method: Method) -> float:
    """A few thousand roundings in double precision, a few in single."""
    return max(START_BOUND, CLOCK_ROUNDINGS * method.round_off)


def _clock(trajectory: Trajectory, request: Request, probe: Probe, method: Method) -> Finding:
    """Are the engine's own times the samples?"""
    times = request.problem.times
    off = float(np.max(np.abs(trajectory.t - times)) / np.max(np.abs(times)))
    says = f"{request.method}: the relative error of the clock at the last sample is {off:.2g}"
    return bounded(f"{probe.name}: clock", off, _few_roundings(method), CLOCK_BASIS, says)


def _first_sample(
    trajectory: Trajectory, request: Request, probe: Probe, method: Method
) -> Finding:
    """Is row 0 the scene's state? Velocities that lag are those before it."""
    bodies = request.problem.scene.bodies
    names: tuple[str, ...] = ("position", "attitude")
    if method.velocity_time == "synchronous":
        names = STATE
    distances = []
    for column in names:
        first = getattr(trajectory, column)[0]
        is_attitude = column == "attitude"
        distance = _largest(first, getattr(bodies, column), signless=is_attitude)
        distances.append((distance, column))
    off, name = max(distances)
    says = (
        f"{request.method}: the first sample differs from the initial state of the"
        f" scene by {off:.2g} of its scale, in {name}"
    )
    return bounded(f"{probe.name}: first sample", off, _few_roundings(method), START_BASIS, says)


def _largest(seen: Array, expected: Array, *, signless: bool = False) -> float:
    """The largest difference, relative to the largest expected number or 1; q and -q are the same
    attitude.
    """
    off = np.abs(seen - expected)
    if signless:
        other = np.abs(seen + expected)
        is_nearer = off.max(axis=-1, keepdims=True) < other.max(axis=-1, keepdims=True)
        off = np.where(is_nearer, off, other)
    return float(off.max() / max(1.0, np.abs(expected).max()))


DERIVED: dict[str, Callable[[Trajectory, Array], Array]] = {
    "omega_body": lambda run, inertia: rotated(conjugate(run.attitude), run.omega),
    "angular_momentum": lambda run, inertia: momentum.spin(inertia, run.attitude, run.omega)[
        :, None
    ],
}


def _shown(trajectory: Trajectory, name: str, probe: Probe) -> Array | None:
    """What the trajectory shows of a quantity; None for a channel that it does not have."""
    if name in DERIVED:
        return DERIVED[name](trajectory, probe.scene.bodies.inertia)
    if name in STATE:
        state: Array = getattr(trajectory, name)
        return state
    return trajectory.channels.get(name)


def _compared(
    right: Expected, came: Expected, name: str, request: Request, probe: Probe
) -> Finding:
    """A quantity against its formula, over the whole run."""
    seen = came[name]
    expected = right[name]
    off = _largest(seen, expected, signless=name == "attitude")
    says = f"{request.method}: the error of {name} is {off:.2g} of its scale"
    if not off <= BOUND:
        by_sample = np.abs(seen - expected).reshape(len(seen), -1).max(axis=1)
        at = int(np.argmax(by_sample))
        says += (
            f": at t = {probe.times[at]:g} s the value is {_text(seen[at])}, expected"
            f" {_text(expected[at])}"
        )
        suspected = suspicion(right, came, name, probe.times - probe.start)
        hint = suspected or f"check how the adapter converts {probe.shows}"
        says += f"; {hint}"
    return bounded(f"{probe.name}: {name}", off, BOUND, BASIS, says)


def _text(values: Array) -> str:
    return np.array2string(
        np.round(np.squeeze(values), 4), separator=", ", max_line_width=1000
    ).replace("\n", "")
