"""The smoke test of an adapter: clock, units, signs, shapes, quaternion order, inertia axes.

Probes are so simple that any engine solves them, so that a wrong result is due to its adapter.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Engine, Method
from refdem.core.finding import Finding
from refdem.core.judgement import KINK_PREDICTION_FACTOR, PREDICTION_FACTOR
from refdem.core.problem import CLOCK_ROUNDINGS, Motion, Request
from refdem.core.trajectory import STATE, Trajectory
from refdem.engines.external.program import KEPT
from refdem.engines.external.serving import NOT_AGAIN
from refdem.errors import UnsupportedError
from refdem.mechanics import momentum
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.singularity import KINK, sharpest_exponent
from refdem.smoke.clock import bounded_finding, refuse_other_shape, step_count_findings
from refdem.smoke.diagnosis import likely_causes
from refdem.smoke.force_probes import force_probes
from refdem.smoke.gripping_probes import gripping_probe
from refdem.smoke.impact_probes import impact_probes
from refdem.smoke.neighbour_probes import neighbour_probes
from refdem.smoke.probes import INTERVAL, Expected, Probe, probes
from refdem.smoke.turning_probes import turning_probes

Array = NDArray[np.float64]

STEP = INTERVAL / 128
"""Step [s] at which first-order methods are within 1 % on all probes, whose fastest rate is 20 /s.
"""
TOLERANCE = 1e-8
"""Relative tolerance of methods that control their error: far below BOUND for all of them."""
BOUND = 0.02
"""Largest error of a probe in units of its scale: twice the 1 % of first-order methods (STEP), and
a fifth of the error by a wrong convention (BASIS).
"""
SMOOTH_BOUND = 0.001
"""The same where the force is smooth and the method claims the order 2 or more, a tolerance, or to
be exact. Its error is at most C (1 + T/tau) (h/tau)^2 = 5e-4 C at the rate 1/tau = 20 /s, with
C = 1, so that a number with an error of 1 % is detected.
"""
BASIS = (
    "a wrong unit, sign, axis or order changes a probe by more than a tenth"
    " of its scale; truncation error of the method changes it by less than 1"
    " %"
)
SMOOTH_BASIS = (
    "a number that is wrong by 1 % changes a probe by more than 0.1 % of its"
    " scale; truncation error of a method of order 2 changes it by less than"
    " 0.05 % where forces are smooth"
)
RATE = 20.0
"""The fastest rate of a probe [1/s]."""
OUTPUT_ROUNDING = 2.0**-31
"""Least bound on the error that is estimated from two steps, in units of the scale of a probe. The
5e-10 allow for numbers printed with ten digits, and exceed the round-off of 4096 steps by far.
"""
IMPLIED_BASIS = (
    "error implied by the change from twice the step, {factor:.3g} times that change, for order"
    " {order}"
)
START_BOUND = 1e-12
"""Largest error of the first sample in units of its scale, for a method in binary64: a few
thousand roundings; a conversion (START_BASIS) makes a few.
"""
FAILURES_TO_GIVE_UP = 3
"""Number of failures with the same cause after which an engine without any result is given up."""
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
    """All probes, the simplest first, so that the first failure is on the simplest probe that the
    fault affects.
    """
    return (
        *probes(),
        *force_probes(),
        *neighbour_probes(),
        gripping_probe(),
        *impact_probes(),
        *turning_probes(),
    )


def smoke(engine: Engine) -> list[Finding]:
    """The findings on the clock, then on every probe with every method that supports it.

    There is one finding for each quantity compared, that of the method with the largest error. A
    failure that many probes share is reported once, with their names. An engine without any result
    that fails for the same reason each time is given up.
    """
    findings = _worst([step_count_findings(engine, method) for method in engine.methods])
    not_run = []
    for probe in every_probe():
        reasons = [(method, _unsupported(engine, method, probe)) for method in engine.methods]
        supporting = [method for method, reason in reasons if reason is None]
        if not supporting:
            sentence = f"the engine does not support this probe: {_refusal(reasons, probe)}"
            findings.append(
                Finding(
                    check="smoke", quantity=probe.name, outcome="unsupported", sentence=sentence
                )
            )
        elif _always_fails(findings):
            not_run.append(probe.name)
        else:
            findings += _worst([_probe_findings(engine, method, probe) for method in supporting])
    return _merged_errors(findings, not_run)


def _refusal(reasons: list[tuple[Method, str | None]], probe: Probe) -> str:
    """The reason why no method supports a probe.

    Where the probe runs backwards, that of a method which claims `backward`, if there is one.
    """
    claiming = [reason for method, reason in reasons if method.backward or not probe.backwards]
    others = [reason for _, reason in reasons]
    return next(iter([*claiming, *others]), None) or "the engine has no methods"


def _always_fails(findings: list[Finding]) -> bool:
    """True if there is no result so far, and at least FAILURES_TO_GIVE_UP failures, all with the
    same cause.
    """
    if any(finding.outcome in ("pass", "fail") for finding in findings):
        return False
    failed = [finding for finding in findings if finding.outcome == "error"]
    return len(failed) >= FAILURES_TO_GIVE_UP and len({_cause(finding) for finding in failed}) == 1


def _merged_errors(findings: list[Finding], not_run: list[str]) -> list[Finding]:
    """The findings with errors of the same cause merged: the first one names the others, and the
    probes that were not tried.
    """
    same: dict[str, list[str]] = {}
    for finding in findings:
        if finding.outcome == "error":
            same.setdefault(_cause(finding), []).append(finding.quantity)
    merged = []
    for finding in findings:
        if finding.outcome != "error":
            merged.append(finding)
        elif (quantities := same.pop(_cause(finding), None)) is not None:
            merged.append(_with_equal_failures(finding, quantities[1:], not_run))
    return merged


def _with_equal_failures(finding: Finding, failed: list[str], not_run: list[str]) -> Finding:
    """The finding on an error, which names the other probes that failed for the same reason, and
    those that were not tried because of it.
    """
    sentence = finding.sentence
    if failed:
        sentence += f"; also failed for the same reason ({len(failed)}): {', '.join(failed)}"
    if not_run:
        sentence += f"; not run for this reason ({len(not_run)}): {', '.join(not_run)}"
    return msgspec.structs.replace(finding, sentence=sentence)


def _cause(finding: Finding) -> str:
    """The text of an error without the probe at which it occurred and the files kept of it."""
    cause = finding.sentence.partition(": ")[2]
    for ending in (KEPT, NOT_AGAIN):
        cause = cause.partition(ending)[0]
    return cause


def _unsupported(engine: Engine, method: Method, probe: Probe) -> str | None:
    """None if the method supports the probe, else the reason."""
    if probe.backwards and not method.backward:
        return "no method claims `backward`"
    return engine.unsupported(Motion(probe.scene, probe.times), method)


def _worst(by_method: list[list[Finding]]) -> list[Finding]:
    """The finding for each quantity of the method with the largest error; errors first."""
    worst: dict[str, Finding] = {}
    for finding in (f for findings in by_method for f in findings):
        worst_so_far = worst.get(finding.quantity)
        if worst_so_far is None or _severity(finding) > _severity(worst_so_far):
            worst[finding.quantity] = finding
    return list(worst.values())


def _severity(finding: Finding) -> float:
    """The rank of a finding: the ratio of error to bound. An error finding ranks above and a
    refusal below all others.
    """
    if finding.outcome == "unsupported":
        return -1.0
    if finding.outcome == "error" or finding.value is None:
        return np.inf
    if not finding.bound:
        return finding.value
    return finding.value / finding.bound


def _probe_findings(engine: Engine, method: Method, probe: Probe) -> list[Finding]:
    """The findings of one method on one probe."""
    request = _request(method, probe)
    try:
        trajectory, _ = engine.run(request)
        refuse_other_shape(trajectory, request)
    except UnsupportedError as error:
        return [
            Finding(check="smoke", quantity=probe.name, outcome="unsupported", sentence=str(error))
        ]
    # Any exception of an adapter is its fault, and becomes a finding.
    except Exception as error:
        sentence = f"{method.name} on {probe.name!r}: {type(error).__name__}: {error}"
        return [Finding(check="smoke", quantity=probe.name, outcome="error", sentence=sentence)]
    findings = [
        _clock_finding(trajectory, request, probe, method),
        _first_sample_finding(trajectory, request, probe, method),
    ]
    expected_values = probe.expected_values
    observed = {}
    for name, expected in expected_values.items():
        values = _observed(trajectory, name, probe)
        if values is not None:
            observed[name] = values.reshape(expected.shape)
    changes = _changes_from_twice_the_step(engine, request, probe, observed)
    return findings + [
        _error_finding(
            expected_values,
            observed,
            name,
            request,
            probe,
            _error_bound(method, probe, changes.get(name)),
        )
        for name in observed
    ]


def _changes_from_twice_the_step(
    engine: Engine, request: Request, probe: Probe, observed: Expected
) -> dict[str, float]:
    """The largest change of every quantity from twice the step, in units of its scale; empty where
    no error is estimated from it.

    No error is estimated for methods without steps, for single precision, whose round-off is of the
    same size, for velocities that lag, and where a force jumps within a step.
    """
    method = engine.method(request.method)
    if (
        method.control != "step"
        or method.precision != "double"
        or method.velocity_time != "synchronous"
        or _sharpest_kink(probe) < KINK
    ):
        return {}
    try:
        trajectory, _ = engine.run(replace(request, step=2 * STEP))
        refuse_other_shape(trajectory, request)
    # The run at the step itself is judged; without this one its bound is wider.
    except Exception:
        return {}
    changes = {}
    for name, values in observed.items():
        coarse = _observed(trajectory, name, probe)
        if coarse is not None:
            is_attitude = name == "attitude"
            changes[name] = _relative_error(
                coarse.reshape(values.shape), values, up_to_sign=is_attitude
            )
    return changes


def _sharpest_kink(probe: Probe) -> float:
    """The exponent n of the force |s|^n through the sharpest kink that the motion of the probe
    passes; infinite without one.
    """
    if probe.is_smooth:
        return np.inf
    return sharpest_exponent(limit for _, limit in probe.scene.singularities())


def _error_bound(method: Method, probe: Probe, change: float | None) -> tuple[float, str]:
    """The bound on the error of a probe in units of its scale, and its basis.

    It is the smaller one of the bound for every correct program and of the estimate from the
    `change` from twice the step.
    """
    bound, basis = _largest_error_bound(method, probe)
    if change is None:
        return bound, basis
    order = method.order_for(Motion(probe.scene, probe.times).features)
    n = _sharpest_kink(probe)
    if np.isinf(n):
        # With e(h) = C h^p the change from 2 h to h is e(2 h) - e(h) = (2^p - 1) e(h).
        factor = PREDICTION_FACTOR / (2.0**order - 1.0)
        kink_error = 0.0
    else:
        # The step that straddles the kink has an error of its own, and C scatters (checks/_kinks).
        factor = KINK_PREDICTION_FACTOR
        kink_error = PREDICTION_FACTOR * (STEP * RATE) ** (n + 1)
    implied = factor * change + kink_error + probe.uncertainty + OUTPUT_ROUNDING
    if not implied < bound:
        return bound, basis
    return implied, IMPLIED_BASIS.format(factor=factor, order=order)


def _largest_error_bound(method: Method, probe: Probe) -> tuple[float, str]:
    """The bound on the error of a probe in units of its scale for every correct program, and its
    basis.

    A kink of the force lowers the order of fixed steps, and velocities that lag are compared with
    those half a step later.
    """
    problem = Motion(probe.scene, probe.times)
    is_second_order = method.control != "step" or method.order_for(problem.features) >= 2
    is_smooth = not probe.scene.is_kinked()
    if is_second_order and is_smooth and method.velocity_time == "synchronous":
        return min(BOUND, SMOOTH_BOUND * max(1.0, method.constant)), SMOOTH_BASIS
    return BOUND, BASIS


def _request(method: Method, probe: Probe) -> Request:
    """The request for a probe, with a step or a tolerance that makes the method's error small."""
    request = Request(problem=Motion(probe.scene, probe.times), method=method.name)
    if method.control == "step":
        return replace(request, step=STEP)
    if method.control == "tolerance":
        return replace(request, tolerance=TOLERANCE)
    return request


