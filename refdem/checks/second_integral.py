"""The second integral of the swinging Atwood machine: a pendulum (r, theta) on a string over a
wheel, with a counterweight of three times its mass.

  I = r^2 w (r' cos(theta/2) - r w sin(theta/2)/2) + g r^2 sin(theta/2) cos^2(theta/2)

with w = theta' (Tufillaro 1986). It is conserved for a wheel of radius 0. For a small radius R it
drifts in proportion to R, and a run must have the same drift as truth.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, Sight, certified, judged, no_truth, undecided
from refdem.core.refinement import scored
from refdem.core.variant import Variant
from refdem.scene import Scene
from refdem.scene.elements.string_over_wheel import StringOverWheel
from refdem.scene.elements.uniform_gravity import UniformGravity

TERMS = 8.0
"""Factor from the relative error of the state to that of I, which has three terms of degree five at
most.
"""


class SecondIntegral(Check):
    """The change of I in a run agrees with that of truth: 0 for a wheel of radius 0, else the drift
    due to the radius.
    """

    name = "second-integral"
    title = "Second integral of the swinging machine"
    kills = "a missing centrifugal or Coriolis term, an omitted wheel, a string that slips"
    synchronous = True

    def applies(self, subject: Subject) -> str | None:
        """A string over a wheel without inertia, with a counterweight of three times the pendulum's
        mass.
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
        """One finding: the largest difference between the change of I in the run and in truth."""
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "I", no_truth(subject))]
        allowed = subject.bound(subject.levels[-1])
        count = scored(allowed)
        g = float(np.linalg.norm(gravity(subject.instance.scene)))
        observed = subject.instance.observe(runs[subject.finest].trajectory)
        state = {name: values[:count] for name, values in observed.items()}
        true_state = {name: truth.value(name)[:count] for name in state}
        # I changes its sign with every turn, so that theta must be within half a turn of truth.
        turns = np.round((true_state["theta"] - state["theta"]) / (2 * np.pi))
        state["theta"] = state["theta"] + 2 * np.pi * turns
        # value = max over t of |(I - I(0))_run - (I - I(0))_truth| / max(r^2 |w| |v| + g r^2).
        integral = _integral(state, g)
        true_integral = _integral(true_state, g)
        scale = _largest_term(state, g)
        change = integral - integral[0]
        true_change = true_integral - true_integral[0]
        drift = float(np.max(np.abs(true_change))) / scale
        bound = TERMS * float(allowed[count - 1])
        return [
            judged(
                check=self.name,
                quantity="I",
                value=float(np.max(np.abs(change - true_change))) / scale,
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


def gravity(scene: Scene) -> Array:
    """Sum of all uniform gravity fields (3,) [m/s^2]."""
    total: Array = np.asarray(sum(np.array(field.g) for field in scene.all(UniformGravity)))
    return total


def _largest_term(state: Mapping[str, Array], g: float) -> float:
    """Largest r^2 |w| v + g r^2 over the run, with v the speed of the pendulum: the size of I."""
    # |v|^2 = r'^2 + r^2 w^2,   size = max over t of r^2 |w| |v| + g r^2.
    w = state["thetadot"]
    speed = np.hypot(state["rdot"], state["r"] * w)
    r_squared = state["r"] ** 2
    return float(np.max(r_squared * np.abs(w) * speed + g * r_squared))


def _integral(state: Mapping[str, Array], g: float) -> Array:
    """The second integral I (T,) from r, theta, rdot and thetadot."""
    r = state["r"]
    w = state["thetadot"]
    sine = np.sin(state["theta"] / 2)
    cosine = np.cos(state["theta"] / 2)
    # I = r^2 w (r' cos(theta/2) - r w sin(theta/2)/2) + g r^2 sin(theta/2) cos^2(theta/2).
    integral: Array = (
        r**2 * w * (state["rdot"] * cosine - r * w / 2 * sine) + g * r**2 * sine * cosine**2
    )
    return integral


CHECK = SecondIntegral()
