"""Parameters of a case that a program has misread, fitted to the deviation of its run from truth.

Theorem: the motion at parameters p + d differs from that at p by M d + O(d^2), where M are the
derivatives of its quantities by the parameters (truth/sensitivities.py). A Gauss-Newton iteration
with the fixed derivatives at p converges linearly with a ratio of order d:

    p <- p + step,   step = argmin |M step - (run - truth(p))|.

Hypotheses, and where each is checked:

* the program follows the equations of the case: a misreading is accepted only if the largest
  residual is at most MAX_NOISE_RATIO times the discretisation error (`Fit.is_within_noise`);
* the discretisation error is at most the change by halving the step, which holds from the first
  order on: `Observed.noise`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.judgement import difference
from refdem.core.parameters import Parameters
from refdem.core.trajectory import Trajectory
from refdem.errors import NotCertifiedError, RefdemError
from refdem.truth.sensitivities import Number, at_times, numbers_of

Array = NDArray[np.float64]
SAMPLES = 12
"""Number of times, spread over a run, at which it is compared with truth."""
DIGITS = 17
"""Decimal places of the values and derivatives that are fitted."""
ROUNDING = 1e-14
"""The least noise, in scales: a few roundings."""
MAX_NOISE_RATIO = 3.0
"""Largest residual, in units of the noise, that counts as noise."""
ITERATIONS = 20
"""Largest number of Gauss-Newton steps; the iteration ends when a step does not halve the residual.
"""
CANDIDATES = 6
"""Number of sets of parameters of one size that are fitted, those of the largest linear effect."""
PROMISING = 0.5
"""Least part of the squared deviation that a set of parameters must explain in the linear fit."""
MOST = 2
"""Largest number of parameters that are misread at the same time."""
LARGEST = 0.2
"""Largest relative misreading. A larger one is another law or another unit, which twins explain
(twins.py).
"""
FIT_COST = 10.0
"""Approximate time of a fit in units of the time of the values of truth."""
MAX_EXPLAINED = 0.9999
"""Largest explained part that a sentence shows, so that it is not rounded to 100 %."""


@dataclass(frozen=True)
class Fit:
    """Parameters changed by `amounts` [their units] to fit a run. `explains` is the part of the
    squared deviation that the change removes, `left` the largest residual in units of the noise.
    """

    numbers: tuple[Number, ...]
    values: tuple[float, ...]
    amounts: tuple[float, ...]
    explains: float
    left: float

    @property
    def is_within_noise(self) -> bool:
        """True if the largest residual is within the noise."""
        return self.left <= MAX_NOISE_RATIO

    @property
    def is_small(self) -> bool:
        """True if the relative change of every parameter is small."""
        pairs = zip(self.values, self.amounts, strict=True)
        return all(abs(amount) <= LARGEST * (abs(value) or 1.0) for value, amount in pairs)

    def words(self) -> str:
        """The numbers and by how much each was misread."""
        parts = []
        for number, value, amount in zip(self.numbers, self.values, self.amounts, strict=True):
            if value:
                share = amount / abs(value)
                parts.append(
                    f"{number.name} {relative_error_text(abs(share))} too {side_of_error(share)}"
                )
            else:
                parts.append(f"{number.name} read as {amount:.4g} instead of 0")
        return " and ".join(parts)


def relative_error_text(share: float) -> str:
    """A relative misreading as text, in ppm or per cent."""
    if share < 1e-3:
        return f"{1e6 * share:.3g} ppm"
    return f"{100 * share:.3g} %"


def side_of_error(share: float) -> str:
    """The word for the side on which a number was misread."""
    if share > 0:
        return "large"
    return "small"


@dataclass(frozen=True)
class Misreading:
    """The result of fitting the parameters of a case to a run.

    `fits` are those within the noise, that which explains most first; `deviation` is the largest
    deviation in scales. `is_noise` is True if this is within the discretisation error.
    """

    deviation: float
    is_noise: bool
    fits: tuple[Fit, ...] = ()

    def sentence(self) -> str:
        """What was misread, or that no misreading explains the run."""
        if self.is_noise:
            return "agrees with truth within its discretisation error"
        if not self.fits:
            return "no misread parameter of the case explains the deviation from truth"
        first, *others = self.fits
        explained = min(first.explains, MAX_EXPLAINED)
        words = (
            f"{first.words()} explains {100 * explained:.2f} % of the deviation from truth"
            f" ({self.deviation:.2g} of its scale); the rest is within the discretisation error"
        )
        if others:
            alike = "; ".join(fit.words() for fit in others)
            return f"{words}; equally explained by {alike}: this run cannot distinguish them"
        return f"{words}; no other parameter of the case explains it"


@dataclass(frozen=True)
class Observed:
    """A run of a program at two steps, and the times at which it is compared with truth."""

    instance: Instance
    run: Trajectory
    finer: Trajectory

    @cached_property
    def samples(self) -> list[int]:
        """The numbers of the samples, spread over the run as far as truth is certified."""
        count = min(len(self.run.position), len(self.finer.position), len(self.instance.times))
        spread = np.unique(np.linspace(1, count - 1, SAMPLES).astype(int))
        truth = self.instance.truth().refined(DIGITS)
        certified = []
        for sample in spread:
            try:
                truth.at(self.time(sample))
            except NotCertifiedError:
                break
            certified.append(int(sample))
        return certified

    def time(self, sample: int) -> Fraction:
        """The exact time [s] of a sample."""
        return Fraction(float(self.instance.times[sample]))

    @cached_property
    def observed(self) -> Mapping[str, Array]:
        """The quantities of the run at the finer step."""
        return self.instance.observe(self.finer)

    @cached_property
    def names(self) -> list[str]:
        """The quantities that are compared, one by one."""
        return [name for name in self.instance.quantities if name in self.observed]

    @cached_property
    def noise(self) -> Array:
        """The bound on the discretisation error (samples x quantities), in scales: the running
        maximum of the change from the run to that at the finer step.
        """
        coarse = self.instance.observe(self.run)
        columns = []
        for name in self.names:
            quantity = self.instance.quantities[name]
            last = max(self.samples) + 1
            change = difference(
                self.observed[name][:last], coarse[name][:last], is_angle=quantity.angle
            )
            so_far = np.maximum.accumulate(np.abs(change)) / quantity.scale
            columns.append(so_far[self.samples] + ROUNDING)
        return np.stack(columns, axis=1)

    def deviations(self, p: Parameters) -> Array:
        """The run at the finer step minus truth at parameters p, in units of the noise, flat."""
        truth = self.instance.case.truth(p).refined(DIGITS)
        rows = [truth.at(self.time(sample)) for sample in self.samples]
        columns = []
        for name in self.names:
            quantity = self.instance.quantities[name]
            true = np.array([float(row[name]) for row in rows])
            deviation_from_truth = difference(
                self.observed[name][self.samples], true, is_angle=quantity.angle
            )
            columns.append(deviation_from_truth / quantity.scale)
        flat: Array = (np.stack(columns, axis=1) / self.noise).ravel()
        return flat

    def slopes(self, p: Parameters, numbers: Sequence[Number]) -> Array:
        """The derivatives M of truth by some parameters, in units of the noise, a column each."""
        scales = np.array([self.instance.quantities[name].scale for name in self.names])
        times = [self.time(sample) for sample in self.samples]
        found = at_times(self.instance.case.truth, p, numbers, times, DIGITS)
        rows = [[[float(slope) for slope in one[name]] for name in self.names] for one in found]
        weighted = np.array(rows) / (scales[:, None] * self.noise[:, :, None])
        return weighted.reshape(-1, len(numbers))


def misreading(
    instance: Instance, run: Trajectory, finer: Trajectory, seconds: float
) -> Misreading:
    """The parameters of a case, at most MOST, that a program has misread, from its runs at two
    steps.

    Raises NotCertifiedError where derivatives are not certified, or would take longer than
    `seconds` [s].
    """
    p = instance.case.written_out(instance.p)
    observed = Observed(instance, run, finer)
    if not observed.samples:
        raise NotCertifiedError("no sample of the run lies where truth is certified")
    last = observed.time(observed.samples[-1])
    if FIT_COST * instance.truth().forecast(last, DIGITS) > seconds:
        raise NotCertifiedError(f"derivatives would take longer than {seconds:g} s")
    deviations = observed.deviations(p)
    deviation = float(np.max(np.abs(deviations.reshape(observed.noise.shape) * observed.noise)))
    if np.max(np.abs(deviations)) <= MAX_NOISE_RATIO:
        return Misreading(deviation, is_noise=True)
    numbers = list(numbers_of(p))
    matrix = observed.slopes(p, numbers)
    for count in range(1, MOST + 1):
        fits = []
        for chosen in best_subsets(deviations, matrix, count):
            fit = gauss_newton_fit(observed, p, [numbers[k] for k in chosen], matrix[:, chosen])
            if fit is not None and fit.is_within_noise and fit.is_small:
                fits.append(fit)
        if fits:
            fits.sort(key=lambda fit: -fit.explains)
            return Misreading(deviation, is_noise=False, fits=tuple(fits))
    return Misreading(deviation, is_noise=False)


def best_subsets(deviations: Array, matrix: Array, count: int) -> list[tuple[int, ...]]:
    """The sets of `count` columns that explain most of the deviations in a linear fit, the best
    first.
    """
    total = float(deviations @ deviations)
    nonzero_columns = [k for k in range(matrix.shape[1]) if np.any(matrix[:, k])]
    ranked = []
    for chosen in combinations(nonzero_columns, count):
        columns = matrix[:, chosen]
        amounts = np.linalg.lstsq(columns, deviations)[0]
        left = deviations - columns @ amounts
        explained = 1.0 - float(left @ left) / total
        if explained >= PROMISING:
            ranked.append((explained, chosen))
    ranked.sort(reverse=True)
    return [chosen for _, chosen in ranked[:CANDIDATES]]


def gauss_newton_fit(
    observed: Observed, p: Parameters, numbers: Sequence[Number], matrix: Array
) -> Fit | None:
    """The fit of some parameters by a Gauss-Newton iteration with the derivatives `matrix` at those
    of the case; None if the first step leaves the range of the parameters.
    """
    begin = observed.deviations(p)
    square_at_begin = float(begin @ begin)
    residual = begin
    moved = p
    best: Fit | None = None
    try:
        values = tuple(float(number.of(p)) for number in numbers)
        for _ in range(ITERATIONS):
            # The least squares solution of M step = run - truth(p).
            step = np.linalg.lstsq(matrix, residual)[0]
            for number, amount in zip(numbers, step, strict=True):
                moved = number.set_in(moved, number.of(moved) + Fraction(float(amount)))
            residual = observed.deviations(moved)
            amounts = tuple(float(number.of(moved) - number.of(p)) for number in numbers)
            # 1 - |residual|^2/|deviation|^2.
            explains = 1.0 - float(residual @ residual) / square_at_begin
            largest = float(np.max(np.abs(residual)))
            fit = Fit(tuple(numbers), values, amounts, explains, left=largest)
            if best is not None and not fit.left < best.left / 2:
                break
            best = fit
    except (RefdemError, ValueError, ArithmeticError):
        return best
    return best