def _few_roundings(method: Method) -> float:
    """The relative error of a few thousand roundings in double precision, of a few in single."""
    return max(START_BOUND, CLOCK_ROUNDINGS * method.round_off)


def _clock_finding(
    trajectory: Trajectory, request: Request, probe: Probe, method: Method
) -> Finding:
    """The finding on the engine's own times, which must be the requested samples."""
    times = request.problem.times
    error = float(np.max(np.abs(trajectory.t - times)) / np.max(np.abs(times)))
    sentence = (
        f"{request.method}: the relative error of the clock at the last sample is {error:.2g}"
    )
    return bounded_finding(
        f"{probe.name}: clock", error, _few_roundings(method), CLOCK_BASIS, sentence
    )


def _first_sample_finding(
    trajectory: Trajectory, request: Request, probe: Probe, method: Method
) -> Finding:
    """The finding on row 0, which must be the scene's state; in a periodic box any image of a place
    will do.

    Velocities that lag are of half a step earlier and are left out.
    """
    scene = request.problem.scene
    bodies = scene.bodies
    names: tuple[str, ...] = ("position", "attitude")
    if method.velocity_time == "synchronous":
        names = STATE
    distances = []
    for column in names:
        first = getattr(trajectory, column)[0]
        expected = getattr(bodies, column)
        for box in scene.all(PeriodicBox):
            if column == "position":
                first = expected + box.nearest(first - expected)
        is_attitude = column == "attitude"
        distance = _relative_error(first, expected, up_to_sign=is_attitude)
        distances.append((distance, column))
    error, name = max(distances)
    sentence = (
        f"{request.method}: the first sample differs from the initial state of the"
        f" scene by {error:.2g} of its scale, in {name}"
    )
    quantity = f"{probe.name}: first sample"
    return bounded_finding(quantity, error, _few_roundings(method), START_BASIS, sentence)


