"""The growth or decay rate of the whirl of a mass on a rotating shaft.

With z = x + i y from the spring's anchor, m z'' + c z' + (k - i K) z = 0 has two roots q1, q2 of
m q^2 + c q + k - i K = 0, c the sum of all dampings, K the sum of c_j W_j of the fluids that turn.
Whatever the start is,

    a = z' - q2 z   is   a(0) exp(q1 t),

for (d/dt - q1) (d/dt - q2) z = 0. So one state late in a run gives q1 = ln(a(t)/a(0))/t. Its real
part is the rate of growth, positive above the threshold W = w0 (1 + c_e/c_i) and negative below,
and its imaginary part is the angular velocity of the whirl. Both are judged: a mass that does not
move at all has the rate of growth 0, as one at the threshold.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import (
    Array,
    Sight,
    certified,
    judged,
    left_at_finest,
    no_truth,
    undecided,
)
from refdem.core.refinement import COUNTING_FLOOR, scored
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.scene import Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.spring import Spring

Complex = NDArray[np.complex128]

LEAST_PART = 1e-3
"""Smallest |a(0)|, relative to V + |q2| L, of a start from which the growth can be determined."""
LARGEST_ERROR = 0.5
"""Largest relative error of a(t) from which a rate is computed."""


class GrowthRate(Check):
    """The rate of growth in the run is the largest real part of the roots: it decays where the
    equilibrium is stable, and grows where it is not.
    """

    name = "growth"
    title = "Growth rate"
    kills = (
        "damping inside a shaft that does not turn with it, or turns the other way; a method whose"
        " own damping hides an instability, or whose own growth makes one"
    )
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """One point on a linear spring in the plane, dashpots about its anchor, one of which turns;
        a start that has a part in the growth.
        """
        scene = subject.instance.scene
        if not scene.all(RotatingDashpot):
            return "the scene has no fluid that turns"
        if not _is_shaft(scene):
            return "the scene is not one point on a linear spring, damped about its anchor"
        _, second = roots(scene)
        if abs(_start_of(scene, second)) < LEAST_PART * _scale(subject, second):
            return "the start has no part in what grows"
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run of every level."""
        return subject.plain

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """One finding: the error of the rate, at the sample where it is known best."""
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "rate", no_truth(subject))]
        level = subject.levels[-1]
        allowed = subject.bound(level)
        count = scored(allowed)
        first, second = roots(subject.instance.scene)
        off = {
            variant: _off(subject.instance.scene, runs[variant].trajectory)[1:count]
            for variant in subject.plain
            if variant in runs
        }
        since = (subject.instance.times - subject.instance.times[0])[1:count]
        # An error of one scale in each of x, y, vx and vy changes a(t) by at most
        # sqrt(2) (V + |q2| L). Relative to |a(t)| this is
        #     size(t) = sqrt(2) (V + |q2| L) / (|a(0)| exp(Re(q1) t)).
        start = abs(_start_of(subject.instance.scene, second))
        size = np.sqrt(2.0) * _scale(subject, second) / (start * np.exp(first.real * since))
        # Relative error of a(t): size(t) bound(t).
        lost = size * allowed[1:count]
        usable = lost < LARGEST_ERROR
        if not np.any(usable):
            why = "no state of the run is known well enough to determine a rate"
            return [undecided(self.name, "rate", why)]
        # |ln(1 + e)| <= -ln(1 - |e|) for a relative error |e| < 1 of a(t).
        with np.errstate(invalid="ignore", divide="ignore"):
            bounds = np.where(usable, -np.log1p(-lost), np.inf)
        basis = "the error bound of the state at that time, as a part of what has grown until then"
        if len(off) > 2:
            errors = [np.abs(values) for values in off.values()]
            # COUNTING_FLOOR noise(h) size(t) S(t), with the growth S of errors made earlier.
            rounding = COUNTING_FLOOR * subject.noise(level) * size * truth.growth()[1:count]
            extrapolated = left_at_finest(subject, *errors) + rounding
            if np.any(extrapolated < bounds):
                basis = "the error extrapolated from the coarsest step with the claimed order"
            bounds = np.minimum(bounds, np.where(usable, extrapolated, np.inf))
        # The error of q1 is that of ln(a(t)/a(0)) over t. The sample with the smallest bound is
        # judged.
        bounds = bounds / since
        best = int(np.argmin(bounds))
        bound = float(bounds[best])
        error = complex(off[subject.finest][best]) / float(since[best])
        # Re(q1) as observed: ln|a(t)/a(0)|/t.
        rate = first.real + error.real
        return [
            judged(
                check=self.name,
                quantity="rate",
                value=abs(error),
                bound=bound,
                sight=Sight(bound, first.real - second.real),
                unit="1/s",
                basis=f"{basis} (the largest real part of the roots is {first.real:.4g} 1/s)",
                what=(
                    "The error of the complex rate of growth (its real part is"
                    f" {rate:.4g} 1/s until t = {since[best]:g} s)"
                ),
            )
        ]


