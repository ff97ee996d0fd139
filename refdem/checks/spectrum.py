"""The spectral lines of a driven oscillator, in amplitude and phase: those of the drives, and those
at combination frequencies, from a nonlinear spring (1.122), (1.123), or a limit cycle (1.124).

A line is a linear map of the samples, c = sum_j l_j x_j (mechanics.spectral_lines), the same for
the run and for the certified motion. So its error is the map of the errors of the samples,

    |c - c_true|  =  |sum_j l_j (x_j - x_j,true)|  <=  sum_j |l_j| bound_j

without any approximation, however slowly the transient decays. c is complex: |c - c_true| bounds
the error of its amplitude, and, in units of |c|, that of its phase.

The frequency w of van der Pol's cycle has no closed form: it is found from the certified motion.
The map is linear for any w, so the bound does not depend on the accuracy of w.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from refdem.core.check import Array, Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    Sight,
    certified,
    judged,
    left_at_finest,
    no_truth,
    undecided,
)
from refdem.core.refinement import COUNTING_FLOOR, HORIZON, scored
from refdem.core.truth import SampledTruth
from refdem.core.variant import Variant
from refdem.mechanics.spectral_lines import (
    SAME,
    Line,
    cycle_frequency,
    cycle_lines,
    free_motions,
    line_map,
    mixed_lines,
)
from refdem.scene import Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

Complex = NDArray[np.complex128]

SMALLEST = float(np.finfo(float).tiny)
"""Signal [m] of a line to which the motion does not contribute: the smallest positive double, which
no bound is below.
"""
PLACE = "x"
"""The quantity whose lines are judged."""
AMPLIFIED = 10.0
"""Largest factor by which a line may amplify errors of the samples. Beyond it, an error within the
horizon, a tenth of the scale, may be as large as the motion. It is 2 for lines that the samples
resolve well.
"""
FADED = 9.0
"""Exponent mu t of the decay exp(-mu t) towards van der Pol's cycle from which on samples are used:
figure 1.25 omits 45 s, at mu = 0.2.
"""
CYCLE_ORDER = 5
"""Largest order |j| + |k| of a line j w + k wd of a cycle and a drive. The last line that figure
1.25 names is 3w-2wd.
"""
FEWEST = 2
"""Smallest number of samples on the cycle from which lines are computed."""
ROUND = 1.0
"""Largest mu/w0 of a cycle that is nearly a sine: beyond it, relaxation has lines of all orders."""


@dataclass(frozen=True, eq=False)
class Lines:
    """The lines of a motion, and the rows (K, T) of the map that gives them."""

    lines: tuple[Line, ...]
    rows: Complex

    def amplified(self, errors: Array) -> Array:
        """Bounds (K,) on errors of the lines from errors e (T,) of the samples, sum_j |l_j| e_j."""
        largest: Array = np.abs(self.rows) @ errors
        return largest


class Spectrum(Check):
    """Every line of the motion has its amplitude and its phase."""

    name = "spectrum"
    title = "Spectral lines"
    kills = (
        "a nonlinear part of a spring with the wrong sign or factor: a shift to the other side,"
        " lines at twice a drive, at sums and at differences of two; a drive that is left out"
    )

    def applies(self, subject: Subject) -> str | None:
        """One body on a line, on a spring that is linear, or has a square or a cube, under periodic
        forces that the samples resolve; or van der Pol's oscillator under one of them.
        """
        if not is_driven_on_a_line(subject.instance.scene):
            return "the scene is not one body on a spring under periodic forces along a line"
        if PLACE not in subject.instance.quantities:
            return "the case has no place along a line"
        if lines_of(subject.instance.scene, subject.instance.times) is None:
            return "the samples are too few or cover too short a time to resolve the lines"
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run of every level."""
        return subject.plain

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding for each line: the error of its complex amplitude at the finest level."""
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "lines", no_truth(subject))]
        level = subject.levels[-1]
        allowed = subject.bound(level)
        count = scored(allowed)
        true = truth.value(PLACE)[:count]
        found = lines_of(subject.instance.scene, subject.instance.times[:count], true)
        if found is None:
            why = "the samples up to the predictability horizon do not resolve the lines"
            return [undecided(self.name, "lines", why)]
        # Errors (count,) [m] of the samples, level by level.
        off = [
            subject.instance.observe(runs[variant].trajectory)[PLACE][:count] - true
            for variant in subject.plain
        ]
        bounds, basis = _bounds(subject, truth, found, off)
        rounding = _rounding(subject, truth, found)
        findings = []
        for k, line in enumerate(found.lines):
            certified_line = complex(found.rows[k] @ true)
            error = complex(found.rows[k] @ off[-1])
            # The signal is the line of x - x(0): the constant x(0) alone, which a body at rest has,
            # also contributes to the shift.
            moved = abs(complex(found.rows[k] @ (true - true[0])))
            signal = SMALLEST
            if moved > rounding[k]:
                signal = moved
            if abs(certified_line) <= rounding[k]:
                # A line that symmetry forbids: any value beyond the bound is wrong.
                signal = 0.0
            bound = float(bounds[k])
            findings.append(
                judged(
                    check=self.name,
                    quantity=line.name,
                    value=abs(error),
                    bound=bound,
                    sight=Sight(bound, signal),
                    unit="m",
                    basis=basis[k],
                    what=_what(line, certified_line, certified_line + error),
                )
            )
        return findings


def is_driven_on_a_line(scene: Scene) -> bool:
    """True if the scene is one body on a spring with a linear part, with dashpots, weight and
    periodic forces at most, all of it along a line.
    """
    kinds = (Spring, Dashpot, Force, UniformGravity)
    if len(scene.bodies) != 1 or not all(isinstance(e, kinds) for e in scene.elements):
        return False
    springs = scene.all(Spring)
    is_held = len(springs) == 1 and springs[0].stiffness > 0 and springs[0].exponent == 1
    is_damped_linearly = not any(dashpot.van_der_pol for dashpot in scene.all(Dashpot))
    is_on_a_line = "dimension:1" in scene.features and not scene.bodies.fixed.any()
    is_driven = is_held and is_on_a_line and drives_of(scene)
    return bool(is_driven and (is_damped_linearly or has_a_cycle(scene)))


def has_a_cycle(scene: Scene) -> bool:
    """True for van der Pol's oscillator under one periodic force (1.124): a linear spring, and one
    dashpot with negative damping -c for small amplitudes, 0 < c/m <= ROUND w0.
    """
    dashpots = scene.all(Dashpot)
    (spring,) = scene.all(Spring)
    if len(dashpots) != 1 or len(drives_of(scene)) != 1 or spring.quadratic or spring.cubic:
        return False
    (dashpot,) = dashpots
    # mu = c/m <= ROUND w0,  w0 = sqrt(k/m):  c <= ROUND sqrt(k m).
    gentle = ROUND * float(np.sqrt(spring.stiffness * scene.bodies.mass[0]))
    return bool(dashpot.van_der_pol > 0 and -gentle <= dashpot.damping < 0)


def drives_of(scene: Scene) -> list[float]:
    """The distinct angular frequencies [rad/s] of the periodic forces, in their order."""
    frequencies: list[float] = []
    for force in scene.all(Force):
        is_new = all(abs(force.frequency - w) > SAME * w for w in frequencies)
        if force.amplitude and force.frequency and is_new:
            frequencies.append(force.frequency)
    return frequencies


def lines_of(scene: Scene, t: Array, true: Array | None = None) -> Lines | None:
    """The lines of the drives and of their combinations by the spring, and their map from samples
    at t (T,) [s]; None where the samples do not resolve the lines.

    The frequency of a cycle is that of the `true` motion (T,), or approximate without one.
    """
    if has_a_cycle(scene):
        return _lines_of_cycle(scene, t, true)
    (spring,) = scene.all(Spring)
    mass = float(scene.bodies.mass[0])
    if spring.quadratic:
        lines = mixed_lines(drives_of(scene), 2)
    elif spring.cubic:
        lines = mixed_lines(drives_of(scene), 3, odd=True)
    else:
        lines = mixed_lines(drives_of(scene), 1)
    damping = sum(dashpot.damping for dashpot in scene.all(Dashpot))
    if not len(t):
        return None
    free = free_motions(t, spring.stiffness / mass, damping / (2 * mass))
    return _resolved(lines, line_map(t, lines, free))


def _resolved(lines: tuple[Line, ...], rows: Complex | None) -> Lines | None:
    """The lines and their map; None without a map, or if max_k sum_j |l_kj| > AMPLIFIED."""
    if rows is None or np.max(np.sum(np.abs(rows), axis=1)) > AMPLIFIED:
        return None
    return Lines(lines, rows)


def _lines_of_cycle(scene: Scene, t: Array, true: Array | None) -> Lines | None:
    """The lines of a cycle and a drive, and their map from the samples at which the motion is close
    to its cycle; earlier samples have weight 0.

    With the `true` motion (T,) only lines with amplitudes above the residual of all lines are kept.
    """
    (spring,) = scene.all(Spring)
    (dashpot,) = scene.all(Dashpot)
    (drive,) = drives_of(scene)
    mass = float(scene.bodies.mass[0])
    w0 = float(np.sqrt(spring.stiffness / mass))
    mu = -dashpot.damping / mass
    is_settled = t >= FADED / mu
    settled = t[is_settled]
    if len(settled) < FEWEST:
        return None
    # The free cycle, to second order in mu: w = w0 (1 - (mu/w0)^2/16)
    cycle = w0 * (1 - (mu / w0) ** 2 / 16)
    if true is not None:
        cycle = cycle_frequency(settled, true[is_settled], cycle, drive, CYCLE_ORDER)
    lines = cycle_lines(cycle, drive, CYCLE_ORDER)
    rows = np.zeros((len(lines), len(t)), np.complex128)
    of_settled = line_map(settled, lines, np.zeros((0, len(settled))))
    if of_settled is None:
        return None
    rows[:, is_settled] = of_settled
    found = _resolved(lines, rows)
    if found is None or true is None:
        return found
    return _standing_out(found, settled, true[is_settled], of_settled)


def _standing_out(found: Lines, t: Array, x: Array, rows: Complex) -> Lines:
    """The lines whose amplitude exceeds the residual of all lines in x (T,) at t (T,) [s]; `rows`
    (K, T) is their map.
    """
    # |c_k| > max over t of |x(t) - Re sum_k c_k exp(i w_k t)|
    amplitudes = rows @ x
    explained = sum(
        np.real(c * np.exp(1j * line.frequency * t))
        for c, line in zip(amplitudes, found.lines, strict=True)
    )
    left = float(np.max(np.abs(x - explained)))
    kept = np.flatnonzero(np.abs(amplitudes) > left)
    return Lines(tuple(found.lines[k] for k in kept), found.rows[kept])


def _rounding(subject: Subject, truth: SampledTruth, found: Lines) -> Array:
    """Bounds (K,) [m] on the errors of the lines by round-off of the samples and by the radius of
    truth.
    """
    count = found.rows.shape[1]
    # sum over samples of |weight| (COUNTING_FLOOR noise S scale + radius of truth).
    noise = COUNTING_FLOOR * subject.noise(subject.levels[-1]) * truth.growth()[:count]
    scale = subject.instance.quantities[PLACE].scale
    return found.amplified(noise * scale + truth.radius(PLACE)[:count])


def _bounds(
    subject: Subject, truth: SampledTruth, found: Lines, off: list[Array]
) -> tuple[Array, list[str]]:
    """Bounds (K,) [m] on the errors of the lines at the finest level, and the basis of each, from
    the errors `off` (count,) [m] of the samples, level by level.

    The claimed order extrapolates the largest error of any line at coarser levels to the finest
    one; the error of a single line may be zero at a coarser level by chance. A level that differs
    from the finest by more than HORIZON is not used: once the phase is lost, the error of a line is
    bounded by its amplitude, and is no power of the step. Of motions whose phase and amplitude
    drift within the bounds of order 1 or 2, five of 15 740 exceeded a bound from all levels, and
    none of 38 787 this one.
    """
    count = found.rows.shape[1]
    level = subject.levels[-1]
    scale = subject.instance.quantities[PLACE].scale
    # Bound of a line: sum over samples of |weight| (bound scale + radius of truth).
    of_samples = subject.bound(level)[:count] * scale + truth.radius(PLACE)[:count]
    bounds = found.amplified(of_samples)
    basis = ["the error bounds of all samples, each times its weight in the line"] * len(bounds)
    first = len(off) - 1
    while first > 0 and np.max(np.abs(off[first - 1] - off[-1])) <= HORIZON * scale:
        first -= 1
    if len(off) - first > 2:
        followed = replace(subject, levels=subject.levels[first:])
        # Error of line k at each level: |row_k . error of the samples|.
        left = left_at_finest(followed, *(np.abs(found.rows @ error) for error in off[first:]))
        extrapolated = left + _rounding(subject, truth, found)
        for k in np.flatnonzero(extrapolated < bounds):
            basis[k] = (
                f"the largest error of a line with step {followed.levels[0]:.3g} s, extrapolated"
                " with the claimed order"
            )
        bounds = np.minimum(bounds, extrapolated)
    return bounds, basis


def _what(line: Line, true: complex, observed: complex) -> str:
    """The phrase that names the error of a line, with what it is and what it must be."""
    if line.frequency == 0:
        return f"The error of the shift ({observed.real:.6g} m, certified {true.real:.6g} m)"
    return (
        f"The error of the line at {line.name} = {line.frequency:.4g} rad/s (amplitude"
        f" {abs(observed):.6g} m and phase {np.angle(observed):.4f} rad, certified"
        f" {abs(true):.6g} m and {np.angle(true):.4f} rad)"
    )


CHECK = Spectrum()
