"""From measured values to findings: errors against truth in units of each quantity's scale, and the
verdict itself.

error_q(t) = max(0, |observed_q(t) - truth_q(t)| - radius_q(t)) / scale_q,   pass: error <= bound

for every quantity q. An attitude is compared as one rotation, by the angle between the two.
`until` is the number of certified samples, `level` the step [s] or tolerance of a run.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.check import Subject
from refdem.core.engine import Method
from refdem.core.finding import Finding, Outcome, Series
from refdem.core.problem import Motion
from refdem.core.refinement import HORIZON, kinked
from refdem.core.static_problems import Static
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.errors import EngineError

Array = NDArray[np.float64]

PERTURBED = 64
"""Units in the last place by which a start is perturbed to measure the growth of errors."""
SMALL = 0.25
"""Errors above this part of the scale have no order: the run then follows another motion."""
MORE = 8.0
"""Safety factor on the measured growth, since only one direction of perturbation is tried."""
MOST_POINTS = 256
"""Number of points of a curve in a record: the largest value of each of as many equal parts."""


PLACE = ("position", "attitude")
MOTION = ("velocity", "omega")
"""The columns of a trajectory for the configuration (PLACE) and the velocities (MOTION)."""
ATTITUDE = tuple(f"attitude.{axis}" for axis in "wxyz")
"""The quantities that are compared together as one rotation."""
PREDICTION_FACTOR = 4.0
"""Factor by which an error may exceed the prediction e(h) = e(h_0) (h/h_0)^p from another step h_0.
Where the error falls with order p, the prediction is right to a few per cent. With this factor a
motion passes whose last pair of levels has an order as low as 0.3, 0.8 and 2.2 for p = 1, 2, 4.
"""
CANCELLED_DEFICIT = 7 / 8
"""Largest deficit (claimed less observed order) of a pair of levels whose errors are used to
predict the error at the finest level.

Let the errors at the steps 4 h, 2 h, h be a h^p (1 - r) with r = b h/a at the finest step, and let
the terms cancel at the coarsest one, so that it predicts less than 1/PREDICTION_FACTOR of the
finest error: |1 - 4r| < (1 - r)/4, so r < 5/17. The deficit of the finer pair is then

    log2((1 - r)/(1 - 2r)) < log2(12/7) = 0.78.