def _relative_error(values: Array, expected: Array, *, up_to_sign: bool = False) -> float:
    """The largest difference, relative to the largest expected number or 1.

    `up_to_sign` compares up to the sign of each vector: q and -q are the same attitude.
    """
    difference = np.abs(values - expected)
    if up_to_sign:
        to_opposite = np.abs(values + expected)
        is_nearer = difference.max(axis=-1, keepdims=True) < to_opposite.max(axis=-1, keepdims=True)
        difference = np.where(is_nearer, difference, to_opposite)
    return float(difference.max() / max(1.0, np.abs(expected).max()))


DERIVED: dict[str, Callable[[Trajectory, Array], Array]] = {
    "omega_body": lambda run, inertia: rotated(conjugate(run.attitude), run.omega),
    "angular_momentum": lambda run, inertia: momentum.spin(inertia, run.attitude, run.omega)[
        :, None
    ],
}


def _observed(trajectory: Trajectory, name: str, probe: Probe) -> Array | None:
    """The values of a quantity in a trajectory; None for a channel that it does not have."""
    if name in DERIVED:
        return DERIVED[name](trajectory, probe.scene.bodies.inertia)
    if name in STATE:
        state: Array = getattr(trajectory, name)
        return state
    return trajectory.channels.get(name)


def _error_finding(
    expected_values: Expected,
    observed: Expected,
    name: str,
    request: Request,
    probe: Probe,
    bound_and_basis: tuple[float, str],
) -> Finding:
    """The finding on one quantity, compared with its formula over the whole run.

    `expected_values` and `observed` have all quantities, for the diagnosis of the adapter's
    mistake; `bound_and_basis` is the bound with its basis.
    """
    values = observed[name]
    expected = expected_values[name]
    error = _relative_error(values, expected, up_to_sign=name == "attitude")
    bound, basis = bound_and_basis
    sentence = f"{request.method}: the error of {name} is {error:.2g} of its scale"
    if not error <= bound:
        by_sample = np.abs(values - expected).reshape(len(values), -1).max(axis=1)
        worst = int(np.argmax(by_sample))
        sentence += (
            f": at t = {probe.times[worst]:g} s the value is {_text(values[worst])}, expected"
            f" {_text(expected[worst])}"
        )
        elapsed = probe.times - probe.start
        cause = likely_causes(expected_values, observed, name, elapsed, probe.wrong_answers)
        if cause:
            sentence += f"; likely cause: {cause}"
        else:
            sentence += f"; no known mistake explains it; check in the adapter: {probe.verifies}"
    return bounded_finding(f"{probe.name}: {name}", error, bound, basis, sentence)


def _text(values: Array) -> str:
    """The numbers of an array to 4 decimals, on one line."""
    rounded = np.round(np.squeeze(values), 4)
    lines = np.array2string(rounded, separator=", ", max_line_width=1000)
    return lines.replace("\n", "")
