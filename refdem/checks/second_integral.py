"""Swinging Atwood's machine: the second integral of a pendulum and a mass three times as heavy on a
string over a wheel.

I = r^2 w (r' cos(th/2) - r w sin(th/2)/2) + g r^2 sin(th/2) cos^2(th/2), w = th' (Tufillaro 1986):
kept for a wheel of no size; for a small radius R it drifts in proportion to R, and must be seen to.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, Sight, certified, judged, no_truth, undecided
from refdem.core.refinement import scored
from refdem.core.variant import Variant
from refdem.scene.elements.string_over_wheel import StringOverWheel
from refdem.scene.elements.uniform_gravity import UniformGravity

TERMS = 8.0
"""I is of degree five in the state at most, with three terms."""


class SecondIntegral(Check):
    """The change of the integral along the run agrees with that of truth: 0 for a wheel of zero
    size, else the drift that the radius makes.
    """

    name = "second-integral"
    title = "Second integral of the swinging machine"
    kills = "a missing centrifugal or Coriolis term, an omitted wheel, a string that slips"
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """A string over a wheel of little or no size and inertia, with three times the pendulum's
        mass on the other side.
        """
        scene = subject.instance.scene
        strings = scene.all(StringOverWheel)
        if not strings:
            return "the scene has no string over a wheel"
        pendulum, counter = scene.bodies.mass[[strings[0].a, strings[0].b]]
        if counter == 3 * pendulum and not strings[0].inertia:
            return None
        return "the machine has no second integral"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """The largest difference between its change in the run and in truth."""
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "I", no_truth(subject))]
        allowed = subject.bound(subject.levels[-1])
        count = scored(allowed)
        g = float(
            np.linalg.norm(
                sum(np.array(field.g) for field in subject.instance.scene.all(UniformGravity))
            )
        )
        seen = {
            name: v[:count]
            for name, v in subject.instance.observe(runs[subject.finest].trajectory).items()
        }
        known = {name: truth.value(name)[:count] for name in seen}
        # I changes its sign with every turn, so that theta must be within half a turn of truth.
        turns = np.round((known["theta"] - seen["theta"]) / (2 * np.pi))
        run = _integral({**seen, "theta": seen["theta"] + 2 * np.pi * turns}, g)
        true = _integral(known, g)
        speed = np.hypot(seen["rdot"], seen["r"] * seen["thetadot"])
        size = seen["r"] ** 2
        scale = float(np.max(size * np.abs(seen["thetadot"]) * speed + g * size))
        drift = float(np.max(np.abs(true - true[0]))) / scale
        bound = TERMS * float(allowed[count - 1])
        return [
            judged(
                check=self.name,
                quantity="I",
                value=float(np.max(np.abs((run - run[0]) - (true - true[0])))) / scale,
                bound=bound,
                sight=Sight(bound, 1.0),
                unit="1",
                basis=(
                    f"the error bound of the state for each of {TERMS:g} factors (the integral"
                    f" of the certified values drifts by {drift:.2g})"
                ),
                what=("The error of the change of the second integral, relative to its terms,"),
            )
        ]


def _integral(of: Mapping[str, Array], g: float) -> Array:
    """The second integral I (T,) of r, theta, rdot and thetadot."""
    r = of["r"]
    rate = of["thetadot"]
    sine = np.sin(of["theta"] / 2)
    cosine = np.cos(of["theta"] / 2)
    integral: Array = (
        r**2 * rate * (of["rdot"] * cosine - r * rate / 2 * sine) + g * r**2 * sine * cosine**2
    )
    return integral


CHECK = SecondIntegral()