Further terms may add to it: 0.79 was measured for the Adams predictor-corrector, after 1.86 at the
pair before. Terms of order p - 1 cause a deficit of 1, and more than 1 where it falls from pair to
pair.
"""
KINK_PREDICTION_FACTOR = 64.0
"""PREDICTION_FACTOR where kinks scatter the error: two steps whose errors are alike to 1/64 by
chance, and alike to 1/64 of 2^p to those of the step before, are one in ten thousand if the scatter
is an octave.
"""
CUT_PREDICTION_FACTOR = 16.0
"""PREDICTION_FACTOR for a method that cuts its steps at kinks: only the length of the last part of
a cut step is then random.
"""
INTEGRATED = "the error of integrating the power between samples"
"""The basis of a bound where the error of the compared work is that of its integration."""
MAX_BOUND_TO_SIGNAL = 0.1
"""Largest ratio of bound to signal at which a passed check counts. With a bound as large as the
signal, a body that never moves would pass.
"""


@dataclass(frozen=True)
class Sight:
    """A bound and, in the same unit, the signal: how far the judged quantity moves in the run.

    A signal of 0 stands for a law that requires the quantity to be constant; a check of such a law
    is never undecided for a large bound.
    """

    bound: float
    signal: float

    @property
    def sharpness(self) -> float | None:
        """The bound over the signal; None without a signal."""
        if self.signal > 0:
            return self.bound / self.signal
        return None

    @property
    def movement(self) -> str:
        """The signal in words; the smallest positive double stands for no visible movement."""
        if self.signal <= np.finfo(float).tiny:
            return "no more than round-off"
        return f"{self.signal:.2g}"

    @property
    def is_blind(self) -> bool:
        """True if the bound exceeds a tenth of the signal, and the signal is not 0."""
        return self.bound > MAX_BOUND_TO_SIGNAL * self.signal > 0


def sharpest(bounds: Array, signal: Array) -> Sight:
    """Bound and signal at the sample where bound / signal is least.

    `bounds` and `signal` are (T,), in one unit; the signal at a sample is its largest value so far.
    A ratio too large for a double is infinite.
    """
    largest_signal = np.maximum.accumulate(signal)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = np.where(largest_signal > 0, bounds / largest_signal, np.inf)
    sample = int(np.argmin(ratio))
    return Sight(float(bounds[sample]), float(largest_signal[sample]))


def judged(
    *,
    check: str,
    quantity: str,
    value: float,
    bound: float,
    unit: str,
    basis: str,
    what: str = "",
    statement: str = "",
    sight: Sight | None = None,
    remedy: str = "use smaller steps, or a longer run",
    **more: Any,
) -> Finding:
    """The finding for `value <= bound`; a value that is not a number fails.

    `what` names the measured value and is the subject of the sentence; `statement`, if given,
    replaces the whole comparison. Where the bound exceeds a tenth of the signal, a value within the
    bound is undecided, and `remedy` states what would decide it; a value above it fails.
    """
    holds = bool(value <= bound)
    blind = sight is not None and sight.is_blind
    statement = statement or f"{what} is {_compared(value, bound, unit)}"
    sentence = f"{statement}. Basis: {basis}."
    if holds:
        outcome: Outcome = "pass"
    else:
        outcome = "fail"
    if holds and sight is not None and blind:
        outcome = "undecided"
        why = (
            "the allowed error is more than a tenth of how far the quantity moves;"
            f" {remedy}. It is allowed {sight.bound:.2g}, and moves by {sight.movement}"
        )
        sentence = f"{_undecided_because(why)} {sentence}"
    sharpness = None
    if sight is not None:
        sharpness = sight.sharpness
    return Finding(
        check=check,
        quantity=quantity,
        outcome=outcome,
        sentence=sentence,
        value=float(value),
        bound=float(bound),
        unit=unit,
        basis=basis,
        sharpness=sharpness,
        **more,
    )


def _compared(value: float, bound: float, unit: str) -> str:
    """The value with its unit and how it compares with the bound, as the end of a sentence."""
    measured = f"{value:.2g}"
    limit = f"{bound:.2g}"
    if unit != "1":
        measured = f"{measured} {unit}"
        limit = f"{limit} {unit}"
    if value <= bound:
        return f"{measured}, within the bound {limit}"
    if value > bound:
        return f"{measured}, above the bound {limit}"
    return f"not a number (the bound is {limit})"


def observed_order(coarse: float, fine: float) -> float:
    """The order log2(e(h)/e(h/2)) of two errors, the fine one above 0.

    It is minus infinity where the coarse error is 0.
    """
    if coarse == 0:
        return -np.inf
    return float(np.log2(coarse / fine))


def order_statement(
    order: float, claimed: float, deficit: float, tolerance: float, detail: str
) -> str:
    """The comparison of an observed order with the claimed one, as a sentence without its stop.

    `deficit` is the compared value: claimed less observed order, or its limit for small steps.
    `detail` describes the data from which the order was observed.
    """
    observed = f"Observed order {order:.2f} ({detail})"
    if not deficit <= tolerance:
        return (
            f"{observed} is below the claimed {claimed:g} by {deficit:.2g} (tolerance"
            f" {tolerance:.2g})"
        )
    if claimed - order > tolerance:
        return (
            f"{observed} approaches the claimed {claimed:g} (extrapolated deficit {deficit:.2g},"
            f" tolerance {tolerance:.2g})"
        )
    return f"{observed} meets the claimed {claimed:g} (tolerance {tolerance:.2g})"


def worst(
    *,
    check: str,
    quantity: str,
    t: Array,
    values: Array,
    allowed: Array | float,
    signal: Array | float | None = None,
    **more: Any,
) -> Finding:
    """The finding at the sample where value / bound is largest, with the whole curve.

    `values` (T,) at times `t` (T,) [s] are compared with `allowed`, a number or (T,). `signal`, a
    number or (T,), is how far the quantity has moved (see `Sight`).
    """
    bounds = np.broadcast_to(np.asarray(allowed, float), values.shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        # A value of 0 is within every bound, also a bound of 0; NaN exceeds every bound.
        ratio = np.where(values > 0, values / bounds, 0.0)
        ratio = np.where(np.isnan(values), np.inf, ratio)
    point = int(np.argmax(ratio))
    series = curve(t, values, bounds)
    if signal is None:
        sight = None
    else:
        sight = sharpest(bounds, np.broadcast_to(np.asarray(signal, float), values.shape))
    value = float(values[point])
    bound = float(bounds[point])
    return judged(
        check=check, quantity=quantity, value=value, bound=bound, series=series, sight=sight, **more
    )


def undecided(check: str, quantity: str, why: str) -> Finding:
    """A finding that decides nothing, with the reason."""
    return Finding(
        check=check, quantity=quantity, outcome="undecided", sentence=_undecided_because(why)
    )


def _undecided_because(why: str) -> str:
    """The sentence with which a finding that decides nothing opens."""
    return f"Undecided: {why}."


MIXED = "every quantity combines positions with velocities, which are half a step early"
"""The reason where none of the quantities can be compared for such a method."""


def certified(subject: Subject) -> SampledTruth | None:
    """The truth if at least two samples of it (or the only one) are certified, else None."""
    needed = min(2, len(subject.instance.times))
    if subject.truth is not None and subject.truth.until >= needed:
        return subject.truth
    return None


def no_truth(subject: Subject) -> str:
    """The reason why there is no truth to compare with."""
    reason = subject.truth_reason
    if not reason and subject.truth:
        reason = subject.truth.reason
    return reason or "no certified truth"


def errors(
    instance: Instance, trajectory: Trajectory, truth: SampledTruth, delay: float = 0.0
) -> dict[str, Array]:
    """Error (until,) of every quantity against truth, in units of its scale, less the radius that
    truth itself has.

    Angles are compared modulo 2 pi, the components of an attitude together as the angle of one
    rotation. Where velocities lag by `delay` [s], quantities made of velocities alone are compared
    with the truth of that earlier time; those that combine positions with velocities are left out,
    so that the result may be empty. Raises EngineError if the trajectory shows nothing that can be
    compared.
    """
    scaled: dict[str, Array] = {}
    for observed, at_its_time in _with_truth(instance, trajectory, truth, delay):
        scaled |= _errors(instance, observed, at_its_time)
    return scaled


def _with_truth(
    instance: Instance, trajectory: Trajectory, truth: SampledTruth, delay: float
) -> list[tuple[dict[str, Array], SampledTruth]]:
    """The observed quantities in parts, each with the truth for its times: that of the samples, and
    for quantities of velocities that lag by `delay` [s] that of `delay` earlier.
    """
    observed = instance.observe(trajectory)
    if not delay:
        return [(observed, truth)]
    by_velocity = _altered_quantities(instance, trajectory, MOTION)
    of_velocity_alone = made_of_velocities(instance, trajectory)
    on_time = {name: values for name, values in observed.items() if name not in by_velocity}
    delayed = {name: values for name, values in observed.items() if name in of_velocity_alone}
    parts = []
    if on_time:
        parts.append((on_time, truth))
    if delayed:
        parts.append((delayed, truth.delayed(delay)))
    return parts


def made_of_velocities(
    instance: Instance, trajectory: Trajectory, bodies: Sequence[int] | None = None
) -> set[str]:
    """Names of the quantities that depend on velocities, of these `bodies` if any are named, and
    not on positions.
    """
    by_velocity = _altered_quantities(instance, trajectory, MOTION, bodies)
    return by_velocity - _altered_quantities(instance, trajectory, PLACE)


def _altered_quantities(
    instance: Instance,
    trajectory: Trajectory,
    columns: tuple[str, str],
    bodies: Sequence[int] | None = None,
) -> set[str]:
    """Names of the quantities that depend on these columns of these bodies (None for all): those
    whose observed values change if the columns are changed.
    """
    count = trajectory.position.shape[1]
    is_changed = np.isin(np.arange(count), range(count) if bodies is None else bodies)
    from refdem.mechanics.quaternion import product

    # Any change without a symmetry of its own will do; an attitude must stay a unit quaternion.
    rotation = np.array([0.4, 0.1, 0.5, 0.3]) / np.sqrt(0.51)
    changed: dict[str, Any] = {}
    for column in columns:
        values = getattr(trajectory, column)
        if column == "attitude":
            other = product(rotation, values)
        else:
            other = 1.5 * values + 0.25
        changed[column] = np.where(is_changed[:, None], other, values)
    before = instance.observe(trajectory)
    after = instance.observe(replace(trajectory, **changed))
    return {name for name in before if np.any(before[name] != after[name])}


def _errors(
    instance: Instance, observed: dict[str, Array], truth: SampledTruth
) -> dict[str, Array]:
    """The `errors` of observed quantities that all belong to the samples of this truth."""
    until = truth.until
    scaled: dict[str, Array] = {}
    for name, values in observed.items():
        quantity = instance.quantities[name]
        # The components of a group, as of an attitude, are compared together below.
        if quantity.group or name not in truth.values:
            continue
        # max(0, |observed - truth| - radius)/scale.
        apart = difference(values[:until], truth.value(name), is_angle=quantity.angle)
        distance = np.maximum(0.0, np.abs(apart) - truth.radius(name))
        scaled[name] = distance / quantity.scale
    if all(name in observed and name in truth.values for name in ATTITUDE):
        scaled["attitude"] = _rotation_error(observed, truth)
    if not scaled:
        raise EngineError(
            "the trajectory shows none of the quantities of the case; expected "
            + ", ".join(instance.quantities)
        )
    return scaled


def moves(truth: SampledTruth) -> bool:
    """True if a quantity changes from sample to sample, as far as it is certified."""
    columns = [values[: truth.until] for values in truth.values.values() if values]
    return any(np.ptp(column) > 0 for column in columns)


def difference(values: Array, reference: Array, *, is_angle: bool) -> Array:
    """values - reference, each (T,); for angles the representative in [-pi, pi].

    The difference of two angles of many turns is computed from their sines and cosines, which are
    correct to a rounding of 1; the remainder of a - b modulo 2 pi has the rounding of the whole
    angle.
    """
    if not is_angle:
        straight: Array = values - reference
        return straight
    # a - b = atan2(sin a cos b - cos a sin b, cos a cos b + sin a sin b).
    across = np.sin(values) * np.cos(reference) - np.cos(values) * np.sin(reference)
    along = np.cos(values) * np.cos(reference) + np.sin(values) * np.sin(reference)
    turned: Array = np.arctan2(across, along)
    return turned


def _rotation_error(observed: dict[str, Array], truth: SampledTruth) -> Array:
    """Angle (until,) [rad] between observed and true attitude, less the radius of the truth.

    A quaternion has the half angle, so a change of it by delta turns the attitude by 2 delta.
    """
    from refdem.mechanics.quaternion import angle_between

    attitude = np.stack([observed[name][: truth.until] for name in ATTITUDE], axis=-1)
    attitude = attitude / np.linalg.norm(attitude, axis=-1, keepdims=True)
    true = np.stack([truth.value(name) for name in ATTITUDE], axis=-1)
    radius = 2.0 * np.max([truth.radius(name) for name in ATTITUDE], axis=0)
    error: Array = np.maximum(0.0, angle_between(attitude, true) - radius)
    return error


def movements(instance: Instance, truth: SampledTruth) -> dict[str, Array]:
    """The signal for `errors`: the distance |truth(t) - truth(0)| (until,) of every quantity, in
    units of its scale.

    Angles are compared modulo 2 pi, the components of an attitude together as the angle of one
    rotation [rad]. For a problem without time the signal is the size |truth|.
    """
    signals: dict[str, Array] = {}
    for name, quantity in instance.quantities.items():
        if quantity.group or name not in truth.values:
            continue
        values = truth.value(name)
        if isinstance(instance.problem, Static):
            start = np.zeros_like(values)
        else:
            start = values[0]
        displacement = difference(values, start, is_angle=quantity.angle)
        signals[name] = np.abs(displacement) / quantity.scale
    if all(name in truth.values for name in ATTITUDE):
        from refdem.mechanics.quaternion import angle_between

        true = np.stack([truth.value(name) for name in ATTITUDE], axis=-1)
        signals["attitude"] = angle_between(true, np.broadcast_to(true[0], true.shape))
    return signals


def predictable(scaled: Mapping[str, Array]) -> int:
    """Number of samples before any of these errors (until,) by quantity first exceeds SMALL."""
    return _samples_within(np.maximum.reduce(list(scaled.values())), SMALL)


def _samples_within(error: Array, limit: float) -> int:
    """Number of samples before the error (until,) first exceeds the limit or is not a number."""
    beyond = np.flatnonzero(~(error <= limit))
    if len(beyond):
        return int(beyond[0])
    return len(error)


def followed(
    subject: Subject, level: float, run: Trajectory, truth: SampledTruth, within: float = HORIZON
) -> int:
    """Number of samples before the run's error first exceeds `within`, relative to the scales.

    From that sample on the run follows another motion, to which the error growth S along the true
    motion does not apply.
    """
    return _samples_within(_largest_error(subject, level, run, truth), within)


def _largest_error(subject: Subject, level: float, run: Trajectory, truth: SampledTruth) -> Array:
    """The largest error of any quantity at each sample (until,), in units of the scales."""
    scaled = errors(subject.instance, run, truth, subject.method.delay(level))
    # max over quantities of the error; 0 if no quantity can be compared.
    largest: Array = np.maximum.reduce([np.zeros(truth.until), *scaled.values()])
    return largest


def largest_so_far(subject: Subject, level: float, run: Trajectory, truth: SampledTruth) -> Array:
    """The largest error of any quantity against truth up to each sample (until,), in units of the
    scales.
    """
    so_far: Array = np.maximum.accumulate(_largest_error(subject, level, run, truth))
    return so_far


def room_of(subject: Subject) -> float:
    """Factor by which an error may exceed what its order predicts from another step.

    It is PREDICTION_FACTOR, and more where kinks scatter the errors.
    """
    if not kinked(subject.instance, subject.method):
        return PREDICTION_FACTOR
    if subject.method.locates_events:
        return CUT_PREDICTION_FACTOR
    return KINK_PREDICTION_FACTOR


def signed(
    subject: Subject, run: Trajectory, truth: SampledTruth, count: int, delay: float = 0.0
) -> Array:
    """Signed differences (rows, count) from truth, in units of their scales; angles modulo 2 pi.

    There is one row a quantity. An attitude has three: the vector [rad] of the small rotation from
    the true attitude to the observed one, in body axes. Velocities that lag by `delay` [s] are
    compared as in `errors`; where the truth of the earlier time is not known, the difference is 0.
    """
    rows: list[Array] = []
    for observed, at_its_time in _with_truth(subject.instance, run, truth, delay):
        rows += _signed(subject, observed, at_its_time, count)
    return np.array(rows)


def _signed(
    subject: Subject, observed: dict[str, Array], truth: SampledTruth, count: int
) -> list[Array]:
    """The rows of `signed` for observed quantities that all belong to the samples of this truth."""
    rows = []
    for name, values in observed.items():
        quantity = subject.instance.quantities[name]
        if quantity.group or name not in truth.values:
            continue
        reference = truth.value(name)[:count]
        apart = difference(values[:count], reference, is_angle=quantity.angle)
        is_known = np.isfinite(truth.radius(name)[:count])
        rows.append(np.where(is_known, apart, 0.0) / quantity.scale)
    if all(name in observed and name in truth.values for name in ATTITUDE):
        rows += list(_small_rotations(observed, truth, count))
    return rows


def rounding_of_truth(subject: Subject, truth: SampledTruth, count: int) -> float:
    """Largest radius of the first `count` certified values, in units of the scales.

    Certified values are rounded to doubles, which adds to their radius. An angle of many turns is
    rounded by more than the angle modulo 2 pi of a run.
    """
    largest = 0.0
    for name, quantity in subject.instance.quantities.items():
        if name not in truth.values:
            continue
        radius = truth.radius(name)[:count]
        known = radius[np.isfinite(radius)]
        largest = max(largest, float(np.max(known, initial=0.0)) / quantity.scale)
    return largest


def _small_rotations(observed: dict[str, Array], truth: SampledTruth, count: int) -> Array:
    """Rotation vectors (3, count) [rad] from the true attitude q to the observed attitude p.

    q* p = (cos(a/2), n sin(a/2)) for the rotation by a about n, so that a n = 2 vec(q* p) to first
    order in a. p and -p are the same attitude; the sign with a positive real part of q* p is used.
    """
    from refdem.mechanics.quaternion import product

    attitude = np.stack([observed[name][:count] for name in ATTITUDE], axis=-1)
    attitude = attitude / np.linalg.norm(attitude, axis=-1, keepdims=True)
    true = np.stack([truth.value(name)[:count] for name in ATTITUDE], axis=-1)
    conjugate = true * np.array([1.0, -1.0, -1.0, -1.0])
    relative = product(conjugate, attitude)
    nearer = np.where(relative[:, :1] < 0, -relative, relative)
    vectors: Array = 2.0 * nearer[:, 1:].T
    return vectors


def left_at_finest(subject: Subject, *changes: Array) -> float:
    """Bound on the error at the finest level h, extrapolated with the claimed order p from the
    largest errors e_k at the levels h_k; infinite where there is no such bound.

        PREDICTION_FACTOR max over k of e_k (h/h_k)^p

    `changes` are the errors (T,) at the levels, coarse to fine, or at the coarsest level alone. The
    maximum is over the coarsest level, and over finer levels before which terms of the error cancel
    (`_cancels_before`). The factor allows for terms of higher order. There is no bound where kinks
    scatter the error constant from step to step. Round-off is not included.
    """
    largest = [float(np.max(change)) for change in changes]
    if (
        subject.method.control != "step"
        or kinked(subject.instance, subject.method)
        or not np.all(np.isfinite(largest))
    ):
        return float(np.inf)
    order = subject.order
    finest = subject.levels[-1]
    starts = [k for k in range(len(largest)) if k == 0 or _cancels_before(largest, k, order)]
    # PREDICTION_FACTOR max over k of e_k (h_finest/h_k)^p.
    predictions = [largest[k] * (finest / subject.levels[k]) ** order for k in starts]
    return float(PREDICTION_FACTOR * max(predictions))


def _cancels_before(largest: Sequence[float], k: int, order: float) -> bool:
    """True if terms of higher order cancel part of the error at levels coarser than k, and the pair
    of levels k, k + 1 shows the order.

    The deficits of pairs, claimed less observed order, then at least halve from pair to pair, and
    the last is below CANCELLED_DEFICIT. A term of a lower order shows a whole order less or more.
    """
    if k + 1 >= len(largest) or min(largest[k - 1 : k + 2]) <= 0:
        return False
    # Deficits p - log2(e_(k-1)/e_k) and p - log2(e_k/e_(k+1)).
    before = order - observed_order(largest[k - 1], largest[k])
    here = order - observed_order(largest[k], largest[k + 1])
    return here <= CANCELLED_DEFICIT and 2 * here <= before


def distances(instance: Instance, a: Trajectory, b: Trajectory) -> Array:
    """Largest difference (T,) between two runs of any state of any body, each in its scale.

    The scales are L for positions, V = L/tau for velocities, W for angular velocities, and
    max(1, W tau) [rad] for the angle between attitudes. W is the largest of

    - the largest initial angular velocity, or 1/tau if no body spins at the start;
    - the largest angular velocity in `b`, since an impact may make a small sphere spin much faster
      than at the start;
    - m V R/J where bodies touch (`_spin_of_an_impulse`).

    The angle scale exceeds 1 since tau is the time scale of the centres of mass: a rounding u W of
    the angular velocity changes the attitude by u W t, and a rounding u tau of the time of an
    impact changes it by u W tau. Without a scene the result is the largest difference of any
    quantity.
    """
    if not isinstance(instance.problem, Motion):
        of_a = instance.observe(a)
        of_b = instance.observe(b)
        # max over quantities of |a - b|/scale.
        largest_of_quantities: Array = np.maximum.reduce(
            [np.abs(of_a[name] - of_b[name]) / q.scale for name, q in instance.quantities.items()]
        )
        return largest_of_quantities
    scales = instance.scales
    bodies = instance.scene.bodies
    # W = max(largest omega(0) or 1/tau, largest omega of b, m V R/J),
    # angle scale = max(1, W tau).
    at_start = float(np.max(np.linalg.norm(bodies.omega, axis=1))) or 1.0 / scales.tau
    largest_omega = float(np.max(np.linalg.norm(b.omega, axis=2)))
    omega_scale = max(at_start, largest_omega, _spin_of_an_impulse(instance))
    angle_scale = max(1.0, omega_scale * scales.tau)
    # max|r_a - r_b|/L,   max|v_a - v_b|/V,   max|omega_a - omega_b|/W,   angle/(angle scale).
    differences = [
        np.abs(a.position - b.position).max(axis=(1, 2)) / scales.length,
        np.abs(a.velocity - b.velocity).max(axis=(1, 2)) / scales.speed,
    ]
    if "rotation" in instance.scene.features:
        from refdem.mechanics.quaternion import angle_between

        rotates = bodies.inertia.any(axis=1)
        angles = angle_between(a.attitude[:, rotates], b.attitude[:, rotates])
        differences.append(np.abs(a.omega - b.omega).max(axis=(1, 2)) / omega_scale)
        differences.append(angles.max(axis=1, initial=0.0) / angle_scale)
    largest: Array = np.maximum.reduce(differences)
    return largest


def _spin_of_an_impulse(instance: Instance) -> float:
    """The largest spin [rad/s] that an impulse m V at the lever R gives a sphere, m V R/J; 0 where
    nothing touches.

    The normal impulse of a contact has no moment about the centre but for its rounding. The spin of
    a fast sphere that hardly spins is therefore correct to u m V R/J only.
    """
    scene = instance.scene
    bodies = scene.bodies
    turns = (bodies.radius > 0) & bodies.inertia.all(axis=1)
    if "contact" not in scene.features or not turns.any():
        return 0.0
    # m R V/J.
    lever = bodies.mass[turns] * bodies.radius[turns] / bodies.inertia[turns].min(axis=1)
    return float(np.max(lever)) * instance.scales.speed


def perturbation(method: Method) -> int:
    """Units in the last place of a double by which a start is perturbed to measure error growth:
    PERTURBED 2^53 u.

    A unit of the method's precision is 2^53 u of a double: 1 for double precision, 2^29 for single.
    """
    return PERTURBED * round(method.round_off * 2.0**53)


def growth_shown(instance: Instance, method: Method, moved: Trajectory, base: Trajectory) -> Array:
    """Growth factor (T,) of an error made at the start, which replaces S where there is no truth:

        max over s <= t of max(1, MORE |moved(s) - base(s)|/eps).

    `moved` is the run whose start was perturbed by eps = `perturbation` 2^-52, `base` the plain
    run.
    """
    # MORE |moved - base|/eps, with eps = perturbation 2^-52.
    perturbed_by = perturbation(method) * 2.0**-52
    ratio = distances(instance, moved, base) / perturbed_by
    # The largest value of max(1, MORE ratio) so far.
    return np.maximum.accumulate(np.maximum(1.0, MORE * ratio))


def curve(t: Array, value: Array, bound: Array | float) -> Series:
    """The curve of the values, or of the largest value of each of MOST_POINTS equal parts."""
    bound = np.broadcast_to(np.asarray(bound, float), value.shape)
    kept = np.arange(len(value))
    if len(value) > MOST_POINTS:
        stretches = np.array_split(kept, MOST_POINTS)
        kept = np.array([stretch[np.argmax(value[stretch])] for stretch in stretches])
    return Series(t=t[kept].tolist(), value=value[kept].tolist(), bound=bound[kept].tolist())