def roots(scene: Scene) -> tuple[complex, complex]:
    """The roots q1, q2 [1/s] of m q^2 + c q + k - i K, that with the larger real part first."""
    mass = float(scene.bodies.mass[0])
    damping = sum(dashpot.damping for dashpot in scene.all(Dashpot))
    push = 0.0
    for dashpot in scene.all(RotatingDashpot):
        damping += dashpot.damping
        push += dashpot.damping * dashpot.rate[2]
    stiffness = scene.all(Spring)[0].stiffness
    # q = -c/(2 m) +- sqrt((c/(2 m))^2 - k/m + i K/m). The principal root has a real part >= 0.
    middle = -damping / (2 * mass)
    half_gap = np.sqrt(complex(middle**2 - stiffness / mass, push / mass))
    return complex(middle + half_gap), complex(middle - half_gap)


def _is_shaft(scene: Scene) -> bool:
    """True if the equation at the top of this file is that of the scene."""
    springs = scene.all(Spring)
    kinds = (Spring, Dashpot, RotatingDashpot)
    has_other = any(not isinstance(element, kinds) for element in scene.elements)
    if has_other or len(scene.bodies) != 1 or len(springs) != 1 or "dimension:3" in scene.features:
        return False
    (spring,) = springs
    is_linear = spring.exponent == 1 and not spring.quadratic and not spring.cubic
    is_dashpot_linear = not any(dashpot.van_der_pol for dashpot in scene.all(Dashpot))
    is_about_anchor = all(
        link.anchor_b == spring.anchor_b and not any(link.anchor_a)
        for link in (spring, *scene.all(RotatingDashpot))
    )
    is_held = spring.stiffness > 0 and not spring.length and not scene.bodies.fixed.any()
    return is_linear and is_dashpot_linear and is_about_anchor and is_held


def _part(position: Array, velocity: Array, scene: Scene, second: complex) -> Complex:
    """a = z' - q2 z (T,) [m/s] of places and velocities (T, 3)."""
    # a = (vx + i vy) - q2 (x + i y), with x, y from the anchor of the spring.
    place = position - np.array(scene.all(Spring)[0].anchor_b)
    part: Complex = velocity[:, 0] + 1j * velocity[:, 1] - second * (place[:, 0] + 1j * place[:, 1])
    return part


def _start_of(scene: Scene, second: complex) -> complex:
    """a(0) [m/s], of the requested start."""
    return complex(_part(scene.bodies.position, scene.bodies.velocity, scene, second)[0])


def _off(scene: Scene, run: Trajectory) -> Complex:
    """ln(a(t)/(a(0) exp(q1 t))) (T,) along a run: t times the error of q1, its imaginary part in
    (-pi, pi]; infinite where a(t) = 0.
    """
    first, second = roots(scene)
    # a(0) exp(q1 t).
    expected = _start_of(scene, second) * np.exp(first * (run.t - run.t[0]))
    part = _part(run.position[:, 0], run.velocity[:, 0], scene, second)
    with np.errstate(divide="ignore", invalid="ignore"):
        logarithm: Complex = np.log(part / expected)
    return logarithm


def _scale(subject: Subject, second: complex) -> float:
    """V + |q2| L [m/s]: the size of a = z' - q2 z for |z| = L and |z'| = V."""
    scales = subject.instance.scales
    return float(scales.speed + abs(second) * scales.length)


CHECK = GrowthRate()
